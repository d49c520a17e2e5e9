"""Steers smoke: finds the smallest force field that makes an incompressible flow of smoke pass through keyframes.

`solve` and `plan` are the solver, `stable_fluids` searches by another simulator, `track` and `tomography` find flows and densities behind pictures, and `Operator` is a simulation that can
be differentiated. `thurible_smoke.jax` and `thurible_smoke.torch` make a function of it that jax or torch differentiates.
"""

from ._thurible import (
    Condenser,
    Gradient,
    Operator,
    Output,
    Plan,
    Progress,
    Solution,
    StableFluids,
    Tomography,
    Track,
    __version__,
    plan,
    solve,
    stable_fluids,
    tomography,
    track,
)

__all__ = [
    "Condenser",
    "Gradient",
    "Operator",
    "Output",
    "Plan",
    "Progress",
    "Solution",
    "StableFluids",
    "Tomography",
    "Track",
    "__version__",
    "plan",
    "solve",
    "stable_fluids",
    "tomography",
    "track",
]
