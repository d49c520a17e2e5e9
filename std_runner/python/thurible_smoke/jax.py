"""The operator in jax: `simulation(operator)` is a function that `jax.grad` and `jax.jit` take.

    operator = thurible_smoke.Operator((64, 64), 20)
    simulate = thurible_smoke.jax.simulation(operator)
    loss = lambda forces: jnp.sum((simulate(rho0, v0, forces)[0][-1] - target) ** 2)
    jax.grad(loss)(forces)

It runs on the host, by pure_callback. Under vmap one run follows the other.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np

from ._last import Last, by_axis

__all__ = ["simulation"]


def simulation(operator):
    """`simulate(density, velocity=None, forces=None) -> (densities, velocities)` with the operator's exact adjoint.

    Velocity and forces are tuples by axis, as `Operator.simulate` takes them; None is 0. Operators of float64 need jax's 64 bits:
    jax.config.update("jax_enable_x64", True).
    """
    last = Last(operator)
    dtype, steps, dims = np.dtype(last.dtype), last.steps, len(last.shape)
    if jnp.zeros((), dtype).dtype != dtype:
        raise ValueError('the operator has float64, which jax turns into float32; set jax_enable_x64, or make it with dtype="float32"')
    like = lambda shape: jax.ShapeDtypeStruct(tuple(shape), dtype)
    inputs = (like(last.shape), *map(like, last.faces), *(like((steps, *faces)) for faces in last.faces))
    outputs = (like((steps + 1, *last.shape)), *(like((steps + 1, *faces)) for faces in last.faces))

    def forward(*values):
        return jax.pure_callback(lambda *values: last.simulate(values), outputs, *values, vmap_method="sequential")

    def back(values, covectors):
        run = lambda *both: last.vjp(both[: len(inputs)], both[len(inputs) :])
        return jax.pure_callback(run, inputs, *values, *covectors, vmap_method="sequential")

    run = jax.custom_vjp(forward)
    run.defvjp(lambda *values: (forward(*values), values), back)

    def simulate(density, velocity=None, forces=None):
        given = [density, *by_axis("velocity", velocity, dims), *by_axis("forces", forces, dims)]
        values = [jnp.zeros(place.shape, dtype) if value is None else jnp.asarray(value, dtype) for value, place in zip(given, inputs, strict=True)]
        for value, place in zip(values, inputs):
            if value.shape != place.shape:
                raise ValueError(f"an array has shape {value.shape} where {place.shape} is needed")
        density, *velocity = run(*values)
        return density, tuple(velocity)

    return simulate
