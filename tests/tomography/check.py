#!/usr/bin/env python3
"""Recomputes a result of `thurible tomography` by NumPy alone: check.py VIEWS_FOLDER RESULT_FOLDER. The last line is "check: ok" or a fault.

Pictures from the views, F of the density by bilinear samples at the centres of the cells, the residual, both parts of the objective, the
visual hull, the error against the truth. Takes views as `thurible photograph` writes them: one npz of pictures, orthographic or pinhole.
"""
import itertools
import json
import sys
import tomllib
from pathlib import Path

import numpy as np


def fail(text):
    print(f"check: {text}")
    sys.exit(1)


def close(name, found, expected, within):
    if not abs(found - expected) <= within * max(abs(expected), 1e-12):
        fail(f"{name} is {found}, and {expected} by NumPy")


def see(camera, x, dims):
    """Pixel coordinates of places, and 1 over the area that a pixel covers there; lengths in cells."""
    across, down, forward, at = (np.array(camera[key], float) for key in ("across", "down", "forward", "at"))
    if camera["eye"] is None:
        way, depth = x, 1.0
        weight = np.full(len(x), camera["pitch"] ** (1.0 - dims))
    else:
        way = x - np.array(camera["eye"])
        depth = way @ forward
        focal = np.linalg.norm(across)
        weight = (focal / depth) ** (dims - 1) * np.linalg.norm(way, axis=1) / depth
    u, v = way @ across / depth + at[0], way @ down / depth + at[1]
    return np.stack([u, v], 1), weight


def touched(where, pixels, dims):
    """Pixels about points: (index, weight, inside) for each corner."""
    low = np.floor(where - 0.5).astype(int)
    part = where - 0.5 - low
    for corner in itertools.product((0, 1), repeat=dims - 1):
        place = low[:, : dims - 1] + corner
        weight = np.prod(np.where(corner, part[:, : dims - 1], 1 - part[:, : dims - 1]), axis=1)
        inside = np.all((place >= 0) & (place < np.array(pixels[: dims - 1])), axis=1)
        y = place[:, 1] if dims == 3 else 0
        yield np.where(inside, place[:, 0] + pixels[0] * y, 0), weight, inside


def gamma(prior, p):
    if prior == "none":
        return 0.0
    if prior == "sad":
        total = 0.0
        for offset in itertools.product((-1, 0, 1), repeat=p.ndim):
            if offset > (0,) * p.ndim:
                one = tuple(slice(max(0, -o), p.shape[a] - max(0, o)) for a, o in enumerate(offset))
                other = tuple(slice(max(0, o), p.shape[a] - max(0, -o)) for a, o in enumerate(offset))
                total += np.abs(p[one] - p[other]).sum()
        return total
    if prior == "tv":
        return np.sqrt(sum(np.diff(p, axis=a, append=p.take([-1], a)) ** 2 for a in range(p.ndim))).sum()
    lap = sum(np.diff(p, axis=a, append=p.take([-1], a)) - np.diff(p, axis=a, prepend=p.take([0], a)) for a in range(p.ndim))
    return 0.5 * (lap**2).sum()


def main():
    views, result = map(Path, sys.argv[1:3])
    report = json.loads((result / "report.json").read_text())
    scene = tomllib.loads((views / "views.toml").read_text())
    arrays, pictures = np.load(result / "result.npz"), np.load(views / "pictures.npz")
    settings, cells = report["tomography"], report["cells"]
    dims = len(cells)
    density = arrays["density"].astype(float)
    if density.shape != (report["steps"] + 1, *reversed(cells)) or not np.isfinite(density).all():
        fail("the density has another shape, or is not finite")
    if settings["nonnegative"] and density.min() < 0:
        fail(f"the density falls to {density.min()}")
    axes = np.meshgrid(*[np.arange(n) + 0.5 for n in reversed(cells)], indexing="ij")
    x = np.zeros((density[0].size, 3))
    for axis in range(dims):
        x[:, axis] = axes[dims - 1 - axis].ravel()
    for frame in range(len(density)):
        p = density[frame]
        data = square = off = 0.0
        hull = np.ones(len(x), bool)
        for k, camera in enumerate(report["cameras"]):
            q = pictures[scene["camera"][k]["array"]][frame].astype(float).ravel()
            shown = arrays[f"reprojection_{k}"][frame].astype(float).ravel()
            where, weight = see(camera, x, dims)
            image, lit, any_pixel = np.zeros_like(q), np.zeros(len(x), bool), np.zeros(len(x), bool)
            for index, part, inside in touched(where, camera["pixels"], dims):
                np.add.at(image, index, inside * part * weight * p.ravel())
                lit |= inside & (q[index] > settings["hull_threshold"])
                any_pixel |= inside
            hull &= lit | ~any_pixel
            data += 0.5 * ((q - shown) ** 2).sum()
            square += (q**2).sum()
            off += ((image - shown) ** 2).sum()
        entries = [entry for entry in report["history"] if entry["frame"] == frame]
        if not entries:
            if p.any():
                fail(f"frame {frame}: no iteration, and there is smoke")
            continue
        last = entries[-1]
        digits = 1e-3 if report["precision"] == "f32" else 1e-6
        close("data", last["data"], data, digits)
        close("residual", last["residual_relative"], np.sqrt(2 * data / square), digits)
        close("prior", last["prior"], settings["gamma"] * gamma(settings["prior"], p), digits)
        # Samples lie anywhere, so the centres of the cells see them a little blurred.
        if np.sqrt(off / square) > 0.08:
            fail(f"frame {frame}: the reprojection is {np.sqrt(off / square):.3f} from F of the density")
        # A sample within the hull reaches the centres of the cells around it.
        reach = hull.reshape(p.shape)
        for a in range(dims):
            wide = np.pad(reach, [(1, 1) if b == a else (0, 0) for b in range(dims)])
            reach = reach | wide.take(range(0, p.shape[a]), a) | wide.take(range(2, p.shape[a] + 2), a)
        leak = p[~reach].sum() / p.sum()
        if leak > 0.02:
            fail(f"frame {frame}: {100 * leak:.1f} % of the density is outside of the visual hull")
        if "truth" in scene:
            truth = np.load(views / scene["truth"]["file"])[scene["truth"]["array"]][frame]
            close("rms_error", last["rms_error"], np.sqrt(((p - truth) ** 2).mean()), digits)
    for one, other in zip(report["history"], report["history"][1:]):
        if one["frame"] == other["frame"] and settings["method"] == "walk":
            if other["data"] + other["prior"] > (one["data"] + one["prior"]) * (1 + 1e-4):
                fail("the objective rises")
    print(f"frames {len(density)}, cameras {len(report['cameras'])}, RMS error {report['rms_error']}")
    print("check: ok")


if __name__ == "__main__":
    main()
