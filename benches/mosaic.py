#!/usr/bin/env python3
"""Mosaic, the public benchmark of differentiable solvers (arXiv 2606.27895), task F3, with thurible among its solvers.

    git clone https://github.com/pasteurlabs/mosaic
    python3 -m venv venv && venv/bin/pip install 'jax[cpu]' optax exponax equinox phiflow warp-lang xlb scipy 'tesseract-core[runtime]' tesseract-jax \\
        rich typer pandas matplotlib psutil pyyaml filelock nvidia-ml-py docker mosaic/mosaic/mosaic_shared wheels/thurible_smoke-*.whl
    venv/bin/python benches/mosaic.py mosaic docs/mosaic.md

Initial velocities, inputs, losses, checks by differences and the optimiser are Mosaic's own code, from its checkout; every solver is its own
`tesseract_api.py`, ours is examples/python/mosaic. Each solver runs in a process of its own on this machine's processors. Prints lines of
JSON and puts the tables between the marks of the page.

Other solvers of the task cannot be run so: PICT asks for CUDA, INS.jl for Julia, OpenFOAM has no gradient.
"""
import argparse
import json
import pathlib
import re
import resource
import subprocess
import sys
import time

SOLVERS = {"thurible": "thurible", "exponax": "Exponax", "phiflow": "PhiFlow", "warp-ns": "Warp-NS", "xlb": "XLB"}
HORIZONS = [10, 100, 1000]
SEEDS = [0, 1, 2]
MARKS = "<!-- begin mosaic -->", "<!-- end mosaic -->"
HERE = pathlib.Path(__file__).resolve().parent.parent


class Bench:
    """A solver inside Mosaic's own problem."""

    def __init__(self, checkout, solver):
        sys.path[:0] = [str(checkout), str(checkout / "mosaic")]
        import jax.numpy as jnp
        import numpy as np
        from tesseract_core import Tesseract

        from mosaic.benchmarks.problems.navier_stokes_3d_grid import ics, optimization
        from mosaic.benchmarks.problems.shared import gradient
        from mosaic.benchmarks.problems.shared.optimization import _run_lbfgs

        self.jnp, self.np, self.ics, self.gradient = jnp, np, ics, gradient
        self.project, self.lbfgs = optimization._project_divergence_free_jax, _run_lbfgs
        ours = HERE / "examples/python/mosaic/tesseract_api.py"
        theirs = checkout / "mosaic/tesseracts/navier-stokes-grid" / solver / "tesseract_api.py"
        self.tesseract = Tesseract.from_tesseract_api(ours if solver == "thurible" else theirs)
        self.extent = float(2 * np.pi)

    def inputs(self, v0, nu, dt, steps):
        scalar = lambda x: self.jnp.array([x], self.jnp.float32)
        return {"v0": v0, "viscosity": scalar(nu), "dt": scalar(dt), "steps": steps, "domain_extent": self.extent}

    def end(self, v0, *physics):
        from tesseract_jax import apply_tesseract

        return apply_tesseract(self.tesseract, self.inputs(v0, *physics))["result"]

    def horizon(self, steps):
        """The gradient of |v_N|^2 by v_0 and how it agrees with differences (N = 20, nu = 0.001, dt = 0.05, Taylor-Green)."""
        jnp, np = self.jnp, self.np
        v0 = self.ics._tgv3d(20)
        physics = 0.001, 0.05, steps
        grad = lambda: np.asarray(self.gradient._vjp_grad(self.tesseract, self.inputs(v0, *physics), "result", "v0"))
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        begun = time.perf_counter()
        g = grad()
        first = time.perf_counter() - begun
        begun = time.perf_counter()
        if first < 60:
            g = grad()
        seconds = time.perf_counter() - begun if first < 60 else first
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        finite = bool(np.isfinite(g).all())
        row = {"steps": steps, "finite": finite, "seconds": seconds, "mebibytes": (peak - before) / 1024}
        if not finite:
            return row
        # Differences along the gradient itself, smooth and of the flow's size, with the best of several steps as Mosaic takes them.
        norm = float(np.linalg.norm(g.astype(np.float64)))
        along = jnp.asarray(g / norm)
        scale = float(jnp.sqrt(jnp.sum(v0**2)))
        energy = lambda v: float(np.sum(np.asarray(self.end(v, *physics), np.float64) ** 2))
        errors = []
        for eps in (1e-1, 1e-2, 1e-3) if steps < 1000 else (1e-2, 1e-3):
            h = eps * scale
            difference = (energy(v0 + h * along) - energy(v0 - h * along)) / (2 * h)
            errors.append(abs(difference - norm) / norm)
        return row | {"norm": norm, "difference": min(errors)}

    def vortex(self):
        """The error of the two-dimensional Taylor-Green vortex, which only decays, by exp(-2 nu t): N = 16, nu = 0.05, dt = 0.05, 10 steps."""
        np = self.np
        at = np.arange(16) * self.extent / 16
        x, y = at[:, None, None], at[None, :, None]
        u, v = np.sin(x) * np.cos(y), -np.cos(x) * np.sin(y)
        start = np.broadcast_to(np.stack([u, v, 0 * u], -1), (16, 16, 16, 3)).astype(np.float32)
        exact = start * np.exp(-2 * 0.05 * 0.5)
        found = np.asarray(self.end(self.jnp.asarray(start), 0.05, 0.05, 10))
        return {"error": float(np.linalg.norm(found - exact) / np.linalg.norm(exact))}

    def differences(self):
        """Mosaic's gradient/fd_check: N = 16, nu = 0.001, dt = 0.05, 10 steps, 10 directions, the best of six steps."""
        np = self.np
        from types import SimpleNamespace

        v0 = self.ics._tgv3d(16)
        context = SimpleNamespace(
            name="", ic=v0, phys={}, ic_key="v0", output_key="result", seed=0,
            make_inputs=lambda _name, v, **_: self.inputs(v, 0.001, 0.05, 10),
        )  # fmt: skip
        sizes = [5e0, 1e0, 1e-1, 1e-2, 1e-3, 1e-4]
        _, _, _, ours, by_size = self.gradient._fd_vjp_arrays(self.tesseract, context, sizes, 10)
        errors = {eps: float(np.median(np.abs(fd - ours) / (np.abs(fd) + 1e-30))) for eps, fd in by_size.items()}
        best = min(errors, key=errors.get)
        return {"error": errors[best], "cosine": self.gradient._fd_cosine(by_size[best], ours)}

    def recovery(self):
        """Mosaic's recovery of an initial velocity: N = 16, nu = 0.01, dt = 0.02, 100 steps, L-BFGS from rest, 100 iterations."""
        jnp, np = self.jnp, self.np
        physics = 0.01, 0.02, 100
        errors, losses = [], []
        begun = time.perf_counter()
        for seed in SEEDS:
            truth = self.project(self.ics._rand_div_free_3d(16, seed=seed), self.extent)
            target = self.end(truth, *physics)
            size = jnp.sum(target**2)
            loss = lambda v: jnp.sum((self.end(v, *physics) - target) ** 2) / size
            project = lambda g: self.project(g, self.extent)
            found, history, _ = self.lbfgs(loss, jnp.zeros_like(truth), max_iters=100, grad_proj_fn=project)
            errors.append(float(jnp.linalg.norm(found - truth) / jnp.linalg.norm(truth)))
            losses.append(history[-1])
        return {"error": float(np.mean(errors)), "loss": float(np.mean(losses)), "seconds": (time.perf_counter() - begun) / len(SEEDS)}


def one(checkout, solver, task):
    bench = Bench(checkout, solver)
    name, _, steps = task.partition(":")
    result = bench.horizon(int(steps)) if name == "horizon" else getattr(bench, name)()
    print(json.dumps({"solver": solver, "task": task} | result))


def measured(checkout, solver, task, limit):
    """A task in a process of its own; what it said, or how it failed."""
    command = [sys.executable, __file__, str(checkout), "--solver", solver, "--task", task]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=limit)
    except subprocess.TimeoutExpired:
        return {"failed": f"longer than {limit} s"}
    rows = [json.loads(line) for line in done.stdout.splitlines() if line.startswith('{"solver"')]
    said = done.stderr.strip().splitlines()
    return rows[-1] if rows else {"failed": said[-1] if said else f"ended with {done.returncode}"}


def cell(row, key, form):
    if "failed" in row:
        return "failed"
    value = row.get(key)
    return "NaN" if value is None else format(value, form)


def main(checkout, page, limit):
    tasks = ["vortex", "differences", *(f"horizon:{steps}" for steps in HORIZONS), "recovery"]
    rows = {}
    for solver in SOLVERS:
        for task in tasks:
            rows[solver, task] = row = measured(checkout, solver, task, limit)
            print(json.dumps({"solver": solver, "task": task} | row), flush=True)
    head = ["solver", "vortex: error", "differences: error", "cosine"]
    for steps in HORIZONS:
        head += [f"{steps} steps: seconds", "MiB", "norm of gradient", "error"]
    gradients = ["| " + " | ".join(head) + " |", "|---|" + "---:|" * (len(head) - 1)]
    recovered = ["| solver | error of v_0 | loss | seconds |", "|---|---:|---:|---:|"]
    for solver, name in SOLVERS.items():
        row = rows[solver, "differences"]
        cells = [name, cell(rows[solver, "vortex"], "error", ".1e"), cell(row, "error", ".1e"), cell(row, "cosine", ".5f")]
        for steps in HORIZONS:
            row = rows[solver, f"horizon:{steps}"]
            cells += [cell(row, "seconds", ".2f"), cell(row, "mebibytes", ".0f"), cell(row, "norm", ".3g"), cell(row, "difference", ".1e")]
        gradients.append("| " + " | ".join(cells) + " |")
        row = rows[solver, "recovery"]
        recovered.append("| " + " | ".join([name, cell(row, "error", ".1e"), cell(row, "loss", ".1e"), cell(row, "seconds", ".0f")]) + " |")
    begin, end = map(re.escape, MARKS)
    text = "\n\n".join([MARKS[0], "\n".join(gradients), "\n".join(recovered), MARKS[1]])
    page.write_text(re.sub(f"{begin}.*?{end}", lambda _: text, page.read_text(), count=1, flags=re.DOTALL))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("checkout", type=pathlib.Path, help="Mosaic's sources")
    parser.add_argument("page", type=pathlib.Path, nargs="?", help="the page whose tables are written")
    parser.add_argument("--solver", choices=SOLVERS, help="one solver alone")
    parser.add_argument("--task", help="one task alone: vortex, differences, horizon:STEPS or recovery")
    parser.add_argument("--limit", type=float, default=1200, help="seconds for each task")
    args = parser.parse_args()
    if args.solver and args.task:
        one(args.checkout.resolve(), args.solver, args.task)
    elif args.page:
        main(args.checkout.resolve(), args.page, args.limit)
    else:
        parser.error("a page, or --solver and --task")
