"""How smooth the edges of a result are: python3 benches/edges.py RESULT_FOLDER .. (needs numpy, scipy and scikit-image).

Prints a line of a Markdown table for each folder. The contour of a frame is the length of its line of half density over that of the frame
blurred by two cells; in 3D it is that of all layers along z together. Frames are those of the middle half of the animation. Where beside a
folder there is that of the same scene solved with viscosity, NAME_viscous for NAME and NAME_quick, e6 is the energy of the frame in the middle in
waves shorter than six cells over that of the viscous one, which has no teeth.
"""
import json
import sys
from pathlib import Path

import numpy as np
from scipy.fft import dctn
from scipy.ndimage import gaussian_filter
from skimage.measure import find_contours

BLUR = 2.0
SHORT = 6.0


def length(frame, level):
    layers = frame if frame.ndim == 3 else [frame]
    steps = [np.diff(line, axis=0) for layer in layers for line in find_contours(layer, level)]
    return sum(np.sqrt((step**2).sum(axis=1)).sum() for step in steps)


def contour(frame, level):
    sigma = [0] * (frame.ndim - 2) + [BLUR, BLUR]
    return length(frame, level) / length(gaussian_filter(frame, sigma, mode="nearest"), level)


def fine(density):
    frame = density[(len(density) - 1) // 2]
    waves = np.meshgrid(*(np.arange(n) / (2 * n) for n in frame.shape), indexing="ij")
    is_short = sum(wave**2 for wave in waves) > SHORT**-2
    return (dctn(frame, norm="ortho")[is_short] ** 2).sum()


def beside_viscous(folder, density):
    viscous = folder.with_name(folder.name.removesuffix("_quick") + "_viscous")
    if viscous == folder or not viscous.exists():
        return ""
    return f"{fine(density) / fine(np.load(viscous / 'result.npz')['density'].astype(float)):.2f}"


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
        beside_viscous(folder, density),
        errors,
        f"{report['objective']['force_plain']:.3g}",
        f"{report['density_min']:.2f} to {report['density_max']:.2f}",
        f"{report['seconds']['total']:.1f} s",
    ]


def main():
    if not sys.argv[1:]:
        sys.exit(__doc__)
    head = ["result", "transport", "smoothness", "contour: mean, largest", "e6", "keyframe errors", "plain force", "density", "time"]
    for row in [head, ["---"] * len(head), *(line(Path(folder)) for folder in sys.argv[1:])]:
        print("| " + " | ".join(row) + " |")


if __name__ == "__main__":
    main()
