#!/usr/bin/env python3
"""Tomography and deconvolution beside scikit-image: the tables of docs/tomography.md and docs/deblur.md.

    python3 benches/tomography.py [--thurible target/release/thurible] [--quick] [tomography|deblur|prototype|patches|novel|figures ...]

Needs numpy, scipy and scikit-image. Tomography: the modified Shepp-Logan phantom, its line integrals exact (four rays a pixel), as many
parallel views as the row says, over half a circle. RMS over the cells whose truth is the mean over 8 x 8 places. Deconvolution: 96 x 96
pixels of flat shapes, blurred with their surroundings, noise of 0.005. `prototype`: other images, with the columns of the prototype that the
method was tried with. `patches`: the objective by pixels and by patches beside the convex optimum. `novel`: a view that is left out, made up with
a volume and without. Seconds are of the processor, reading and writing included.
"""
import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

# Value, half axes, centre, angle in degrees (Toft 1996).
ELLIPSES = [
    (1.0, 0.69, 0.92, 0.0, 0.0, 0.0), (-0.8, 0.6624, 0.874, 0.0, -0.0184, 0.0),
    (-0.2, 0.11, 0.31, 0.22, 0.0, -18.0), (-0.2, 0.16, 0.41, -0.22, 0.0, 18.0),
    (0.1, 0.21, 0.25, 0.0, 0.35, 0.0), (0.1, 0.046, 0.046, 0.0, 0.1, 0.0),
    (0.1, 0.046, 0.046, 0.0, -0.1, 0.0), (0.1, 0.046, 0.023, -0.08, -0.605, 0.0),
    (0.1, 0.023, 0.023, 0.0, -0.606, 0.0), (0.1, 0.023, 0.046, 0.06, -0.605, 0.0),
]


def phantom(n, fine=8, shift=0.0, flip=False):
    at = ((np.arange(n * fine) + 0.5) / fine - shift) / n * 2 - 1
    x, y = np.meshgrid(at, -at if flip else at)
    image = np.zeros_like(x)
    for value, a, b, cx, cy, degrees in ELLIPSES:
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        u, v = ((x - cx) * c + (y - cy) * s) / a, ((y - cy) * c - (x - cx) * s) / b
        image += value * (u * u + v * v <= 1)
    return image.reshape(n, fine, n, fine).mean(axis=(1, 3))


def sinogram(n, views, fine=4, shift=0.0):
    """Integrals along the rays of cameras turned by 180 k / views degrees, in cells."""
    offset = ((np.arange(n * fine) + 0.5) / fine - shift - n / 2) / (n / 2)
    rows = []
    for turn in np.pi * np.arange(views) / views:
        row = np.zeros_like(offset)
        for value, a, b, cx, cy, degrees in ELLIPSES:
            c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
            t = offset - (np.cos(turn) * cx + np.sin(turn) * cy)
            u, v = (np.cos(turn) * c + np.sin(turn) * s) * a, (np.sin(turn) * c - np.cos(turn) * s) * b
            w = u * u + v * v
            row += value * 2 * a * b * np.sqrt(np.maximum(w - t * t, 0)) / w
        rows.append(row.reshape(n, fine).mean(axis=1) * n / 2)
    return np.array(rows)


def run(arguments):
    done = subprocess.run(arguments, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, arguments))}: {done.stderr}")


def reconstruct(options, folder, n, views, settings):
    q, truth = sinogram(n, views), phantom(n)
    np.savez(folder / "q.npz", **{f"c{k}": row[None] for k, row in enumerate(q)})
    np.save(folder / "truth.npy", truth[None])
    text = f"[box]\ncells = [{n}, {n}]\nlength = {n}\n[truth]\nfile = \"truth.npy\"\n"
    for k in range(views):
        text += f"[[camera]]\nazimuth = {180 * k / views}\npitch = 1\nfile = \"q.npz\"\narray = \"c{k}\"\n"
    (folder / "views.toml").write_text(text)
    out = folder / "out"
    more = [part for key, value in settings.items() for part in ("--set", f"tomography.{key}={value}")]
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    run([options.thurible, "tomography", folder, "-o", out, "--quiet", "--force", "--threads", "1", *more])
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    report = json.loads((out / "report.json").read_text())
    history = report["history"]
    return [entry["rms_error"] for entry in history], history[-1]["mutations"], seconds


def rival_sart(n, views, sweeps):
    from skimage.transform import iradon_sart

    # Its axis goes through the middle of pixel n // 2, and its rows may run either way: it gets its own pictures and its own truth.
    q, angles = sinogram(n, views, shift=0.5).T, 180 * np.arange(views) / views
    truths = [phantom(n, shift=0.5), phantom(n, shift=0.5, flip=True)]
    image, errors, start = None, [], time.process_time()
    for _ in range(sweeps):
        image = iradon_sart(q, theta=angles, image=image, clip=(0, 10))
        errors.append(min(float(np.sqrt(np.mean((image - truth) ** 2))) for truth in truths))
    return errors, time.process_time() - start


def tomography(options):
    print("| cells, views | SART 10 sweeps, best of 40 | scikit-image's SART, best of 20 | walk | walk, p >= 0 | L2 | TV | SAD | SAD: CPU seconds, million mutations each |")
    print("|---|---|---|---|---|---|---|---|---|")
    sizes = [(128, 5), (128, 10), (128, 16), (128, 20)] + ([] if options.quick else [(256, 16)])
    for n, views in sizes:
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            budget = {"budget": 1e7 if n > 128 else 6e6, "tolerance": 0}
            sart = reconstruct(options, folder, n, views, {"method": "sart", "sweeps": 40})[0]
            rival, seconds = rival_sart(n, views, 20)
            cells = [f"{n}^2, {views}", f"{sart[9]:.4f}, {min(sart):.4f}", f"{min(rival):.4f} ({seconds:.1f} s)"]
            for prior, gamma, nonnegative in [("none", 0, "false"), ("none", 0, "true"), ("l2", 0.2, "true"),
                                              ("tv", 0.5, "true"), ("sad", 0.15, "true")]:
                errors, mutations, seconds = reconstruct(
                    options, folder, n, views, {**budget, "prior": prior, "gamma": gamma * n / 128, "nonnegative": nonnegative})
                cells.append(f"{errors[-1]:.4f}")
            cells.append(f"{seconds:.2f}, {mutations / 1e6 / seconds:.1f}")
            print("| " + " | ".join(cells) + " |", flush=True)


def shapes(n, border, fine=8):
    at = (np.arange((n + 2 * border) * fine) + 0.5) / fine - border
    x, y = np.meshgrid(at / n, at / n)
    image = np.full_like(x, 0.2)
    image[np.hypot(x - 0.3, y - 0.35) < 0.2] = 0.8
    image[(x > 0.55) & (x < 0.9) & (y > 0.1) & (y < 0.4)] = 0.5
    image[np.abs(x - 0.65) + np.abs(y - 0.7) < 0.2] = 0.95
    image[(x < 0.25) & (y > 0.65) & (y < 0.92)] = 0.05
    image[(np.floor(x * 40) % 3 == 0) & (y > 0.55) & (y < 0.62) & (x > 0.05) & (x < 0.45)] = 1.0
    side = n + 2 * border
    return image.reshape(side, fine, side, fine).mean(axis=(1, 3))


def kernel(name):
    fine = 16
    radius = 5 if name == "motion" else 3
    at = (np.arange((2 * radius + 1) * fine) + 0.5) / fine - radius - 0.5
    x, y = np.meshgrid(at, at)
    if name == "motion":
        c, s = np.cos(np.radians(30)), -np.sin(np.radians(30))
        f = (np.abs(x * c + y * s) <= 5.5) & (np.abs(y * c - x * s) <= 0.5)
    else:
        f = np.hypot(x, y) <= 3
    side = 2 * radius + 1
    f = f.reshape(side, fine, side, fine).mean(axis=(1, 3))
    return f / f.sum(), radius


def psnr(image, truth):
    return -10 * np.log10(np.mean((image - truth) ** 2))


def deblur(options):
    from scipy.signal import convolve2d
    from skimage.restoration import richardson_lucy

    print("| kernel | blurred | scikit-image's Richardson-Lucy, best of 100 | ours, best of 100 | wiener | primal-dual on atv, objective | walk: none | tv | atv, objective | sparse | gamma | seconds: scikit-image's, ours, tv |")
    print("|---|---|---|---|---|---|---|---|---|---|---|---|")
    for name in ("motion", "disc"):
        f, radius = kernel(name)
        n = 96
        wide = shapes(n, radius)
        truth = wide[radius:-radius, radius:-radius]
        q = np.maximum(convolve2d(wide, f, mode="valid") + 0.005 * np.random.default_rng(7).standard_normal((n, n)), 0)
        image, best = q.copy(), 0.0
        for iteration in range(1, 101, 3):
            image = richardson_lucy(q, f, num_iter=iteration, clip=False)
            best = max(best, psnr(image, truth))
        begun = time.process_time()
        richardson_lucy(q, f, num_iter=100, clip=False)
        seconds = [time.process_time() - begun]
        cells = [name, f"{psnr(q, truth):.1f}", f"{best:.1f}"]
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            for key, value in (("q", q), ("f", f), ("truth", truth)):
                np.save(folder / f"{key}.npy", value)

            def by(*more):
                before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
                run([options.thurible, "deblur", folder / "q.npy", "--psf", folder / "f.npy", "--truth", folder / "truth.npy",
                     "-o", folder / "out", "--quiet", "--force", "--precision", "f64", *map(str, more)])
                if "richardson_lucy" in more or "tv" in more:
                    seconds.append(resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before)
                return json.loads((folder / "out/report.json").read_text())

            lucy = by("--method", "richardson_lucy", "--iterations", 100)
            cells.append(f"{max(entry['psnr'] for entry in lucy['history']):.1f}")
            cells.append(f"{by('--method', 'wiener', '--iterations', 100)['psnr']:.1f}")
            convex = by("--method", "primal_dual", "--gamma", 3e-4, "--iterations", 300 if options.quick else 2000)
            cells.append(f"{convex['psnr']:.1f}, {convex['history'][-1]['objective']:.4f}")
            for prior, gamma in (("none", 0), ("tv", 3e-4), ("atv", 3e-4), ("sparse", 1e-4), ("gamma", 1e-4)):
                found = by("--prior", prior, "--gamma", gamma, "--tau", 0.8)
                energy = f", {found['history'][-1]['objective']:.4f}" if prior == "atv" else ""
                cells.append(f"{found['psnr']:.1f}{energy}")
        cells.append(", ".join(f"{each:.2f}" for each in seconds))
        print("| " + " | ".join(cells) + " |", flush=True)


def images96(border):
    """Images of 96 x 96 pixels with their surroundings: a photograph made smaller, a piece of it, the drawing."""
    from skimage.data import camera
    from skimage.transform import resize

    photo = camera() / 255.0
    small = resize(photo, (96 + 2 * border, 96 + 2 * border), anti_aliasing=True)
    return {"photograph, made smaller": small, "a piece of it": photo[90 - border:186 + border, 180 - border:276 + border],
            "drawing": shapes(96, border)}


def taken(wide, f, radius, seed=7):
    from scipy.signal import convolve2d

    q = convolve2d(wide, f, mode="valid")
    return np.maximum(q + 0.005 * np.random.default_rng(seed).standard_normal(q.shape), 0), wide[radius:-radius, radius:-radius]


class Desk:
    """A folder in which one image after the other is made sharp; CPU seconds of the last."""

    def __init__(self, options, folder, q, f, truth):
        self.options, self.folder = options, Path(folder)
        for key, value in (("q", q), ("f", f), ("truth", truth)):
            np.save(self.folder / f"{key}.npy", value)

    def by(self, *more):
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        run([self.options.thurible, "deblur", self.folder / "q.npy", "--psf", self.folder / "f.npy", "--truth", self.folder / "truth.npy",
             "-o", self.folder / "out", "--quiet", "--force", "--precision", "f64", *map(str, more)])
        self.seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
        return json.loads((self.folder / "out/report.json").read_text())

    def image(self):
        return np.load(self.folder / "out/result.npz")["image"]


PRIORS = [("none", 0), ("tv", 3e-4), ("atv", 3e-4), ("sparse", 1e-4), ("gamma", 1e-4)]


def prototype(options):
    print("| image, kernel | blurred | Richardson-Lucy, best of 100 | none | TV | ATV | sparse | gamma | outermost 6: Richardson-Lucy, TV | saturated: unmasked, Richardson-Lucy, masked | seconds, TV |")
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    print("| the prototype's, motion | 20.6 | 24.4 | 21.2 | 34.0 | 32.9 | 31.7 | 33.9 | | | |")
    print("| the prototype's, disc | 21.4 | 25.9 | 19.0 | 33.4 | 33.4 | 32.3 | 33.5 | 24.8, 32.5 | 13.6, 19.8, 31.5 | 1.1 to 6 |")
    rim = np.ones((96, 96), bool)
    rim[6:-6, 6:-6] = False
    for name in ("motion", "disc"):
        f, radius = kernel(name)
        for label, wide in images96(radius).items():
            q, truth = taken(wide, f, radius)
            cells = [f"{label}, {name}", f"{psnr(q, truth):.1f}"]
            with tempfile.TemporaryDirectory() as folder:
                desk = Desk(options, folder, q, f, truth)
                lucy = desk.by("--method", "richardson_lucy", "--iterations", 100)
                errors = [entry["psnr"] for entry in lucy["history"]]
                best = 1 + int(np.argmax(errors))
                cells.append(f"{max(errors):.1f}")
                desk.by("--method", "richardson_lucy", "--iterations", best)
                edges = [psnr(desk.image()[rim], truth[rim])]
                for prior, gamma in PRIORS:
                    cells.append(f"{desk.by('--prior', prior, '--gamma', gamma)['psnr']:.1f}")
                    if prior == "tv":
                        edges.append(psnr(desk.image()[rim], truth[rim]))
                        seconds = desk.seconds
                cells.append(", ".join(f"{edge:.1f}" for edge in edges))
                # The light is such that 5.6 % of the pixels burn out; the others are scored.
                bright = np.quantile(q, 1 - 0.056)
                burnt = q >= bright
                desk = Desk(options, folder, np.minimum(q, bright) / bright, f, truth / bright)
                rest = lambda image: psnr(image[~burnt], truth[~burnt] / bright)
                row = []
                for more in (("--prior", "tv"), ("--method", "richardson_lucy", "--iterations", best), ("--prior", "tv", "--saturation", 1 - 1e-9)):
                    desk.by(*more)
                    row.append(f"{rest(desk.image()):.1f}")
                cells += [", ".join(row), f"{seconds:.1f}"]
            print("| " + " | ".join(cells) + " |", flush=True)


def patches(options):
    print("| kernel, gamma | primal-dual, 2000 iterations | pixels, after 100 and 300 a pixel | patches, after 100 and 300 | CPU seconds to 100: pixels, patches | PSNR: primal-dual, pixels, patches |")
    print("|---|---|---|---|---|---|")
    for name in ("disc", "motion"):
        f, radius = kernel(name)
        q, truth = taken(shapes(96, radius), f, radius)
        for gamma in (3e-4, 1e-3):
            with tempfile.TemporaryDirectory() as folder:
                desk = Desk(options, folder, q, f, truth)
                convex = desk.by("--method", "primal_dual", "--gamma", gamma, "--iterations", 2000)
                least = convex["history"][-1]["objective"]
                cells, seconds, sharp = [f"{name}, {gamma:g}", f"{least:.4f}"], [], [convex["psnr"]]
                for move in ("pixel", "patch"):
                    row = []
                    for budget in (100,) if options.quick else (100, 300):
                        found = desk.by("--prior", "atv", "--gamma", gamma, "--move", move, "--budget", budget)
                        objective = found["history"][-1]["objective"]
                        row.append(f"{objective:.4f} ({100 * (objective / least - 1):+.1f} %)")
                        if budget == 100:
                            seconds.append(f"{desk.seconds:.1f}")
                            sharp.append(found["psnr"])
                    cells.append(", ".join(row))
                cells += [", ".join(seconds), ", ".join(f"{value:.1f}" for value in sharp)]
            print("| " + " | ".join(cells) + " |", flush=True)


def plates(path, images, zoom):
    """A row of grey pictures, 0 dark, 1 bright."""
    from skimage.io import imsave

    gap = np.ones((images[0].shape[0] * zoom, 6), np.uint8) * 255
    row = []
    for image in images:
        row += [np.kron((255 * np.clip(image, 0, 1) + 0.5).astype(np.uint8), np.ones((zoom, zoom), np.uint8)), gap]
    imsave(path, np.hstack(row[:-1]), check_contrast=False)


def cloud(n, seed=3):
    """Blobs of smoke in a box."""
    rng = np.random.default_rng(seed)
    at = (np.arange(n) + 0.5) / n
    z, y, x = np.meshgrid(at, at, at, indexing="ij")
    density = np.zeros((n, n, n))
    for _ in range(14):
        a, b, c = rng.uniform(0.3, 0.7, 3)
        density += rng.uniform(0.5, 1.5) * np.exp(-((x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2) / (2 * rng.uniform(0.04, 0.09) ** 2))
    return density * (density > 0.02)


def novel(options):
    """A cloud in 40^3 cells: eight cameras around it at 15 degrees, and one view that is left out of them."""
    n, wide = 40, 60
    from scipy.ndimage import map_coordinates

    density = cloud(n)

    def seen(azimuth, elevation, fine=2):
        """Integrals along parallel rays, in cells."""
        turn, rise = np.radians(azimuth), np.radians(elevation)
        way = np.array([-np.sin(turn) * np.cos(rise), np.cos(turn) * np.cos(rise), -np.sin(rise)])
        across = np.cross(way, [0, 0, 1])
        across /= np.linalg.norm(across)
        down = np.cross(way, across)
        at = (np.arange(wide * fine) + 0.5) / fine - wide / 2
        v, u, t = np.meshgrid(at, at, np.arange(-36, 36, 0.5), indexing="ij")
        place = n / 2 + u[..., None] * across + v[..., None] * down + t[..., None] * way
        picture = map_coordinates(density, np.moveaxis(place, -1, 0)[::-1] - 0.5, order=1).sum(-1) * 0.5
        return picture.reshape(wide, fine, wide, fine).mean((1, 3))

    views = [(45 * k, 15) for k in range(8)] + [(22.5, 15)]
    print("| cameras | prior | what is kept | planned bytes | CPU seconds | novel view: RMS in parts of the true one |")
    print("|---|---|---|---:|---:|---:|")
    shown = []
    for count in (3, 8):
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            text = f"[box]\ncells = [{n}, {n}, {n}]\nlength = {n}\n"
            chosen = views[:8:3] if count == 3 else views[:8]
            for number, (azimuth, elevation) in enumerate([*chosen, views[-1]]):
                np.save(folder / f"c{number}.npy", seen(azimuth, elevation))
                kind = "novel" if number == count else "camera"
                text += f"[[{kind}]]\nazimuth = {azimuth}\nelevation = {elevation}\npitch = 1\nfile = \"c{number}.npy\"\n"
            (folder / "views.toml").write_text(text)
            truth = np.load(folder / f"c{count}.npy")
            ways = [("none", []), ("sad", []), ("tv", [])]
            for prior in ("image_tv", "image_sad"):
                ways += [(prior, []), (prior, ["--set", "tomography.volume=true"])]
            for prior, more in ways:
                before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
                run([options.thurible, "tomography", folder, "-o", folder / "out", "--quiet", "--force", "--threads", "1",
                     "--set", f'tomography.prior="{prior}"', "--set", "tomography.budget=1e7", *more, *(part for text in options.set for part in ("--set", text))])
                seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
                report = json.loads((folder / "out/report.json").read_text())
                kept = "views and volume" if report["tomography"]["volume"] else "views alone"
                print(f"| {count} | {prior} | {kept} | {report['memory']['planned_bytes']:,} | {seconds:.1f} | {report['novel'][0]['relative_error']:.4f} |", flush=True)
                if count == 3 and (prior, bool(more)) in [("none", False), ("sad", False), ("image_tv", False)]:
                    shown.append(np.load(folder / "out/result.npz")["novel_0"][0] / truth.max())
            if count == 3:
                shown.append(truth / truth.max())
    plates("docs/images/novel.png", shown, 4)


def figures(options):
    """docs/images/tomography.png: the phantom, SART, the walk without a prior and with SAD, 16 views. docs/images/deblur.png: a disc's blur,
    Richardson-Lucy, the walk with tv, the truth."""
    images = [phantom(128)[::-1]]
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for settings in ({"method": "sart", "sweeps": 40}, {"prior": "none", "nonnegative": "false", "budget": 6e6},
                         {"prior": "sad", "gamma": 0.15, "budget": 6e6}):
            reconstruct(options, folder, 128, 16, settings)
            images.append(np.load(folder / "out/result.npz")["density"][0][::-1])
        plates("docs/images/tomography.png", images, 2)
        f, radius = kernel("disc")
        from scipy.signal import convolve2d

        wide = shapes(96, radius)
        truth = wide[radius:-radius, radius:-radius]
        q = np.maximum(convolve2d(wide, f, mode="valid") + 0.005 * np.random.default_rng(7).standard_normal((96, 96)), 0)
        np.save(folder / "q.npy", q)
        np.save(folder / "f.npy", f)
        images = [q]
        for more in (["--method", "richardson_lucy", "--iterations", "60"], ["--prior", "tv", "--tau", "0.8"]):
            run([options.thurible, "deblur", folder / "q.npy", "--psf", folder / "f.npy", "-o", folder / "d", "--quiet", "--force", *more])
            images.append(np.load(folder / "d/result.npz")["image"])
        plates("docs/images/deblur.png", images + [truth], 3)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--thurible", default="target/release/thurible")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--set", action="append", default=[], type=lambda text: text, help="of tomography, for `novel`: --set=tomography.gamma=1")
    parser.add_argument("tables", nargs="*", default=["tomography", "deblur"])
    options = parser.parse_args()
    for table in options.tables:
        {"tomography": tomography, "deblur": deblur, "prototype": prototype, "patches": patches, "novel": novel, "figures": figures}[table](options)
        print()


if __name__ == "__main__":
    main()
