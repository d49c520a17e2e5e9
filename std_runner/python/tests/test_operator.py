"""The operator in Python: gradients against differences, in NumPy, jax and torch, and the notebook that trains with it."""

import json
import os
import pathlib
import signal
import sys
import tempfile
import threading
import time
import types
import unittest

import numpy as np
import thurible_smoke

NOTEBOOK = pathlib.Path(__file__).parents[3] / "examples/python/controller.ipynb"


def draw(operator, seed, size=0.05):
    """Density, velocity and forces at random, the walls' faces at rest."""
    random = np.random.default_rng(seed)
    steps, dims = operator.steps, len(operator.shape)
    density = random.random(operator.shape)
    fields = []
    for count in (None, steps):
        components = []
        for axis, faces in enumerate(operator.faces):
            field = size * random.standard_normal(faces if count is None else (count, *faces))
            if faces != operator.shape:
                ends = [slice(None)] * field.ndim
                ends[field.ndim - 1 - axis] = [0, -1]
                field[tuple(ends)] = 0.0
            components.append(field.astype(operator.dtype))
        fields.append(tuple(components))
    return density.astype(operator.dtype), *fields


def along(fields, other):
    return sum(float(np.vdot(one, two)) for one, two in zip(fields, other))


def slope(value):
    """A derivative at 0 by differences."""
    return (value(1e-5) - value(-1e-5)) / 2e-5


class Gradients(unittest.TestCase):
    def check(self, shape, steps, **choices):
        if choices.get("solver") != "stable_fluids":
            choices = {"advection": "central", "advection_tolerance": 1e-200, "tolerance": 1e-12} | choices
        operator = thurible_smoke.Operator(shape, steps, **choices)
        density, velocity, forces = draw(operator, 1)
        found = operator.simulate(density, velocity, forces)
        random = np.random.default_rng(2)
        covectors = [random.standard_normal(field.shape) for field in (found[0], *found[1])]
        gradient = operator.vjp(covectors[0], covectors[1:])
        d_density, d_velocity, d_forces = draw(operator, 3)

        def value(t):
            moved = operator.simulate(
                density + t * d_density,
                [v + t * d for v, d in zip(velocity, d_velocity)],
                [f + t * d for f, d in zip(forces, d_forces)],
            )
            return along((moved[0], *moved[1]), covectors)

        expected = slope(value)
        by = along([gradient.density, *gradient.velocity, *gradient.forces], [d_density, *d_velocity, *d_forces])
        self.assertAlmostEqual(by, expected, delta=1e-6 * abs(expected))
        return operator, (density, velocity, forces), covectors, gradient

    def test_by_differences(self):
        self.check((8, 9), 4, viscosity=1e-3)
        self.check((6, 5, 7), 3, boundary="periodic", buoyancy=0.1, dt=0.5, length=2.0)
        shape = np.zeros((8, 9))
        shape[2:5, 3:6] = 0.7
        emitters = [{"shape": shape, "rate": 0.2, "velocity": (0.05, 0.1)}]
        _, _, _, gradient = self.check((8, 9), 4, emitters=emitters, buoyancy=(0.0, 0.2))
        self.assertEqual(gradient.emitters[0]["shape"].shape, (8, 9))
        self.assertEqual(len(gradient.emitters[0]["velocity"]), 2)
        self.assertEqual(len(gradient.buoyancy), 2)

    def test_by_differences_round_solids_and_with_open_sides(self):
        solid = np.zeros((8, 9), bool)
        solid[3:5, 4:6] = True
        for choices in ({"boundary": ("wall", "open_high"), "buoyancy": 0.1}, {"solids": solid, "viscosity": 1e-3}, {"solids": solid, "viscosity": 1e-2, "slip": False}, {"solids": solid, "boundary": "open"}):
            operator, _, _, gradient = self.check((8, 9), 4, advection="limited", **choices)
            self.assertGreater(min(np.abs(field).max() for field in (gradient.density, *gradient.velocity, *gradient.forces)), 0.0)
        # Nothing is carried within the solid.
        self.assertEqual(np.abs(gradient.density[solid]).max(), 0.0)

    def test_by_differences_with_stable_fluids(self):
        wind = {"kind": "wind", "center": (0.4, 0.6), "radius": 0.3, "amplitude": (0.05, -0.02)}
        operator, _, _, gradient = self.check((8, 9), 4, solver="stable_fluids", templates=[wind], viscosity=1e-3, options={"diffusion": 1e-3}, slots=2)
        self.assertEqual(operator.faces, ((8, 9), (8, 9)))
        self.assertEqual((operator.slots, gradient.velocity[0].shape, len(gradient.emitters)), (2, (8, 9), 0))
        self.check((6, 5, 7), 3, solver="stable_fluids", boundary="periodic", buoyancy=0.1, dt=0.5, length=2.0)
        cg = {"pressure": "cg", "cg_iterations": 30, "cg_tolerance": 1e-12}
        self.check((8, 9), 4, solver="stable_fluids", boundary=("wall", "periodic"), options=cg, slots=0)

    def test_by_buoyancy_with_stable_fluids(self):
        def run(lift):
            operator = thurible_smoke.Operator((8, 9), 4, solver="stable_fluids", buoyancy=(0.0, lift))
            density, velocity, forces = draw(operator, 1)
            found = operator.simulate(density, velocity, forces)
            covectors = [np.random.default_rng(2).standard_normal(field.shape) for field in (found[0], *found[1])]
            return along((found[0], *found[1]), covectors), operator.vjp(covectors[0], covectors[1:]).buoyancy[1]

        expected = (run(0.2 + 1e-6)[0] - run(0.2 - 1e-6)[0]) / 2e-6
        self.assertAlmostEqual(run(0.2)[1], expected, delta=1e-6 * abs(expected))

    def test_slots_of_stable_fluids(self):
        found = []
        for slots in (0, 1, 3):
            operator = thurible_smoke.Operator((8, 9), 6, solver="stable_fluids", slots=slots, threads=1)
            density, velocity, forces = draw(operator, 1)
            operator.simulate(density, velocity, forces)
            gradient = operator.vjp({6: density}, {2: velocity})
            found.append([gradient.density, *gradient.velocity, *gradient.forces])
            self.assertEqual(operator.slots, slots)
            with self.assertRaises(MemoryError):
                thurible_smoke.Operator((8, 9), 6, solver="stable_fluids", slots=slots, threads=1, memory_limit=operator.planned_bytes - 1)
        for other in found[1:]:
            for mine, theirs in zip(found[0], other):
                np.testing.assert_array_equal(mine, theirs)

    def test_steps_alone_and_no_forces(self):
        operator = thurible_smoke.Operator((8, 9), 6)
        density, velocity, _ = draw(operator, 4)
        whole = operator.simulate(density, velocity)
        ends = operator.simulate(density, velocity, at=[0, 6])
        for all_steps, two in zip((whole[0], *whole[1]), (ends[0], *ends[1])):
            np.testing.assert_array_equal(all_steps[[0, 6]], two)
        self.assertIsNone(operator.vjp({6: density}).forces)
        for wrong in ([2, 1], [7], [1, 1]):
            with self.assertRaisesRegex(ValueError, "at is"):
                operator.simulate(density, velocity, at=wrong)

    def test_what_others_run_between_is_noticed(self):
        from thurible_smoke._last import Last

        operator = thurible_smoke.Operator((8, 9), 4)
        one, other = draw(operator, 1), draw(operator, 2)
        flat = lambda drawn: [drawn[0], *drawn[1], *drawn[2]]
        first, second = Last(operator), Last(operator)
        covectors = [np.ones_like(field) for field in first.simulate(flat(one))]
        expected = first.vjp(flat(one), covectors)
        for between in (lambda: second.simulate(flat(other)), lambda: operator.simulate(other[0])):
            first.simulate(flat(one))
            between()
            for found, right in zip(first.vjp(flat(one), covectors), expected):
                np.testing.assert_array_equal(found, right)

    def test_a_simulation_that_fails_leaves_nothing_to_take_back(self):
        for solver in ("implicit", "stable_fluids"):
            operator = thurible_smoke.Operator((8, 9), 4, solver=solver)
            density, velocity, forces = draw(operator, 1)
            operator.simulate(density, velocity, forces)
            expected = operator.vjp({4: density}).density
            with self.assertRaises((ValueError, FloatingPointError)):
                operator.simulate(2 * density, velocity, [np.full_like(force, np.nan) for force in forces])
            with self.assertRaisesRegex(RuntimeError, "call simulate before vjp"):
                operator.vjp({4: density})
            operator.simulate(density, velocity, forces)
            np.testing.assert_array_equal(operator.vjp({4: density}).density, expected)

    def test_forces_beside_the_bounds_of_numbers(self):
        operator = thurible_smoke.Operator((8, 9), 4)
        density, velocity, forces = draw(operator, 1)
        packed = []
        for force in forces:
            record = np.zeros(force.shape, np.dtype([("flag", "u1"), ("force", "f8")]))
            record["force"] = force
            packed.append(record["force"])
        found = []
        for given in (forces, packed):
            flow = operator.simulate(density, velocity, given)
            found.append([flow[0], *flow[1], *operator.vjp({4: density}).forces])
        for mine, theirs in zip(*found):
            np.testing.assert_array_equal(mine, theirs)

    def test_any_mapping_of_covectors(self):
        operator = thurible_smoke.Operator((8, 9), 4)
        density, velocity, forces = draw(operator, 1)
        operator.simulate(density, velocity, forces)
        expected = operator.vjp({4: density}).density
        np.testing.assert_array_equal(operator.vjp(types.MappingProxyType({4: density})).density, expected)

    def test_a_signal_stops_it(self):
        # A shell's background ignores the signal, and so would Python.
        self.addCleanup(signal.signal, signal.SIGINT, signal.signal(signal.SIGINT, signal.default_int_handler))
        operator = thurible_smoke.Operator((96, 96), 4000, slots=8)
        began = time.monotonic()
        timer = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            operator.simulate(np.full((96, 96), 0.5), [np.random.default_rng(1).standard_normal(faces) * 0.01 for faces in operator.faces], at=[])
        self.assertLess(time.monotonic() - began, 5)

    def test_slots_change_no_bit_and_keep_to_the_limit(self):
        operator, inputs, covectors, gradient = self.check((8, 9), 6)
        self.assertEqual((operator.slots, operator.next_slot_bytes), (6, None))
        one = thurible_smoke.Operator((8, 9), 6, advection="central", advection_tolerance=1e-200, tolerance=1e-12, slots=1)
        self.assertEqual(one.repeated_steps, 15)
        with self.assertRaises(MemoryError):
            thurible_smoke.Operator((8, 9), 6, threads=1, memory_limit=1000)
        limit = thurible_smoke.Operator((8, 9), 6, threads=1, slots=3).planned_bytes
        self.assertEqual(thurible_smoke.Operator((8, 9), 6, threads=1, memory_limit=limit).slots, 3)
        one.simulate(*inputs)
        other = one.vjp(covectors[0], covectors[1:])
        for mine, theirs in zip((gradient.density, *gradient.velocity, *gradient.forces), (other.density, *other.velocity, *other.forces)):
            np.testing.assert_array_equal(mine, theirs)

    def test_covectors_of_single_steps(self):
        operator, inputs, covectors, _ = self.check((8, 9), 4)
        operator.simulate(*inputs)
        whole = np.zeros_like(covectors[0])
        whole[[2, 4]] = covectors[0][[2, 4]]
        by_whole = operator.vjp(whole).forces
        by_steps = operator.vjp({4: covectors[0][4], 2: covectors[0][2]}).forces
        for mine, theirs in zip(by_whole, by_steps):
            np.testing.assert_array_equal(mine, theirs)

    def test_what_is_wrong_is_refused(self):
        operator = thurible_smoke.Operator((8, 9), 3)
        density, velocity, forces = draw(operator, 1)
        for error, words, act in [
            (RuntimeError, "call simulate", lambda: operator.vjp(np.zeros((4, 8, 9)))),
            (ValueError, "density has shape", lambda: operator.simulate(density[1:])),
            (ValueError, "dtype", lambda: operator.simulate(density.astype(np.float32))),
            (ValueError, "velocity has 1 entries", lambda: operator.simulate(density, velocity[:1])),
            (ValueError, r"forces\[0\] has shape", lambda: operator.simulate(density, velocity, velocity)),
            (ValueError, "not finite", lambda: operator.simulate(np.full((8, 9), np.nan))),
            (FloatingPointError, "too fast", lambda: operator.simulate(density, [1e6 * v for v in velocity])),
            (ValueError, "force_weight steers", lambda: thurible_smoke.Operator((8, 9), 3, force_weight=1.0)),
            (ValueError, "operator.slots is 9", lambda: thurible_smoke.Operator((8, 9), 3, slots=9)),
            (ValueError, 'solver is "euler"', lambda: thurible_smoke.Operator((8, 9), 3, solver="euler")),
            (ValueError, "options steers", lambda: thurible_smoke.Operator((8, 9), 3, options={"sweeps": 3})),
            (ValueError, "tolerance is of the implicit", lambda: thurible_smoke.Operator((8, 9), 3, solver="stable_fluids", tolerance=1e-9)),
            (ValueError, "history.*steers", lambda: thurible_smoke.Operator((8, 9), 3, solver="stable_fluids", options={"history": 3})),
            (TypeError, "no option of this method sweep", lambda: thurible_smoke.Operator((8, 9), 3, solver="stable_fluids", options={"sweep": 3})),
            (ValueError, "stable_fluids knows no", lambda: thurible_smoke.Operator((8, 9), 3, solver="stable_fluids", solids=density > 0.9)),
            (ValueError, "slots is 9", lambda: thurible_smoke.Operator((8, 9), 3, solver="stable_fluids", slots=9)),
            (TypeError, "there is no argument gravity", lambda: thurible_smoke.Operator((8, 9), 3, gravity=9)),
        ]:
            with self.assertRaisesRegex(error, words):
                act()


class Search(unittest.TestCase):
    """`stable_fluids`: a blob goes to the right by each control."""

    def setUp(self):
        y, x = np.mgrid[0:16, 0:16]
        self.blob = lambda at: np.exp(-((x - at) ** 2 + (y - 7.5) ** 2) / 8.0)
        self.x = x

    def search(self, **choices):
        choices = {"force_weight": 0.1, "options": {"initial_weight": 0.1}, "iterations": 15, **choices}
        return thurible_smoke.stable_fluids(self.blob(5.0), {6: self.blob(9.0)}, **choices)

    def test_each_control(self):
        wind = {"kind": "wind", "center": (0.5, 0.5), "radius": 0.4, "interval": 3, "move": True}
        for control, more in (("initial_velocity", {}), (["forces"], {"slots": 2}), ("templates", {"templates": [wind]})):
            found = self.search(control=control, **more)
            self.assertEqual((found.density.shape, found.velocity[1].shape, found.force[0].shape), ((7, 16, 16), (7, 16, 16), (6, 16, 16)))
            self.assertLess(found.objective, 0.5 * found.history[0].objective)
            self.assertAlmostEqual(found.objective, found.data_term + found.force_term + found.initial_term)
            self.assertIn(found.status, ("converged", "max_iterations"))
            np.testing.assert_array_equal(found.density[0], self.blob(5.0))
            self.assertGreater((found.density[-1] * self.x).sum() / found.density[-1].sum(), 7.5)
            self.assertEqual(found.slots, more.get("slots", 0))
            self.assertEqual(len(found.templates), len(more.get("templates", [])))
        self.assertEqual(len(found.templates[0]["amplitude"]), 2)
        self.assertGreater(found.templates[0]["amplitude"][0][0], 0.0)

    def test_the_flow_is_that_of_the_operator(self):
        found = self.search()
        operator = thurible_smoke.Operator((16, 16), 6, solver="stable_fluids")
        density, velocity = operator.simulate(found.density[0], [v[0] for v in found.velocity])
        for mine, theirs in zip((density, *velocity), (found.density, *found.velocity)):
            np.testing.assert_allclose(mine, theirs, rtol=0, atol=1e-13)

    def test_it_goes_on_from_a_velocity_and_can_be_stopped(self):
        ahead = [np.full((16, 16), 0.04), np.zeros((16, 16))]
        heard = []
        found = self.search(initial_velocity=ahead, progress=lambda entry: heard.append(entry.iteration) or len(heard) < 3)
        self.assertEqual((heard, found.status, len(found.history)), ([1, 2, 3], "cancelled", 3))
        self.assertLess(found.history[0].objective, self.search().history[0].objective)

    def test_it_goes_on_from_its_state(self):
        choices = {"control": ["initial_velocity", "forces"], "options": {"initial_weight": 0.1, "tolerance": 1e-12}, "iterations": 12}
        with tempfile.TemporaryDirectory() as folder:
            state = pathlib.Path(folder) / "state"
            whole = self.search(**choices)
            part = self.search(checkpoint=state, checkpoint_every=0, progress=lambda entry: entry.iteration < 5, **choices)
            self.assertEqual((part.status, os.listdir(folder)), ("cancelled", ["state"]))
            rest = self.search(resume=str(state), threads=1, slots=2, **choices)
            for mine, theirs in zip((rest.density, *rest.velocity, *rest.force), (whole.density, *whole.velocity, *whole.force)):
                np.testing.assert_array_equal(mine, theirs)
            self.assertEqual([entry.objective for entry in rest.history], [entry.objective for entry in whole.history][4:])
            with self.assertRaisesRegex(ValueError, "other arrays or choices"):
                self.search(resume=state, force_weight=3.0, **choices)
            state.write_bytes(state.read_bytes()[:-1])
            with self.assertRaisesRegex(ValueError, "damaged"):
                self.search(resume=state, **choices)

    def test_what_is_wrong_is_refused(self):
        for error, words, choices in [
            (ValueError, 'control is "wind"', {"control": "wind"}),
            (ValueError, "control is empty", {"control": []}),
            (ValueError, "method is chosen", {"method": "direct"}),
            (ValueError, "template", {"control": "templates"}),
            (ValueError, "stable_fluids knows no", {"release": 4}),
            (ValueError, r"initial_velocity\[0\] has shape", {"initial_velocity": [np.zeros((16, 17)), np.zeros((17, 16))]}),
            (ValueError, "progress cannot be called", {"progress": 3}),
            (TypeError, "there is no argument gravity", {"gravity": 9}),
            (MemoryError, "memory_limit", {"memory_limit": 1000, "threads": 1}),
        ]:
            with self.assertRaisesRegex(error, words):
                self.search(**choices)


class Condense(unittest.TestCase):
    """`Condenser`: a square that is stretched, a rod under its weight."""

    def square(self, n=4, **choices):
        x, y = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1))
        rest = np.stack([x.ravel(), y.ravel()], axis=1)
        at = lambda i, j: j * (n + 1) + i
        cells = [(i, j) for j in range(n) for i in range(n)]
        corners = [[at(i, j), at(i + 1, j), at(i + 1, j + 1)] for i, j in cells] + [[at(i, j), at(i + 1, j + 1), at(i, j + 1)] for i, j in cells]
        held = (rest[:, 0] == 0) | (rest[:, 0] == 1)
        return rest, held, thurible_smoke.Condenser(rest, np.array(corners), held, **choices)

    def stretched(self, **choices):
        rest, held, body = self.square(**choices)
        said = [body.step(np.where((rest[:, :1] == 1), [[0.05, 0.0]], 0.0)) for _ in range(2)]
        return rest, held, body, said

    def test_methods_agree_with_newton(self):
        rest, held, newton, told = self.stretched(method="newton", tolerance=1e-10)
        for said in told:
            self.assertEqual((said["status"], len(said["energy"])), ("converged", said["iterations"] + 1))
            self.assertTrue((np.diff(said["energy"]) <= 1e-9 * said["energy"][0]).all())
        np.testing.assert_allclose(newton.position[held], rest[held] + np.where(rest[held][:, :1] == 1, [[0.1, 0.0]], 0.0), atol=1e-14)
        self.assertLess(abs(newton.gradient).max(), 1e-3)
        self.assertEqual(newton.steps, 2)
        for method in ("cc", "projected", "warped"):
            _, _, body, told = self.stretched(method=method, tolerance=1e-10)
            self.assertEqual([said["status"] for said in told], ["converged"] * 2)
            np.testing.assert_allclose(body.position, newton.position, atol=1e-7)
            self.assertGreaterEqual(body.builds, 1)

    def test_the_energy_is_that_of_the_gradient(self):
        _, held, body, told = self.stretched(method="newton", cap=1)
        self.assertEqual(told[0]["status"], "max_iterations")
        self.assertEqual((body.gradient[held] == 0).all(), True)

    def test_a_rod_hangs_by_its_weight(self):
        n, young, density = 8, 1e4, 1000.0
        rest = np.linspace(0, 1, n + 1)[:, None]
        rod = thurible_smoke.Condenser(rest, np.stack([np.arange(n), np.arange(1, n + 1)], axis=1), np.arange(n + 1) == 0, young=young, density=density, tolerance=1e-12)
        said = rod.step(gravity=[1.0])
        self.assertEqual(said["status"], "converged")
        # Linear elements are exact at their ends: u(x) = rho g / Y (x - x^2 / 2).
        x = rest[:, 0]
        np.testing.assert_allclose((rod.position - rest)[:, 0], density / young * (x - x * x / 2), rtol=1e-8, atol=1e-12)

    def test_memory_and_refusals(self):
        _, _, body = self.square(threads=1)
        for limit in (body.planned_bytes - 1, 1000):
            with self.assertRaisesRegex(MemoryError, "memory_limit"):
                self.square(threads=1, memory_limit=limit)
        self.assertEqual(self.square(threads=1, memory_limit=body.planned_bytes)[2].planned_bytes, body.planned_bytes)
        for error, words, choices in [
            (ValueError, 'method is "gauss"', {"method": "gauss"}),
            (ValueError, "basis cannot be used", {"method": "newton", "basis": "rebuilt"}),
            (ValueError, "poisson must be", {"poisson": 0.5}),
            (ValueError, "spring 0", {"springs": [(0, 0, 1.0, 1.0)]}),
            (TypeError, "there is no argument mass", {"mass": 1.0}),
        ]:
            with self.assertRaisesRegex(error, words):
                self.square(**choices)
        for words, act in [
            ("shift has another shape", lambda: body.step(np.zeros((3, 2)))),
            ("gravity has 3 numbers", lambda: body.step(gravity=[0.0, 0.0, 1.0])),
            ("velocity is of no use to a body without time", lambda: body.set_velocity(np.zeros((25, 2)))),
            ("shift has a number, the one after 7 others, that is not finite", lambda: body.step(np.where(np.arange(50) == 7, np.nan, 0.0).reshape(25, 2))),
            ("gravity has a number", lambda: body.step(gravity=[0.0, np.nan])),
            ("elements has 2 columns; give 3", lambda: thurible_smoke.Condenser(np.eye(3)[:, :2], [[0, 1], [1, 2], [2, 0]], [True, False, False])),
            ("elements has 3 columns; give 4", lambda: thurible_smoke.Condenser(np.eye(3), [[0, 1, 2]], [True, False, False])),
            ("hold", lambda: thurible_smoke.Condenser(np.eye(3)[:, :2], [[2, 0, 1]], [False] * 3)),
        ]:
            with self.assertRaisesRegex(ValueError, words):
                act()


def missing(name):
    try:
        __import__(name)
        return False
    except ImportError:
        print(f"SKIPPED: there is no {name} here, so thurible_smoke.{name} was not tested", file=sys.stderr)
        return True


@unittest.skipIf(missing("jax"), "no jax")
class Jax(unittest.TestCase):
    def test_gradients(self):
        import jax

        jax.config.update("jax_enable_x64", True)
        for operator in (
            thurible_smoke.Operator((7, 8), 3, boundary="periodic", tolerance=1e-12),
            thurible_smoke.Operator((7, 8), 3, solver="stable_fluids"),
        ):
            self.check(operator)

    def check(self, operator):
        import jax
        import jax.numpy as jnp
        import thurible_smoke.jax

        simulate = thurible_smoke.jax.simulation(operator)
        density, velocity, forces = draw(operator, 5)

        def loss(density, velocity, forces):
            rho, v = simulate(density, velocity, forces)
            return jnp.sum(rho[-1] ** 2) + jnp.sum(v[0][-1] ** 3) + jnp.sum(rho[1] * density)

        value, gradient = jax.jit(jax.value_and_grad(loss, argnums=(0, 1, 2)))(density, velocity, forces)
        self.assertAlmostEqual(float(loss(density, velocity, forces)), float(value), places=12)
        direction = draw(operator, 6)
        moved = lambda t: jax.tree.map(lambda x, d: x + t * d, (density, velocity, forces), direction)
        expected = slope(lambda t: float(loss(*moved(t))))
        by = along(jax.tree.leaves(gradient), jax.tree.leaves(direction))
        self.assertAlmostEqual(by, expected, delta=2e-5 * abs(expected))

    @unittest.skipUnless(NOTEBOOK.exists(), "no notebook")
    def test_the_notebook_trains(self):
        cells = json.loads(NOTEBOOK.read_text())["cells"]
        self.assertLess(NOTEBOOK.stat().st_size, 200_000)
        names = {"QUICK": True}
        try:
            import matplotlib

            matplotlib.use("Agg")
        except ImportError:
            print("SKIPPED: there is no matplotlib here, so the notebook was not run", file=sys.stderr)
            return
        for cell in cells:
            if cell["cell_type"] == "code":
                exec("".join(cell["source"]), names)  # noqa: S102
        self.assertLess(names["losses"][-1], 0.8 * names["losses"][0])


@unittest.skipIf(missing("torch"), "no torch")
class Torch(unittest.TestCase):
    def test_gradients(self):
        import torch
        import thurible_smoke.torch

        operator = thurible_smoke.Operator((7, 8), 1, boundary="periodic", tolerance=1e-12)
        simulate = thurible_smoke.torch.simulation(operator)
        tensors = lambda fields: tuple(torch.from_numpy(field) for field in fields)
        density, velocity, forces = draw(operator, 5)
        direction = draw(operator, 6)

        def loss(density, velocity, forces):
            # Two runs of one operator, as a loop over steps makes them.
            rho, v = simulate(density, velocity, forces)
            rho, v = simulate(rho[-1], tuple(c[-1] for c in v), forces)
            return (rho[-1] ** 2).sum() + (v[0][-1] ** 3).sum()

        values = (torch.from_numpy(density), tensors(velocity), tensors(forces))
        leaves = [values[0], *values[1], *values[2]]
        for leaf in leaves:
            leaf.requires_grad_()
        loss(*values).backward()
        moved = lambda t: (
            torch.from_numpy(density + t * direction[0]),
            tensors([v + t * d for v, d in zip(velocity, direction[1])]),
            tensors([f + t * d for f, d in zip(forces, direction[2])]),
        )
        with torch.no_grad():
            expected = slope(lambda t: float(loss(*moved(t))))
        by = along([leaf.grad.numpy() for leaf in leaves], [direction[0], *direction[1], *direction[2]])
        self.assertAlmostEqual(by, expected, delta=2e-5 * abs(expected))

    def test_what_asks_for_no_gradient_gets_none(self):
        import torch
        import thurible_smoke.torch

        operator = thurible_smoke.Operator((7, 8), 1, boundary="periodic")
        simulate = thurible_smoke.torch.simulation(operator)
        density, velocity, forces = draw(operator, 5)
        density = torch.from_numpy(density)
        velocity, forces = (tuple(map(torch.from_numpy, fields)) for fields in (velocity, forces))
        forces[1].requires_grad_()
        (simulate(density, velocity, forces)[1][1][-1] ** 2).sum().backward()
        self.assertGreater(forces[1].grad.abs().max().item(), 0.0)
        self.assertTrue(all(value.grad is None for value in (density, *velocity, forces[0])))

    def test_a_second_derivative_is_refused(self):
        import torch
        import thurible_smoke.torch

        operator = thurible_smoke.Operator((7, 8), 1, boundary="periodic")
        density = torch.from_numpy(draw(operator, 5)[0]).requires_grad_()
        loss = (thurible_smoke.torch.simulation(operator)(density)[0][-1] ** 2).sum()
        (gradient,) = torch.autograd.grad(loss, density, create_graph=True)
        with self.assertRaisesRegex(RuntimeError, "once_differentiable"):
            gradient.sum().backward()


if __name__ == "__main__":
    unittest.main()
