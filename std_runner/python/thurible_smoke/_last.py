"""An operator that knows what it simulated last, for programs that ask for gradients in an order of their own."""

import threading
import weakref

import numpy as np

# One for each operator, whoever runs it.
_locks = weakref.WeakKeyDictionary()


class Last:
    """Runs an operator, and simulates once more where a gradient is asked for of another run than the last."""

    def __init__(self, operator):
        self.operator = operator
        self._lock = _locks.setdefault(operator, threading.Lock())
        self._inputs, self._runs = None, None
        # Once, and alone: an operator that another thread runs says nothing.
        with self._lock:
            self.dtype, self.shape, self.faces, self.steps = operator.dtype, operator.shape, operator.faces, operator.steps

    def arrays(self, values):
        """Arrays in order, of the operator's precision; copies, since a caller's may be gone when the way back reads them."""
        return tuple(np.array(value, dtype=self.dtype, order="C") for value in values)

    def _run(self, inputs):
        dims = len(self.shape)
        self._inputs = None
        found = self.operator.simulate(inputs[0], inputs[1 : 1 + dims], inputs[1 + dims :])
        self._inputs, self._runs = inputs, self.operator.runs
        return found

    def simulate(self, values):
        """Densities and components of velocities, one after the other, from the density, the components of the velocity and of the forces."""
        inputs = self.arrays(values)
        with self._lock:
            density, velocity = self._run(inputs)
        return (density, *velocity)

    def vjp(self, values, covectors):
        """The gradient by all of `values`, by covectors of what `simulate` makes of them."""
        inputs = self.arrays(values)
        density, *velocity = self.arrays(covectors)
        with self._lock:
            last = self._inputs if self._runs == self.operator.runs else None
            if last is None or not all(np.array_equal(one, other) for one, other in zip(inputs, last)):
                self._run(inputs)
            found = self.operator.vjp(density, velocity)
        return (found.density, *found.velocity, *found.forces)


def by_axis(name, parts, dims):
    """The arrays of a vector field, one for each of `dims` axes; None for each where there are none."""
    if parts is None:
        return [None] * dims
    if len(parts) != dims:
        raise ValueError(f"{name} has {len(parts)} parts; give a tuple of {dims} arrays, along x, y and so on")
    return list(parts)
