"""The operator in torch: `simulation(operator)` is a function through which `backward` goes.

    operator = thurible_smoke.Operator((64, 64), 20)
    simulate = thurible_smoke.torch.simulation(operator)
    density, velocity = simulate(rho0, v0, forces)
    ((density[-1] - target) ** 2).sum().backward()

It runs on the CPU; tensors of other devices are taken there and back.
"""

from __future__ import annotations

import torch
from torch.autograd.function import once_differentiable

from ._last import Last, by_axis

__all__ = ["simulation"]


class _Simulation(torch.autograd.Function):
    @staticmethod
    def forward(ctx, last, *values):
        ctx.last = last
        ctx.save_for_backward(*values)
        found = last.simulate([value.detach().cpu().numpy() for value in values])
        return tuple(torch.from_numpy(array).to(values[0].device) for array in found)

    @staticmethod
    @once_differentiable
    def backward(ctx, *covectors):
        given, wanted = ctx.saved_tensors, ctx.needs_input_grad[1:]
        values = [value.detach().cpu().numpy() for value in given]
        found = ctx.last.vjp(values, [covector.detach().cpu().numpy() for covector in covectors])
        each = zip(found, given, wanted, strict=True)
        return (None, *(torch.from_numpy(array).to(value.device) if asked else None for array, value, asked in each))


def simulation(operator):
    """`simulate(density, velocity=None, forces=None) -> (densities, velocities)` with the operator's exact adjoint.

    Velocity and forces are tuples by axis, as `Operator.simulate` takes them; None is 0. Tensors of another precision are converted.
    """
    last = Last(operator)
    dims, dtype = len(last.shape), {"float32": torch.float32, "float64": torch.float64}[last.dtype]
    shapes = [last.shape, *last.faces, *((last.steps, *faces) for faces in last.faces)]

    def simulate(density, velocity=None, forces=None):
        given = [density, *by_axis("velocity", velocity, dims), *by_axis("forces", forces, dims)]
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
