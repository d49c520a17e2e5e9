#!/usr/bin/env python3
"""Simulates a result of Stable Fluids again by NumPy alone: check.py RESULT_FOLDER. The last line is "check: ok" or a fault.

From rho_0, v_0 and the forces of result.npz in double precision to every density and velocity, as docs/stable_fluids.md has the steps; then the forces of
templates from their numbers, the keyframes' errors and all parts of J. A search with weights or regions of keyframes is not for it.
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


def near(name, found, expected, within):
    apart, size = np.max(np.abs(np.asarray(found) - expected), initial=0.0), np.max(np.abs(expected), initial=1e-12)
    if not apart <= within * size:
        fail(f"{name} is off by {apart:.3e} where NumPy has at most {size:.3e}")
    return apart / size


class Box:
    """Cells with a layer of ghosts, arrays (.., y, x)."""

    def __init__(self, cells, rings):
        self.n, self.rings, self.dims, self.longest = cells, rings, len(cells), max(cells)
        shape = tuple(n + 2 for n in reversed(cells))
        places = np.indices(shape).reshape(self.dims, -1)[::-1].T  # x first
        self.shape, self.strides = shape, [int(np.prod(shape[len(shape) - axis :])) for axis in range(self.dims)]
        outside = np.stack([(places[:, axis] == 0) | (places[:, axis] == cells[axis] + 1) for axis in range(self.dims)], 1)
        flat = places @ np.array(self.strides)
        self.inner = flat[~outside.any(1)]
        self.at = places[~outside.any(1)].astype(float)
        # Ghosts by how many axes they lie beyond, each with the places it is the mean of and the axis of each.
        self.ghosts = []
        for order in range(1, self.dims + 1):
            for axes in itertools.combinations(range(self.dims), order):
                which = (outside == [axis in axes for axis in range(self.dims)]).all(1)
                here, ghosts = places[which], flat[which]
                ring = next((axis for axis in axes if rings[axis]), None)
                if ring is not None:
                    step = np.where(here[:, ring] == 0, cells[ring], -cells[ring]) * self.strides[ring]
                    self.ghosts.append((ghosts, [(ghosts + step, None)]))
                else:
                    inward = lambda axis: ghosts + np.where(here[:, axis] == 0, 1, -1) * self.strides[axis]
                    self.ghosts.append((ghosts, [(inward(axis), axis if order == 1 else None) for axis in axes]))
        diagonal = places[~outside.any(1)].sum(1)
        self.diagonals = [self.inner[diagonal == d] for d in range(diagonal.min(), diagonal.max() + 1)]

    def fill(self, x, component):
        """The ghosts of a scalar (component None) or a component."""
        for ghosts, sources in self.ghosts:
            x[ghosts] = sum((-x[at] if axis is not None and axis == component else x[at]) for at, axis in sources) / len(sources)
        return x

    def padded(self, field, component):
        x = np.zeros(int(np.prod(self.shape)))
        x[self.inner] = field.ravel()
        return self.fill(x, component)

    def beside(self, at):
        return [at + sign * stride for stride in self.strides for sign in (-1, 1)]

    def relax(self, x, right, a, c, component, sweeps):
        """Gauss-Seidel: a diagonal reads the one before it as it is now, and the next as it was."""
        self.fill(x, component)
        for _ in range(sweeps):
            for at in self.diagonals:
                x[at] = (right[at] + a * sum(x[place] for place in self.beside(at))) / c
            self.fill(x, component)
        return x

    def diffuse(self, x, k, component, sweeps):
        if k == 0.0:
            return self.fill(x, component)
        a = k * self.longest**2
        return self.relax(x.copy(), x, a, 1 + 2 * self.dims * a, component, sweeps)

    def project(self, v, choices):
        at, m = self.inner, self.longest
        div = np.zeros_like(v[0])
        div[at] = -0.5 / m * sum(v[axis][at + stride] - v[axis][at - stride] for axis, stride in enumerate(self.strides))
        p = np.zeros_like(div)
        if choices["pressure"] == "gauss_seidel":
            p = self.relax(p, div, 1.0, 2.0 * self.dims, None, choices["sweeps"])
        else:
            p = self.conjugate(p, div, choices)
        self.fill(p, None)
        for axis, stride in enumerate(self.strides):
            v[axis][at] -= 0.5 * m * (p[at + stride] - p[at - stride])
            self.fill(v[axis], axis)

    def conjugate(self, x, f, choices):
        at = self.inner
        diagonal = np.full(len(at), 2.0 * self.dims)
        for axis, n in enumerate(self.n):
            if not self.rings[axis]:
                diagonal -= (self.at[:, axis] == 1) | (self.at[:, axis] == n)
        r, p, before = f[at].copy(), np.zeros_like(f), None
        first = np.sum(r * r / diagonal)
        for _ in range(choices["cg_iterations"]):
            rho = np.sum(r * r / diagonal)
            if rho <= choices["cg_tolerance"] ** 2 * first:
                break
            p[at] = r / diagonal + (0.0 if before is None else rho / before) * p[at]
            self.fill(p, None)
            q = 2 * self.dims * p[at] - sum(p[place] for place in self.beside(at))
            alpha = rho / np.sum(p[at] * q)
            x[at] += alpha * p[at]
            r -= alpha * q
            before = rho
        return x

    def advect(self, x, v):
        """Linear in the cells around where each cell came from."""
        low, part = [], []
        for axis, n in enumerate(self.n):
            place = self.at[:, axis] - self.longest * v[axis][self.inner]
            place = (place - 0.5) % n + 0.5 if self.rings[axis] else np.clip(place, 0.5, n + 0.5)
            low.append(np.floor(place).astype(int))
            part.append(place - low[-1])
        out = np.zeros_like(x)
        for corner in itertools.product((0, 1), repeat=self.dims):
            weight = np.prod([s if up else 1 - s for s, up in zip(part, corner)], axis=0)
            out[self.inner] += weight * x[sum((k + up) * stride for k, up, stride in zip(low, corner, self.strides))]
        return out


def metric(e, filters, rings):
    """C e, each Gaussian added tap by tap; `e` and `rings` with x last."""
    total = e.copy()
    for j in range(1, filters + 1):
        sigma = 2.0 ** (j - 1)
        radius = int(np.ceil(3 * sigma))
        taps = np.exp(-0.5 * (np.arange(-radius, radius + 1) / sigma) ** 2)
        taps /= taps.sum()
        blurred = e
        for _ in range(2):
            for axis, ring in enumerate(rings):
                n = blurred.shape[axis]
                places = np.arange(n)
                out = np.zeros_like(blurred)
                for offset, tap in zip(range(-radius, radius + 1), taps):
                    at = (places + offset) % (n if ring else 2 * n)
                    out += tap * np.take(blurred, np.where(at < n, at, 2 * n - 1 - at), axis)
                blurred = out
        total += blurred
    return total


def template_force(template, arrays, index, step, cells, length):
    """What template `index` pushes with in a step, in the scene's units, components first."""
    dims, h = len(cells), length / max(cells)
    if not template["from"] <= step < template["to"]:
        return 0.0
    amplitude = arrays[f"template_{index}_amplitude"][(step - template["from"]) // template["interval"]]
    center, radius = arrays[f"template_{index}_center"], float(arrays[f"template_{index}_radius"])
    away = [(np.indices(tuple(reversed(cells)))[dims - 1 - axis] + 0.5) * h - center[axis] for axis in range(dims)]
    w = np.exp(-sum(d * d for d in away) / (2 * radius**2))
    if template["kind"] == "wind":
        return np.stack([a * w for a in amplitude])
    if dims == 2:
        return amplitude[0] / radius * w * np.stack([-away[1], away[0]])
    return w / radius * np.cross(amplitude, np.stack(away, -1)).transpose(3, 0, 1, 2)


def main(folder):
    report = json.loads((folder / "report.json").read_text())
    with np.load(folder / "result.npz") as archive:
        arrays = {name: archive[name].astype(float) for name in archive.files}
    if report.get("velocity_location") != "center":
        fail("this is no result of Stable Fluids")
    choices, cells, steps = report["stable_fluids"], report["cells"], report["steps"]
    dt, length, dims = report["dt"], report["length"], len(cells)
    rings = [end == "periodic" for end in report["boundary"]]
    within = 1e-9 if report["precision"] == "f64" else 1e-3
    box = Box(cells, rings)
    axes = "xyz"[:dims]
    velocity = np.stack([arrays[f"velocity_{axis}"] for axis in axes], 1)
    force = np.stack([arrays[f"force_{axis}"] for axis in axes], 1)
    pushes = dt * dt / length
    viscosity, diffusion = (k * dt / length**2 for k in (report["viscosity"], choices["diffusion"]))
    lift = [a * pushes for a in report["acceleration"]]

    rho = box.padded(arrays["density"][0], None)
    v = [box.padded(velocity[0, axis] * dt / length, axis) for axis in range(dims)]
    worst = {"density": 0.0, "velocity": 0.0}
    for step in range(steps):
        moved = []
        for axis in range(dims):
            pushed = v[axis].copy()
            pushed[box.inner] += pushes * force[step, axis].ravel() + lift[axis] * rho[box.inner]
            moved.append(box.diffuse(pushed, viscosity, axis, choices["sweeps"]))
        box.project(moved, choices)
        v = [box.fill(box.advect(moved[axis], moved), axis) for axis in range(dims)]
        box.project(v, choices)
        spread = box.diffuse(rho, diffusion, None, choices["sweeps"])
        rho = box.fill(box.advect(spread, v), None)
        shape = arrays["density"][0].shape
        found = rho[box.inner].reshape(shape)
        worst["density"] = max(worst["density"], near(f"the density of step {step + 1}", arrays["density"][step + 1], found, within))
        flow = np.stack([part[box.inner].reshape(shape) for part in v]) * length / dt
        worst["velocity"] = max(worst["velocity"], near(f"the velocity of step {step + 1}", velocity[step + 1], flow, within))

    if "forces" not in choices["control"]:
        for step in range(steps):
            pushed = np.zeros_like(force[step])
            for index, template in enumerate(report.get("templates", [])):
                pushed = pushed + template_force(template, arrays, index, step, cells, length)
            near(f"the force of step {step}", force[step], pushed, within)

    data = 0.0
    for row, target in zip(report["keyframes"], arrays.get("keyframe_density", [])):
        e = arrays["density"][row["step"]] - target
        data += 0.5 * np.sum(e * metric(e, report["filters"], list(reversed(rings))))
        near("the error of a keyframe", row["relative_l2"], np.linalg.norm(e) / np.linalg.norm(target), max(within, 1e-6))
        near("the mass at a keyframe", row["mass_ratio"], arrays["density"][row["step"]].sum() / arrays["density"][0].sum(), 1e-12)
    objective = report["objective"]
    near("the data term", objective["data"], data, max(within, 1e-8))
    near("the price of the forces", objective["force"], 0.5 * report["force_weight"] * np.sum(force**2), max(within, 1e-8))
    given = tomllib.loads(report["scene"]).get("control", {}).get("initial_velocity")
    if "initial_velocity" in choices["control"] and given is None:
        near("the price of the velocity", objective["initial"], 0.5 * choices["initial_weight"] * np.sum(velocity[0] ** 2), max(within, 1e-8))
    print(f"densities to {worst['density']:.1e}, velocities to {worst['velocity']:.1e}")
    print("check: ok")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
