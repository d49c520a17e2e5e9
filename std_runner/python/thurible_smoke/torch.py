"""The operator in torch: `simulation(operator)` is a function through which `backward` goes.

    operator = thurible_smoke.Operator((64, 64), 20)
    simulate = thurible_smoke.torch.simulation(operator)
    density, velocity = simulate(rho0, v0, forces)
    ((density[-1] - target) ** 2).sum().backward()

It runs on the CPU; tensors of other devices are taken there and back.
"""

from __future__ import annotations

import torch

from ._last import Last

__all__ = ["simulation"]


class _Simulation(torch.autograd.Function):
    @staticmethod
    def forward(ctx, last, *values):
        ctx.last = last
        ctx.save_for_backward(*values)
        found = last.simulate([value.detach().cpu().numpy() for value in values])
        return tuple(torch.from_numpy(array).to(values[0].device) for array in found)

    @staticmethod
    def backward(ctx, *covectors):
        values = [value.detach().cpu().numpy() for value in ctx.saved_tensors]
        found = ctx.last.vjp(values, [covector.detach().cpu().numpy() for covector in covectors])
        device = ctx.saved_tensors[0].device
        return (None, *(torch.from_numpy(array).to(device) for array in found))


def simulation(operator):
    """`simulate(density, velocity=None, forces=None) -> (densities, velocities)` with the operator's exact adjoint.

    Velocity and forces are tuples by axis, as `Operator.simulate` takes them; None is 0. Tensors of another precision are converted.
    """
    last, steps, dims = Last(operator), operator.steps, len(operator.shape)
    dtype = {"float32": torch.float32, "float64": torch.float64}[operator.dtype]
    shapes = [tuple(operator.shape), *operator.faces, *((steps, *faces) for faces in operator.faces)]

    def simulate(density, velocity=None, forces=None):
        given = [density, *(velocity or [None] * dims), *(forces or [None] * dims)]
        device = density.device
        values = [
            torch.zeros(shape, dtype=dtype, device=device) if value is None else value.to(dtype) for value, shape in zip(given, shapes, strict=True)
        ]
        for value, shape in zip(values, shapes):
            if tuple(value.shape) != tuple(shape):
                raise ValueError(f"a tensor has shape {tuple(value.shape)} where {tuple(shape)} is needed")
        density, *velocity = _Simulation.apply(last, *values)
        return density, tuple(velocity)

    return simulate
