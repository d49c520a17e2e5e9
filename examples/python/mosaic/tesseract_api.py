"""thurible as a solver of Mosaic (https://github.com/pasteurlabs/mosaic): a Tesseract for its task F3, recovery of an initial velocity.

Mosaic gives velocities at the nodes of a periodic grid. Here a node is the middle of a cell, and a velocity is shifted by half a cell along its own
axis to the cell's face, and back at the end, by the Fourier series that the nodes have: the shift back is the adjoint of the shift.
"""

from functools import lru_cache
from typing import Any

import numpy as np
import thurible_smoke
from mosaic_shared.problems.navier_stokes_grid import InputSchema as _Inputs
from mosaic_shared.problems.navier_stokes_grid import OutputSchema as _Outputs
from mosaic_shared.schema_types import make_differentiable
from pydantic import model_validator


class InputSchema(make_differentiable(_Inputs, ["v0"])):
    """A periodic box of equal sides without obstacles."""

    @model_validator(mode="after")
    def _check(self) -> "InputSchema":
        if not self.boundary_conditions.is_fully_periodic or self.obstacle is not None:
            raise ValueError("this solver takes periodic boxes without obstacles here")
        if len({*self.v0.shape[:-1]}) != 1:
            raise ValueError("this solver takes cubes here")
        return self


class OutputSchema(make_differentiable(_Outputs, ["result"])):
    """The velocity of the last step."""


def shifted(field: np.ndarray, axis: int, cells: float) -> np.ndarray:
    """The Fourier series of a real field, moved up an axis: number i is what stood at i - cells. The highest wave of an even number of nodes, which
    has no half, goes."""
    n = field.shape[axis]
    waves = np.fft.rfftfreq(n)
    turn = np.exp(-2j * np.pi * waves * cells)
    if n % 2 == 0:
        turn[-1] = 0
    shape = [1] * field.ndim
    shape[axis] = -1
    return np.fft.irfft(np.fft.rfft(field, axis=axis) * turn.reshape(shape), n, axis)


def to_faces(v: np.ndarray) -> tuple[np.ndarray, ...]:
    """(nx, ny, nz, 3) at the middles of cells to the lower faces, component by component, as (nz, ny, nx)."""
    parts = (shifted(np.asarray(v[..., axis], np.float64), axis, 0.5) for axis in range(3))
    return tuple(np.ascontiguousarray(part.T) for part in parts)


def to_nodes(faces: tuple[np.ndarray, ...]) -> np.ndarray:
    """What `to_faces` is the adjoint of, and but for the highest wave the inverse of."""
    parts = [shifted(np.asarray(face).T, axis, -0.5) for axis, face in enumerate(faces)]
    return np.stack(parts, axis=-1).astype(np.float32)


@lru_cache(maxsize=4)
def operator(n: int, steps: int, dt: float, viscosity: float, extent: float) -> thurible_smoke.Operator:
    """The simulation, planned once."""
    return thurible_smoke.Operator(
        (n, n, n), steps, dt=dt, length=extent, viscosity=viscosity, boundary="periodic", slots=32 if steps > 100 else "auto"
    )


# The last run: a gradient is asked for where a value was.
last: tuple[Any, ...] = (None, None, ())


def simulated(inputs: InputSchema) -> tuple[thurible_smoke.Operator, tuple[np.ndarray, ...]]:
    """The operator after a simulation, and the velocity of its last step."""
    global last
    n = inputs.v0.shape[0]
    scalars = float(inputs.dt[0]), float(inputs.viscosity[0]), float(inputs.domain_extent)
    one, start = operator(n, inputs.steps, *scalars), np.asarray(inputs.v0).tobytes()
    if last[:2] != (one, start):
        _, velocity = one.simulate(np.zeros((n, n, n)), to_faces(inputs.v0), at=[inputs.steps])
        last = one, start, tuple(part[0] for part in velocity)
    return one, last[2]


def apply(inputs: InputSchema) -> OutputSchema:
    """The velocity of the last step."""
    return OutputSchema(result=to_nodes(simulated(inputs)[1]))


def vector_jacobian_product(
    inputs: InputSchema, vjp_inputs: set[str], vjp_outputs: set[str], cotangent_vector: dict[str, Any]
) -> dict[str, Any]:
    """What a function of the last velocity gets by the first."""
    one, _ = simulated(inputs)
    back = one.vjp(velocity={inputs.steps: to_faces(np.asarray(cotangent_vector["result"]))})
    return {"v0": to_nodes(back.velocity)}


def abstract_eval(abstract_inputs: Any) -> dict[str, Any]:
    """The shape of the result."""
    return {"result": {"shape": abstract_inputs.v0.shape, "dtype": "float32"}}
