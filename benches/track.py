#!/usr/bin/env python3
"""How well and how fast `thurible track` finds a flow, beside other programs' optical flow on the same frames: a part of docs/track.md.

    python3 -m venv venv && venv/bin/pip install numpy scipy scikit-image opencv-python-headless
    venv/bin/python benches/track.py target/release/thurible WORK [blobs] [inflow] [--only-ours] [--speed] [--emission]

Simulates the truth at 128 x 256 with four implicit steps a frame, restricts it to 64 x 128 and 60 frames (kept in WORK), tracks it, and prints
a table: means over the pairs 20 to 58 of the error in cells a frame (RMS), in parts of the true flow, and of the angle in degrees, and the
seconds that a processor works for a pair, reading, writing and the page included. With --speed a pair at 128 x 256 and one at
100 x 200 x 100 too. With --emission what is known of the inflow is told: errors beside it and away from it, with and without. OpenCV is
measured where it is installed.
"""
import json
import pathlib
import resource
import subprocess
import sys
import time

import numpy as np
from scipy.ndimage import gaussian_filter

FINE, FRAMES, SUBSTEPS = (128, 256), 60, 4
SCORED = slice(20, 59)
METHODS = {
    "direct": [],
    "ADMM, 5 iterations": ["--method", "admm"],
    "ADMM without kinetic energy": ["--method", "admm", "--beta", "0"],
    "direct, every pair alone": ["--set", "track.independent=true"],
    "Horn-Schunck with a price of divergence": ["--method", "horn_schunck", "--set", "track.gamma=100"],
    "Horn-Schunck": ["--method", "horn_schunck"],
}


def texture(rng, shape, sigma):
    noise = gaussian_filter(rng.standard_normal(shape), sigma, mode="nearest")
    return (noise - noise.min()) / np.ptp(noise)


def weak_flow(rng, folder):
    """A random flow without divergence that the tracker does not know, at most 0.15 cells a step."""
    nx, ny = FINE
    stream = gaussian_filter(rng.standard_normal((ny + 1, nx + 1)), 12)
    stream[[0, -1]] = 0
    stream[:, [0, -1]] = 0
    u, v = np.diff(stream, axis=0), -np.diff(stream, axis=1)
    scale = 0.15 / max(np.abs(u).max(), np.abs(v).max())
    np.savez(folder / "start.npz", velocity_x=u * scale, velocity_y=v * scale)


def scene(name, folder):
    """The scene of a truth, in cells and steps of the fine grid."""
    nx, ny = FINE
    rng = np.random.default_rng({"blobs": 1, "inflow": 2}[name])
    y, x = np.mgrid[:ny, :nx] + 0.5
    weak_flow(rng, folder)
    steps = SUBSTEPS * (FRAMES - 1)
    head = f"""[grid]
cells = [{nx}, {ny}]
length = {ny}.0
[time]
steps = {steps}
[control]
initial_velocity = {{ file = "start.npz" }}
[output]
frames = false
"""
    fine = texture(rng, (ny, nx), 2.5)
    if name == "blobs":
        smoke = sum(np.exp(-(((x - a) ** 2 + (y - b) ** 2) / r**2) ** 2) for a, b, r in [(44, 40, 20), (84, 52, 17), (62, 92, 14)])
        np.save(folder / "source.npy", np.clip(smoke, 0, 1) * (0.25 + 0.75 * fine))
        return head + '[source]\nfile = "source.npy"\n[flow]\nbuoyancy = 0.045\n'
    vent = np.exp(-(((x - 64) / 14) ** 4) - ((y - 14) / 8) ** 4)
    np.save(folder / "vent.npy", vent * (0.2 + 0.8 * fine))
    text = head + "[flow]\nbuoyancy = 0.06\n"
    for begin in range(0, steps, 24):
        end = min(begin + 16, steps)
        text += f'[[emitter]]\nfrom = {begin}\nto = {end}\nrate = 0.08\nfile = "vent.npy"\n'
    return text


def truth(program, name, work):
    """Frames and flows of the truth on the coarse grid, in cells a frame."""
    done = work / f"{name}.npz"
    if not done.exists():
        folder = work / name
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "scene.toml").write_text(scene(name, folder))
        run = [program, "simulate", folder / "scene.toml", "-o", folder / "flow", "--precision", "f32", "--quiet"]
        subprocess.run(run, check=True)
        with np.load(folder / "flow" / "result.npz") as fine:
            density = fine["density"][::SUBSTEPS].astype(float)
            u, v = (fine[f"velocity_{a}"].astype(float) for a in "xy")
        density = density.reshape(len(density), FINE[1] // 2, 2, FINE[0] // 2, 2).mean((2, 4))
        # Each component is the mean over the two fine faces of a coarse one, and a frame the sum of its steps, in coarse cells.
        together = lambda w: w.reshape(-1, SUBSTEPS, *w.shape[1:]).sum(1) / 2
        u = together(u[:, :, ::2].reshape(len(u), FINE[1] // 2, 2, -1).mean(2))
        v = together(v[:, ::2].reshape(len(v), FINE[1] // 2 + 1, FINE[0] // 2, 2).mean(3))
        np.savez(done, density=density, velocity_x=u, velocity_y=v)
    with np.load(done) as z:
        return z["density"], z["velocity_x"], z["velocity_y"]


def centres(u, v):
    return np.stack([0.5 * (u[..., 1:] + u[..., :-1]), 0.5 * (v[..., 1:, :] + v[..., :-1, :])], -1)


def errors(ours, true):
    """RMS, relative and angular error of the flow of a pair at cell centres."""
    gap = np.sqrt(((ours - true) ** 2).sum(-1).mean())
    size, own = np.linalg.norm(true, axis=-1), np.linalg.norm(ours, axis=-1)
    cross, dot = ours[..., 0] * true[..., 1] - ours[..., 1] * true[..., 0], (ours * true).sum(-1)
    angle = np.where(own == 0, 90.0, np.degrees(np.arctan2(np.abs(cross), dot)))
    return gap, gap / np.sqrt((size**2).mean()), np.sqrt((size * angle**2).sum() / size.sum())


def worked():
    """Seconds that processors have worked for programs that have ended."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def track(program, frames, folder, more):
    """The report, and the seconds that a processor worked for a pair."""
    before = worked()
    subprocess.run([program, "track", frames, "-o", folder, "--quiet", "--force", *more], check=True)
    report = json.loads((folder / "report.json").read_text())
    return report, (worked() - before) / report["steps"]


def ours(program, name, work, threads):
    rows = []
    longest = f"capture.length={max(FINE) // 2}"
    for label, more in METHODS.items():
        folder = work / f"{name}_{label.split(',')[0].replace(' ', '_')}_{len(more)}"
        report, seconds = track(program, work / f"{name}.npz", folder, [*more, "--set", longest, *threads])
        history = report["history"]
        keys = ["velocity_rms_error", "velocity_relative_error", "angular_error"]
        found = [[pair[key] for key in keys] for pair in history[SCORED]]
        rows.append((f"thurible, {label}", np.mean(found, 0), seconds))
    return rows


def others(name, work):
    """Optical flow of OpenCV and scikit-image, each pair alone, as its defaults have it."""
    ways = {}
    try:
        import cv2

        cv2.setNumThreads(1)
        dis = cv2.DISOpticalFlow_create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
        ways["OpenCV, Farneback"] = lambda a, b: cv2.calcOpticalFlowFarneback(a, b, None, 0.5, 3, 15, 3, 5, 1.2, 0)
        ways["OpenCV, DIS (medium)"] = lambda a, b: dis.calc(a, b, None)
        if hasattr(cv2, "optflow"):
            tvl1 = cv2.optflow.DualTVL1OpticalFlow_create()
            ways["OpenCV, TV-L1"] = lambda a, b: tvl1.calc(a, b, None)
    except ImportError:
        print("OpenCV is not installed, so it is not measured", file=sys.stderr)
    from skimage.registration import optical_flow_ilk, optical_flow_tvl1

    ways["scikit-image, TV-L1"] = lambda a, b: optical_flow_tvl1(a / 255.0, b / 255.0)[::-1].transpose(1, 2, 0)
    ways["scikit-image, ILK"] = lambda a, b: optical_flow_ilk(a / 255.0, b / 255.0)[::-1].transpose(1, 2, 0)
    with np.load(work / f"{name}.npz") as z:
        frames, true = z["density"], centres(z["velocity_x"], z["velocity_y"])
    levels = np.clip(255 * frames / frames.max(), 0, 255).round().astype(np.uint8)
    rows = []
    for label, way in ways.items():
        begun = time.process_time()
        flows = [way(a, b) for a, b in zip(levels, levels[1:])]
        seconds = (time.process_time() - begun) / len(flows)
        found = [errors(np.asarray(flow, float), t) for flow, t in zip(flows, true)]
        rows.append((label, np.mean(found[SCORED], 0), seconds))
    return rows


def speed(program, work, threads):
    """Seconds of a pair on large grids, of which the second is predicted from the first."""
    rng = np.random.default_rng(3)
    for label, shape, frames in [("128 x 256", (256, 128), 8), ("100 x 200 x 100", (100, 200, 100), 3)]:
        still = gaussian_filter(rng.standard_normal([n + 8 for n in shape]), 3)
        still = np.clip(still / still.std(), 0, None)
        cut = lambda k: still[tuple(slice(k, k + n) for n in shape)].astype(np.float32)
        path = work / f"speed_{len(shape)}.npy"
        np.save(path, np.stack([cut(k) for k in range(frames)]))
        report, spent = track(program, path, work / f"speed_{len(shape)}d", threads)
        seconds = [pair["seconds"] for pair in report["history"]]
        memory = report["memory"]["planned_bytes"] / 2**20
        print(f"{label}: seconds a pair {', '.join(f'{s:.3f}' for s in seconds)}, of a processor {spent:.3f}; {memory:.0f} MiB, {report['threads']} threads")


def emission(program, work, threads):
    """The inflow with what was made between frames and without: errors at the vent, around it and elsewhere."""
    truth(program, "inflow", work)
    with np.load(work / "inflow" / "flow" / "result.npz") as fine:
        made = fine["emission"].astype(float)
    made = made.reshape(-1, SUBSTEPS, FINE[1] // 2, 2, FINE[0] // 2, 2).mean((3, 5)).sum(1)
    np.savez(work / "made.npz", emission=made)
    vent = np.load(work / "inflow" / "vent.npy").reshape(FINE[1] // 2, 2, FINE[0] // 2, 2).mean((1, 3)) > 0.1
    around = gaussian_filter(vent.astype(float), 4) > 0.02
    places = {"at the vent": vent, "within some 8 cells of it": around & ~vent, "elsewhere": ~around}
    print("\n| method | emission | " + " | ".join(f"{place}: RMS, parts" for place in places) + " | re-advection after 59 pairs |")
    print("|---|---|" + "---:|" * (len(places) + 1))
    with np.load(work / "inflow.npz") as z:
        true = centres(z["velocity_x"], z["velocity_y"])
    for label in ("direct", "ADMM, 5 iterations", "direct, every pair alone"):
        for told in ("none", "made.npz"):
            folder = work / f"emission_{told[:4]}"
            more = [*METHODS[label], "--set", f"capture.length={max(FINE) // 2}", "--set", f'capture.emission="{told}"', *threads]
            report, _ = track(program, work / "inflow.npz", folder, more)
            with np.load(folder / "result.npz") as z:
                found = centres(z["velocity_x"].astype(float), z["velocity_y"].astype(float))
            row = []
            for place in places.values():
                gap, size = (found - true)[SCORED][:, place], true[SCORED][:, place]
                rms = np.sqrt((gap**2).sum(-1).mean(-1))
                row.append(f"{rms.mean():.3f}, {(rms / np.sqrt((size**2).sum(-1).mean(-1))).mean():.3f}")
            last = report["history"][-1]["readvection_error"]
            print(f"| {label} | {'known' if told != 'none' else 'not known'} | " + " | ".join(row) + f" | {last:.2f} |", flush=True)


def main(program, work, *more):
    work = pathlib.Path(work)
    work.mkdir(parents=True, exist_ok=True)
    threads = ["--threads", "1"]
    if "--speed" in more:
        speed(program, work, ["--threads", "2"])
    if "--emission" in more:
        return emission(program, work, threads)
    for name in [name for name in ("blobs", "inflow") if name in more] or ["blobs", "inflow"]:
        frames, u, v = truth(program, name, work)
        fastest = np.linalg.norm(centres(u, v), axis=-1).max()
        print(f"\n{name}: {len(frames)} frames of {frames.shape[2]} x {frames.shape[1]}, up to {fastest:.1f} cells a frame\n")
        print("| program, method | RMS, cells a frame | in parts of the true flow | angle, degrees | processor's seconds a pair |\n|---|---:|---:|---:|---:|")
        rows = ours(program, name, work, threads) + ([] if "--only-ours" in more else others(name, work))
        for label, (rms, relative, angle), seconds in rows:
            print(f"| {label} | {rms:.3f} | {relative:.3f} | {angle:.1f} | {seconds:.3f} |", flush=True)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
