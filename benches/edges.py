"""How smooth the edges of a result are: python3 benches/edges.py RESULT_FOLDER .. (needs numpy, scipy and scikit-image).

Prints a line of a Markdown table for each folder. The contour of a frame is the length of its line of half density over that of the frame
blurred by two cells; in 3D it is that of all layers along z together. Frames are those of the middle half of the animation.
"""
import json
import sys
from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter
from skimage.measure import find_contours

BLUR = 2.0


def length(frame, level):
    layers = frame if frame.ndim == 3 else [frame]
    steps = [np.diff(line, axis=0) for layer in layers for line in find_contours(layer, level)]
    return sum(np.sqrt((step**2).sum(axis=1)).sum() for step in steps)


def contour(frame, level):
    sigma = [0] * (frame.ndim - 2) + [BLUR, BLUR]
    return length(frame, level) / length(gaussian_filter(frame, sigma, mode="nearest"), level)


def line(folder):
    report = json.loads((folder / "report.json").read_text())
    density = np.load(folder / "result.npz")["density"].astype(float)
    steps = len(density) - 1
    frames = density[steps // 4 : steps - steps // 4 + 1]
    contours = [contour(frame, 0.5 * density[0].max()) for frame in frames]
    smoothness = report["force_smoothness"] * max(report["cells"]) / report["length"]
    errors = ", ".join(f"{100 * keyframe['relative_l2']:.1f} %" for keyframe in report["keyframes"])
    return [
        folder.name,
        report["advection"]["scheme"],
        f"{smoothness:.3g}",
        f"{np.mean(contours):.3f}, {np.max(contours):.3f}",
        errors,
        f"{report['objective']['force_plain']:.3g}",
        f"{report['density_min']:.2f} to {report['density_max']:.2f}",
        f"{report['seconds']['total']:.1f} s",
    ]


def main():
    if not sys.argv[1:]:
        sys.exit(__doc__)
    head = ["result", "transport", "smoothness", "contour: mean, largest", "keyframe errors", "plain force", "density", "time"]
    for row in [head, ["---"] * len(head), *(line(Path(folder)) for folder in sys.argv[1:])]:
        print("| " + " | ".join(row) + " |")


if __name__ == "__main__":
    main()
