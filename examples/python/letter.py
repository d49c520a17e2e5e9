"""A circle of smoke becomes the letter F, in Python.

    pip install numpy matplotlib        # and thurible_smoke: see docs/python.md
    python examples/python/letter.py

draws the smoke and the objective into letter.png. Without matplotlib it solves all the same and says what is missing.
"""

# %% What is given: a disc of smoke, and strokes that make a letter.
import argparse

import numpy as np
import thurible_smoke

arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
arguments.add_argument("--cells", type=int, default=64, help="cells along each side")
arguments.add_argument("--steps", type=int, default=24)
arguments.add_argument("--iterations", type=int, default=40)
arguments.add_argument("--plot", default="letter.png", help="where the plot goes")
choices = arguments.parse_args()

side = (np.arange(choices.cells, dtype=np.float32) + 0.5) / choices.cells
y, x = np.meshgrid(side, side, indexing="ij")


def smooth(distance):
    """Smoke where the distance is negative, with an edge of about one cell."""
    return 0.5 - 0.5 * np.tanh(distance * choices.cells)


def stroke(left, right, low, high):
    """A box of smoke."""
    return smooth(np.maximum(np.maximum(left - x, x - right), np.maximum(low - y, y - high)))


disc = smooth(np.hypot(x - 0.5, y - 0.5) - 0.18)
letter = np.maximum.reduce([stroke(0.32, 0.42, 0.2, 0.8), stroke(0.32, 0.68, 0.7, 0.8), stroke(0.32, 0.6, 0.46, 0.56)])

# %% What it takes.
plan = thurible_smoke.plan(disc.shape, [choices.steps], dtype=disc.dtype)
print(f"{plan.bytes:,} bytes on {plan.threads} threads")

# %% The solve. The callback hears every iteration; other threads of Python run meanwhile.
found = thurible_smoke.solve(
    disc,
    {choices.steps: letter},
    iterations=choices.iterations,
    progress=lambda entry: print(f"{entry.iteration:4} {entry.cells}  objective {entry.objective:.4e}"),
)
print(found)

# %% What came of it.
mass = found.density.sum(axis=(1, 2), dtype=np.float64)
velocity_x, velocity_y = found.velocity
divergence = np.diff(velocity_x, axis=2) + np.diff(velocity_y, axis=1)
target = letter * found.mass_factors[0]
print(f"smoke kept to {np.abs(mass / mass[0] - 1).max():.1e}")
print(f"divergence {np.abs(divergence).max() / np.abs(velocity_x).max():.1e} of the fastest flow")
print(f"the letter missed by {np.linalg.norm(found.density[-1] - target) / np.linalg.norm(target):.1%}")

# %% The plot.
try:
    import matplotlib
except ImportError:
    raise SystemExit("there is no matplotlib, so there is no plot: pip install matplotlib") from None

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402

figure, axes = pyplot.subplots(1, 5, figsize=(14, 3.2), layout="constrained")
for place, step in zip(axes, np.linspace(0, choices.steps, 4).astype(int)):
    place.imshow(found.density[step], origin="lower", cmap="bone", vmin=0, vmax=1)
    place.set(title=f"step {step}", xticks=[], yticks=[])
finest = [entry for entry in found.history if entry.cells in (None, [choices.cells] * 2)]
axes[4].semilogy([entry.iteration for entry in finest], [entry.objective for entry in finest])
axes[4].set(title="objective", xlabel="iteration")
figure.savefig(choices.plot, dpi=120)
print(f"plot in {choices.plot}")
