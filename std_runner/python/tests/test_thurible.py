"""What thurible does in Python, against facts that NumPy computes by itself and against the program.

THURIBLE_PROGRAM names the program; without it the comparison with the program is left out.
"""

import ast
import gc
import inspect
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import threading
import time
import types
import unittest
import weakref

import numpy as np
import thurible_smoke


def blob(shape, center, radius, dtype):
    """Smoke around `center`, given as the axes of the array, in parts of each."""
    axes = np.meshgrid(*[(np.arange(n) + 0.5) / n for n in shape], indexing="ij")
    distance = np.sqrt(sum((axis - at) ** 2 for axis, at in zip(axes, center)))
    return (0.5 - 0.5 * np.tanh((distance - radius) * max(shape))).astype(dtype)


def move(shape, dtype, steps, **choices):
    """Solves for smoke that moves along x, and a little along y."""
    dims = len(shape)
    source = blob(shape, [0.5] * (dims - 1) + [0.4], 0.2, dtype)
    target = blob(shape, [0.5] * (dims - 2) + [0.55, 0.6], 0.2, dtype)
    return source, target, thurible_smoke.solve(source, {steps: target}, **choices)


def divergence(velocity):
    """Of components with the faces of walls, times the cells along the longest side."""
    dims = len(velocity)
    return sum(np.diff(component, axis=dims - axis) for axis, component in enumerate(velocity))


class Results(unittest.TestCase):
    def test_facts(self):
        cases = [((24, 20), np.float32, "direct"), ((24, 20), np.float64, "admm"), ((10, 12, 14), np.float32, "direct"), ((9, 10, 11), np.float64, "lbfgs")]
        for shape, dtype, method in cases:
            with self.subTest(shape=shape, dtype=dtype, method=method):
                steps, dims = 8, len(shape)
                source, target, found = move(shape, dtype, steps, method=method, iterations=20, force_weight=1.0)
                self.assertEqual(found.density.shape, (steps + 1, *shape))
                self.assertEqual(found.density.dtype, dtype)
                for axis in range(dims):
                    faces = list(shape)
                    faces[dims - 1 - axis] += 1
                    self.assertEqual(found.velocity[axis].shape, (steps, *faces))
                    self.assertEqual(found.force[axis].shape, (steps - 1, *faces))
                tolerance = 1e-4 if dtype == np.float32 else 1e-9
                masses = found.density.astype(np.float64).sum(axis=tuple(range(1, dims + 1)))
                np.testing.assert_allclose(masses, masses[0], rtol=tolerance)
                np.testing.assert_array_equal(found.density[0], source)
                speed = max(np.abs(component).max() for component in found.velocity)
                self.assertGreater(speed, 0.01)
                self.assertLess(np.abs(divergence(found.velocity)).max(), 1e-4 * speed)
                before = np.linalg.norm(source - target)
                self.assertLess(np.linalg.norm(found.density[-1] - target), 0.7 * before)
                # Keyframes are scaled to the mass of the source.
                wanted = found.mass_factors[0] * target
                size = np.linalg.norm(wanted)
                np.testing.assert_allclose(found.keyframe_errors, [np.linalg.norm(found.density[-1] - wanted) / size], rtol=1e-4)
                np.testing.assert_allclose(found.keyframe_errors_before, [np.linalg.norm(source - wanted) / size], rtol=1e-4)
                # Nothing, but that it ended before its gradient was small.
                self.assertTrue(all("the gradient is still" in remark for remark in found.remarks), found.remarks)

    def test_outputs_are_gone_through(self):
        for shape, dtype, boundary in [((24, 20), np.float32, "wall"), ((8, 9, 10), np.float64, ["periodic", "wall", "periodic"])]:
            with self.subTest(shape=shape):
                _, _, found = move(shape, dtype, 6, iterations=2, boundary=boundary)
                outputs = found.outputs
                self.assertEqual([*outputs], ["density", "velocity", "force"])
                self.assertEqual([(each.place, each.unit) for each in outputs.values()], [("cells", "density"), ("faces", "velocity"), ("faces", "force")])
                for name, output in outputs.items():
                    self.assertEqual(output.name, name)
                    self.assertIn(name, repr(output))
                    self.assertTrue(output.words)
                    self.assertEqual(len(output.arrays), 1 if output.place == "cells" else len(shape))
                    ours = [found.density] if name == "density" else getattr(found, name)
                    for array, our in zip(output.arrays, ours):
                        self.assertEqual((array.ctypes.data, array.shape, array.strides), (our.ctypes.data, our.shape, our.strides))
                        self.assertIs(array.base, found)

    def test_outputs_outlive_the_name(self):
        _, _, found = move((24, 20), np.float32, 6, iterations=2)
        before, velocity = found.velocity[0].tobytes(), found.outputs["velocity"]
        del found
        gc.collect()
        self.assertEqual(velocity.arrays[0].tobytes(), before)

    def test_two_steps(self):
        """One force and two velocities, of which one is given."""
        for boundary in ("wall", "periodic"):
            _, _, found = move((12, 10), np.float64, 2, iterations=2, boundary=boundary)
            self.assertEqual([len(found.velocity[0]), len(found.force[0])], [2, 1])
            self.assertEqual(found.velocity_in_place[0].shape, (1, 12, 10))
            np.testing.assert_array_equal(found.velocity_in_place[0], found.velocity[0][1:, :, :10])
            np.testing.assert_array_equal(found.force_in_place[0], found.force[0][:, :, :10])

    def test_facts_are_gone_through(self):
        for method in ("direct", "admm", "lbfgs", "pd"):
            with self.subTest(method=method):
                _, _, found = move((16, 16), np.float64, 4, iterations=2, method=method)
                for entry in found.history:
                    self.assertEqual([*entry.facts], [*entry.fact_words])
                    self.assertTrue(all(entry.fact_words.values()))
                    self.assertTrue(all(isinstance(value, (float, int, list)) for value in entry.facts.values()))
                    for name in ("density_change", "gap", "kkt"):
                        self.assertEqual(getattr(entry, name), entry.facts.get(name))
                self.assertEqual(bool(found.history[0].facts), method != "pd")
                if method == "admm":
                    self.assertIsInstance(found.history[0].facts["held"], bool)
                    self.assertIsInstance(found.history[0].facts["nso_residuals"], list)

    def test_nothing_moved(self):
        _, _, found = move((24, 20), np.float32, 8, iterations=10, force_weight=1e13)
        self.assertGreater(found.keyframe_errors[0], 0.95 * found.keyframe_errors_before[0])
        self.assertEqual(len(found.remarks), 1)
        self.assertIn("force_weight is 1.0e13, and 1000 in the examples: try 1.00e3", found.remarks[0])

    def test_objective(self):
        _, _, found = move((24, 20), np.float64, 8, iterations=15, force_weight=1.0, smoothness=0.0)
        last = [entry.objective for entry in found.history if entry.cells == [20, 24]]
        self.assertGreater(len(last), 3)
        self.assertTrue(all(after <= before for before, after in zip(last, last[1:])))
        self.assertAlmostEqual(found.objective, found.data_term + found.force_term)
        self.assertEqual([entry.iteration for entry in found.history], list(range(1, len(found.history) + 1)))
        # The price of the force by its definition: r/2 times the squares, each weighted by its share of the volume.
        price = 0.5 * 1.0 * sum(float((component**2).sum()) for component in found.force)
        ratio = found.force_term / price
        again = thurible_smoke.solve(*self.moved(), iterations=15, force_weight=4.0, smoothness=0)
        price = 0.5 * 4.0 * sum(float((component**2).sum()) for component in again.force)
        self.assertAlmostEqual(again.force_term / price, ratio, delta=1e-6 * ratio)
        # By default its curl has a price too.
        smooth = thurible_smoke.solve(*self.moved(), iterations=15, force_weight=4.0)
        price = 0.5 * 4.0 * sum(float((component**2).sum()) for component in smooth.force)
        self.assertGreater(smooth.force_term / price, 1.1 * ratio)

    def moved(self):
        return blob((24, 20), [0.5, 0.4], 0.2, np.float64), [(8, blob((24, 20), [0.55, 0.6], 0.2, np.float64))]

    def test_force_of_flow(self):
        """The projected momentum equation holds: a flow at rest stays at rest, and one without force keeps its smoke."""
        source = blob((16, 16), [0.5, 0.5], 0.2, np.float64)
        found = thurible_smoke.solve(source, {}, steps=4, method="simulate")
        self.assertEqual(max(np.abs(component).max() for component in found.velocity), 0.0)
        np.testing.assert_array_equal(found.density[-1], source)

    def test_units_and_start(self):
        rng = np.random.default_rng(1)
        stream = rng.normal(size=(17, 13))
        stream[[0, -1], :] = stream[:, [0, -1]] = 0
        x, y = 0.02 * np.diff(stream, axis=0), -0.02 * np.diff(stream, axis=1)
        source, target = blob((16, 12), [0.5, 0.4], 0.2, np.float64), blob((16, 12), [0.5, 0.6], 0.2, np.float64)
        found = thurible_smoke.solve(source, {5: target}, initial_velocity=[x, y], dt=0.5, length=2.0, iterations=3)
        np.testing.assert_allclose(found.velocity[0][0], x, atol=1e-4)
        np.testing.assert_allclose(found.velocity[1][0], y, atol=1e-4)
        self.assertEqual((found.velocity_unit, found.force_unit), (4.0, 8.0))
        np.testing.assert_array_equal(found.velocity_in_place[0] * 4.0, found.velocity[0][1:, :, :-1])
        np.testing.assert_array_equal(found.velocity_in_place[1] * 4.0, found.velocity[1][1:, :-1, :])
        np.testing.assert_array_equal(found.force_in_place[1] * 8.0, found.force[1][:, :-1, :])
        for component, axis in zip(found.velocity, (2, 1)):
            walls = np.take(component, [0, -1], axis=axis)
            self.assertEqual(np.abs(walls).max(), 0.0)

    def test_periodic_axes_have_no_walls(self):
        _, _, found = move((10, 12, 14), np.float32, 4, boundary=["periodic", "wall", "periodic"], iterations=2)
        self.assertEqual([component.shape for component in found.velocity], [(4, 10, 12, 14), (4, 10, 13, 14), (4, 10, 12, 14)])

    def test_any_number_of_threads_gives_the_same_bits(self):
        for shape in [(24, 20), (8, 9, 10)]:
            (_, _, one), (_, _, two) = (move(shape, np.float32, 6, iterations=4, threads=threads) for threads in (1, 2))
            self.assertEqual((one.threads, two.threads), (1, 2))
            for left, right in zip((one.density, *one.velocity, *one.force), (two.density, *two.velocity, *two.force)):
                self.assertEqual(left.tobytes(), right.tobytes())

    def test_strides_of_input_do_not_matter(self):
        source, target = self.moved()[0], self.moved()[1][0][1]
        plain = thurible_smoke.solve(source, {8: target}, iterations=3)
        turned = thurible_smoke.solve(np.asfortranarray(source), {8: np.asfortranarray(target)}, iterations=3)
        self.assertEqual(plain.density.tobytes(), turned.density.tobytes())

    def test_numbers_beside_the_bounds_of_their_size(self):
        """A field of a packed record, and bytes that begin anywhere."""
        source, target = self.moved()[0], self.moved()[1][0][1]
        record = np.zeros(source.shape, np.dtype([("flag", "u1"), ("density", source.dtype)]))
        record["density"] = source
        shifted = np.frombuffer(b"x" + target.tobytes(), target.dtype, offset=1).reshape(target.shape)
        self.assertFalse(shifted.flags.aligned)
        plain = thurible_smoke.solve(source, {8: target}, iterations=3)
        found = thurible_smoke.solve(record["density"], {8: shifted}, iterations=3)
        self.assertEqual(plain.density.tobytes(), found.density.tobytes())

    @unittest.skipUnless("THURIBLE_PROGRAM" in os.environ, "THURIBLE_PROGRAM is not set")
    def test_same_bits_as_the_program(self):
        cases = [((20, 24), "f32", "direct", ""), ((20, 24), "f64", "admm", ""), ((8, 9, 10), "f32", "direct", 'boundary = ["wall", "periodic", "wall"]')]
        for shape, precision, method, boundary in cases:
            with self.subTest(shape=shape, precision=precision, method=method), tempfile.TemporaryDirectory() as name:
                folder, dtype = pathlib.Path(name), np.float32 if precision == "f32" else np.float64
                dims = len(shape)
                source, target = blob(shape, [0.5] * (dims - 1) + [0.4], 0.2, dtype), blob(shape, [0.5] * (dims - 1) + [0.6], 0.2, dtype)
                np.save(folder / "source.npy", source)
                np.save(folder / "target.npy", target)
                cells = list(reversed(shape))
                scene = f"""
                    [grid]
                    cells = {cells}
                    length = 2.0
                    {boundary}
                    [time]
                    steps = 8
                    dt = 0.5
                    [source]
                    file = "source.npy"
                    [[keyframe]]
                    step = 8
                    file = "target.npy"
                    [control]
                    force_weight = 0.5
                    [flow]
                    viscosity = 1e-4
                    [method]
                    name = "{method}"
                    iterations = 4
                """
                (folder / "scene.toml").write_text("\n".join(line.strip() for line in scene.splitlines()))
                command = [os.environ["THURIBLE_PROGRAM"], "solve", "scene.toml", "--precision", precision, "--quiet", "-o", "out", "--threads", "2"]
                subprocess.run([*command, "--set", "output.frames=false"], cwd=folder, check=True)
                choices = {"boundary": ["wall", "periodic", "wall"]} if boundary else {}
                found = thurible_smoke.solve(
                    source, {8: target}, method=method, iterations=4, dt=0.5, length=2.0, force_weight=0.5, viscosity=1e-4, threads=1, **choices
                )
                file = np.load(folder / "out" / "result.npz")
                ours = {"density": found.density}
                for axis in range(dims):
                    ours[f"velocity_{'xyz'[axis]}"] = found.velocity[axis]
                    ours[f"force_{'xyz'[axis]}"] = found.force[axis]
                for key, array in ours.items():
                    self.assertEqual((key, array.shape, array.dtype), (key, file[key].shape, file[key].dtype))
                    self.assertEqual(array.tobytes(), file[key].tobytes(), key)


class Effects(unittest.TestCase):
    """Emitters, buoyancy, weights, regions, a schedule and a release."""

    def setUp(self):
        self.shape = (20, 16)
        self.below = blob(self.shape, [0.2, 0.5], 0.12, np.float64)
        self.above = blob(self.shape, [0.6, 0.5], 0.12, np.float64)

    def test_mass_grows_by_what_is_emitted(self):
        emitters = [{"shape": self.below, "to": 5, "rate": 0.25}, {"shape": self.above, "from": 6, "to": 9, "target": 1.5}]
        for method in ("direct", "lbfgs", "pd", "simulate", "admm"):
            with self.subTest(method=method):
                found = thurible_smoke.solve(None, {6: self.above}, steps=10, emitters=emitters, match_mass=False, buoyancy=1e-3, method=method, iterations=4)
                self.assertEqual((found.emission.shape, found.emission.dtype), ((10, *self.shape), np.float64))
                self.assertIs(found.emission.base, found)
                grown, emitted = np.diff(found.density.sum(axis=(1, 2))), found.emission.sum(axis=(1, 2))
                np.testing.assert_allclose(grown, emitted, atol=1e-8)
                np.testing.assert_allclose(emitted[:6], [0.25 * self.below.sum()] * 5 + [0], atol=1e-8)
                self.assertTrue((emitted[6:9] > 0).all() and emitted[9] == 0)
                self.assertTrue((found.emission >= -1e-12).all())
                self.assertEqual(found.emission[:, self.below + self.above == 0].max(initial=0), 0)
                self.assertEqual(found.density[0].max(), 0)

    def test_emitters_push(self):
        """Where the smoke comes with a velocity the flow has it too; ADMM knows none."""
        emitters = [{"shape": self.below, "rate": 0.25, "velocity": [0.03, 0.0]}]
        for method in ("direct", "lbfgs", "simulate"):
            found = thurible_smoke.solve(None, {6: self.above}, emitters=emitters, match_mass=False, method=method, iterations=2)
            self.assertGreater(found.velocity[0][2].max(), 0.01, method)
            self.assertEqual([part.shape for part in found.emitter_force], [force.shape for force in found.force])
            # What they add at first takes a flow at rest to their velocity, where the shape is 1, over one step.
            first = found.emitter_force[0][0]
            self.assertAlmostEqual(first.max(), 0.03, delta=3e-3)
            self.assertEqual(np.abs(found.emitter_force[1][0]).max(), 0)
            self.assertLess(np.abs(first[self.below.max(axis=1) < 1e-4]).max(), 1e-4)
        with self.assertRaisesRegex(ValueError, "the method admm knows no velocity of emitters"):
            thurible_smoke.plan(self.shape, [6], emitters=emitters, method="admm", smoothness=0.0)
        with self.assertRaisesRegex(ValueError, r"emitters\[0\]..velocity.\] has 1 entries, but must have 2"):
            thurible_smoke.plan(self.shape, [6], emitters=[{"rate": 1.0, "velocity": [1.0]}])

    def test_templates_are_found(self):
        """The force is made of them; a simulation takes them as they are given."""
        templates = [
            {"kind": "wind", "center": [0.5, 0.4], "radius": 0.3, "interval": 3},
            {"kind": "vortex", "center": [0.4, 0.4], "radius": 0.2, "to": 5, "move": True, "amplitude": 1e-3},
            {"kind": "noise", "center": [0.4, 0.4], "radius": 0.2, "size": 0.1, "seed": 3},
        ]
        found = thurible_smoke.solve(self.below, {8: self.above}, templates=templates, force_weight=1.0, iterations=5)
        wind, vortex, noise = found.templates
        self.assertEqual((wind["kind"], wind["center"], wind["radius"], wind["to"]), ("wind", [0.5, 0.4], 0.3, 7))
        self.assertEqual([len(one["amplitude"]) for one in found.templates], [3, 1, 1])
        self.assertEqual([len(one["amplitude"][0]) for one in found.templates], [2, 1, 1])
        self.assertNotEqual(vortex["radius"], 0.2)
        self.assertEqual((noise["seed"], "seed" in wind), (3, False))
        self.assertLess(found.data_term, found.history[0].data)
        free = thurible_smoke.solve(self.below, {}, steps=8, templates=templates, method="simulate")
        self.assertGreater(np.abs(free.force[0]).max(), 1e-6)
        self.assertEqual(free.templates[1]["amplitude"], [[1e-3]])
        self.assertEqual(thurible_smoke.solve(self.below, {8: self.above}, iterations=1).templates, [])
        good = templates[0]
        for odd, words in [
            ({"kind": "storm"}, r"templates\[0\]..kind.\] is .storm., but must be"),
            ({"center": [0.5]}, r"templates\[0\]..center.\] has 1 entries, but must have 2"),
            ({"radius": 0.0}, r"templates\[0\]..radius.\] is 0"),
            ({"radius": None}, r"templates\[0\] has no radius"),
            ({"seed": 1}, r"templates\[0\]..seed.\] is an argument of noise alone"),
            ({"from": 7}, "template 0 must act from a force to a later one"),
            ({"center": [0.5, 2.0]}, "template 0 has its middle at 2 along axis 1"),
        ]:
            with self.subTest(odd=odd), self.assertRaisesRegex(ValueError, words):
                thurible_smoke.plan(self.shape, [8], templates=[good | odd])
        with self.assertRaisesRegex(TypeError, r"there is no key of templates\[0\] strength"):
            thurible_smoke.plan(self.shape, [8], templates=[good | {"strength": 1.0}])
        with self.assertRaisesRegex(ValueError, "the method direct knows no templates"):
            thurible_smoke.plan(self.shape, [8], templates=[good], method="direct")

    def test_emission_leaves_the_forces_alone(self):
        """The momentum that they give is that of the velocities, also where the solver's work is short."""
        for method in ("direct", "lbfgs"):
            found = thurible_smoke.solve(
                self.below, {3: self.above}, emitters=[{"shape": self.below, "rate": 0.1}], match_mass=False, force_weight=1.0, method=method, iterations=6
            )
            plain = thurible_smoke.solve(self.below, {3: self.above}, match_mass=False, force_weight=1.0, smoothness=0.0, method=method, iterations=6)
            for solution in (found, plain):
                self.assertLess(np.abs(divergence(solution.force)).max(), 1e-3 * max(np.abs(component).max() for component in solution.force))
            self.assertIsNone(plain.emission)
            self.assertIsNone(found.emitter_force)

    def test_keyframes_take_the_mass_of_the_smoke(self):
        found = thurible_smoke.solve(None, {4: self.above, 8: self.above}, emitters=[{"shape": self.below, "from": 1, "to": 6, "rate": 0.5}], iterations=3)
        ratio = self.below.sum() / self.above.sum()
        np.testing.assert_allclose(found.mass_factors, [1.5 * ratio, 2.5 * ratio])

    def test_smoke_rises(self):
        def height(density):
            return (density.sum(axis=1) * np.arange(self.shape[0])).sum() / density.sum()

        rising, falling, aside = (
            thurible_smoke.solve(self.above, {}, steps=8, method="simulate", buoyancy=buoyancy) for buoyancy in (5e-3, -5e-3, [5e-3, 0.0])
        )
        self.assertGreater(height(rising.density[-1]), height(self.above) + 0.1)
        self.assertLess(height(falling.density[-1]), height(self.above) - 0.1)
        self.assertAlmostEqual(height(aside.density[-1]), height(self.above), delta=0.05)
        # A flow that is steered knows of it too: less force lifts it.
        heavy, light = (thurible_smoke.solve(self.below, {8: self.above}, buoyancy=buoyancy, force_weight=30.0) for buoyancy in (0.0, 5e-3))
        self.assertLess(light.force_term, heavy.force_term)

    def test_no_force_after_the_release(self):
        found = thurible_smoke.solve(self.below, {5: self.above}, steps=9, release=6, force_weight=1.0, iterations=5)
        force = np.array([np.abs(component).max(axis=(1, 2)) for component in found.force]).max(axis=0)
        self.assertTrue((force[:4] > 0).all())
        self.assertEqual(force[5:].max(), 0)
        self.assertGreater(np.abs(found.velocity[1][-1]).max(), 0)
        alone = thurible_smoke.solve(self.below, {5: self.above}, steps=6, force_weight=1.0, iterations=5)
        self.assertEqual(found.density[:7].tobytes(), alone.density.tobytes())

    def test_no_smoke_gets_into_solid_cells(self):
        solids = np.zeros(self.shape, bool)
        solids[9:11, 4:] = True
        for method in ("direct", "lbfgs", "pd", "simulate", "admm"):
            with self.subTest(method=method):
                found = thurible_smoke.solve(self.below, {8: self.above}, solids=solids, buoyancy=2e-3, method=method, iterations=4)
                self.assertEqual(np.abs(found.density[:, solids]).max(), 0)
                across = found.velocity[1][:, :-1][:, solids]
                self.assertEqual(np.abs(across).max(), 0)
                self.assertGreater(np.abs(found.velocity[1]).max(), 0)
        with self.assertRaisesRegex(ValueError, "solids cannot be used: all cells are solid"):
            thurible_smoke.solve(self.below, {8: self.above}, solids=np.ones(self.shape, bool))
        with self.assertRaisesRegex(ValueError, "solids has dtype float64; give an array of truth values"):
            thurible_smoke.solve(self.below, {8: self.above}, solids=self.below)
        with self.assertRaisesRegex(ValueError, "only limited transport goes around solid cells; take that$"):
            thurible_smoke.solve(self.below, {8: self.above}, solids=solids, advection="quick")
        needed = [thurible_smoke.plan(self.shape, [8], solids=given).bytes for given in (solids, True, False, None)]
        self.assertEqual((needed[0], needed[2]), (needed[1], needed[3]))
        self.assertGreater(needed[0], needed[2])

    def test_force_acts_where_the_mask_lets_it(self):
        mask = np.zeros(self.shape)
        mask[:, :8] = 1.0
        found = thurible_smoke.solve(self.below, {8: self.above}, mask=mask, method="lbfgs", force_weight=1.0, iterations=8)
        force = np.abs(found.force[0])
        self.assertGreater(force.max(), 1e-6)
        self.assertLess(force[:, :, 12:].max(), 5e-2 * force.max())
        with self.assertRaisesRegex(ValueError, "mask cannot be used"):
            thurible_smoke.solve(self.below, {8: self.above}, mask=np.zeros(self.shape))
        with self.assertRaisesRegex(ValueError, "mask cannot be used: value 0 is above 1"):
            thurible_smoke.solve(self.below, {8: self.above}, mask=mask + 1)
        with self.assertRaisesRegex(ValueError, "the method admm knows no mask"):
            thurible_smoke.solve(self.below, {8: self.above}, mask=mask, method="admm")
        needed = [thurible_smoke.plan(self.shape, [8], mask=given).bytes for given in (mask, True, None)]
        self.assertEqual(needed[0], needed[1])
        self.assertGreater(needed[0], needed[2])

    def test_smoke_leaves_by_open_sides(self):
        wind = [np.zeros((20, 17)), np.full((21, 16), 1.5 / 20)]
        for method in ("direct", "lbfgs", "pd", "simulate"):
            with self.subTest(method=method):
                found = thurible_smoke.solve(
                    self.below, {16: self.above}, boundary=["wall", "open"], initial_velocity=wind, match_mass=False, method=method, iterations=3
                )
                mass = found.density.sum(axis=(1, 2))
                self.assertEqual(found.density.shape, (17, *self.shape))
                self.assertTrue((np.diff(mass) < 1e-9).all())
                # What drives smoke to its keyframe holds against the wind.
                self.assertLess(mass[-1], (1.0 if method == "pd" else 0.5) * mass[0] + 1e-9)
                self.assertEqual(found.velocity[1].shape, (16, 21, 16))
                self.assertGreater(np.abs(found.velocity[1][:, [0, -1]]).min(axis=(1, 2)).max(), 0.01)
                self.assertLess(np.abs(divergence(found.velocity)).max(), 1e-4)
        closed = [(boundary, thurible_smoke.solve(self.below, {4: self.above}, boundary=["wall", boundary], match_mass=False, iterations=1)) for boundary in ("open_low", "open_high")]
        for boundary, found in closed:
            walls = found.velocity[1][:, -1 if boundary == "open_low" else 0]
            self.assertEqual(np.abs(walls).max(), 0)
        with self.assertRaisesRegex(ValueError, "match_mass = False"):
            thurible_smoke.solve(self.below, {8: self.above}, boundary="open")
        with self.assertRaisesRegex(ValueError, "the method admm knows no open sides"):
            thurible_smoke.solve(self.below, {8: self.above}, boundary="open", match_mass=False, method="admm")

    def test_weights_regions_and_schedule(self):
        def solve(**choices):
            return thurible_smoke.solve(self.below, {4: self.above, 8: self.below}, force_weight=30.0, iterations=25, **choices)

        plain = solve()
        self.assertEqual(solve(weights={4: 1.0}, schedule=None).density.tobytes(), plain.density.tobytes())
        self.assertLess(solve(weights={4: 20.0}).keyframe_errors[0], plain.keyframe_errors[0])
        self.assertLess(solve(schedule={0: 0.05}).keyframe_errors[0], plain.keyframe_errors[0])
        self.assertGreater(solve(regions={4: np.full(self.shape, 0.1)}).keyframe_errors[0], plain.keyframe_errors[0])
        # Any mapping, and any pairs that can be gone through once.
        region = np.full(self.shape, 0.1)
        given = {"weights": {4: 2.0}, "schedule": {0: 0.5}, "regions": {4: region}}
        expected = solve(**given).density.tobytes()
        for other in (types.MappingProxyType, lambda pairs: iter(pairs.items()), lambda pairs: (pair for pair in pairs.items())):
            self.assertEqual(solve(**{name: other(pairs) for name, pairs in given.items()}).density.tobytes(), expected)
        everywhere = solve(regions={4: np.ones(self.shape)})
        np.testing.assert_allclose(everywhere.objective, plain.objective, rtol=1e-6)

    def test_plan(self):
        emitters = [{"shape": self.below, "rate": 0.5}]
        found = thurible_smoke.solve(None, {4: self.above}, steps=6, release=5, emitters=emitters, regions=[(4, self.below)], schedule={1: 2.0}, iterations=1, threads=1)
        shared = {"dtype": "float64", "steps": 6, "release": 5, "schedule": {1: 2.0}, "iterations": 1, "threads": 1}
        for regions in (True, {4: None}):
            plan = thurible_smoke.plan(self.shape, [4], emitters=[{"rate": 0.5}], regions=regions, **shared)
            self.assertEqual(plan.bytes, found.planned_bytes)
        self.assertLess(thurible_smoke.plan(self.shape, [4], emitters=None, regions=False, **shared).bytes, found.planned_bytes)

    @unittest.skipUnless("THURIBLE_PROGRAM" in os.environ, "THURIBLE_PROGRAM is not set")
    def test_same_bits_as_the_program(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            arrays = {"below": self.below, "above": self.above, "region": np.clip(2 * self.above, 0, 1)}
            for key, array in arrays.items():
                np.save(folder / f"{key}.npy", array)
            scene = """
                [grid]
                cells = [16, 20]
                [time]
                steps = 9
                [[emitter]]
                file = "below.npy"
                to = 4
                rate = 0.5
                [[emitter]]
                file = "above.npy"
                from = 6
                target = 0.75
                [[keyframe]]
                step = 6
                file = "above.npy"
                weight = 3.0
                region = { file = "region.npy" }
                [control]
                force_weight = 2.0
                schedule = [[0, 1.0], [6, 0.1]]
                match_mass = false
                [flow]
                buoyancy = 0.004
                [[release]]
                from = 7
                [method]
                iterations = 4
            """
            (folder / "scene.toml").write_text("\n".join(line.strip() for line in scene.splitlines()))
            command = [os.environ["THURIBLE_PROGRAM"], "solve", "scene.toml", "--precision", "f64", "--quiet", "-o", "out", "--threads", "2"]
            subprocess.run([*command, "--set", "output.frames=false"], cwd=folder, check=True)
            file = np.load(folder / "out" / "result.npz")
            found = thurible_smoke.solve(
                None, {6: self.above}, steps=9, buoyancy=0.004, force_weight=2.0, schedule=[(0, 1.0), (6, 0.1)], match_mass=False, release=7, iterations=4,
                emitters=[{"shape": self.below, "to": 4, "rate": 0.5}, {"shape": self.above, "from": 6, "target": 0.75}],
                weights={6: 3.0}, regions={6: arrays["region"]},
            )
            ours = {"density": found.density, "emission": found.emission, "velocity_y": found.velocity[1], "force_x": found.force[0]}
            for key, array in ours.items():
                self.assertEqual((key, array.shape, array.tobytes()), (key, file[key].shape, file[key].tobytes()))


class Memory(unittest.TestCase):
    def test_arrays_borrow_the_solution(self):
        _, _, found = move((24, 20), np.float32, 6, iterations=2)
        arrays = [found.density, *found.velocity, *found.force, *found.velocity_in_place, *found.force_in_place]
        for array in arrays:
            self.assertIs(array.base, found)
            self.assertFalse(array.flags.owndata)
            self.assertFalse(array.flags.writeable)
            with self.assertRaises(ValueError):
                array[0] = 1
        for first, second in [(found.density, found.density), (found.velocity[1], found.velocity[1]), (found.force[0], found.force[0])]:
            self.assertEqual(first.ctypes.data, second.ctypes.data)
        address = lambda array: array.ctypes.data
        for array in (*found.velocity_in_place, *found.force_in_place):
            self.assertLess(abs(address(array) - address(found.density)), found.planned_bytes)

    def test_arrays_outlive_the_name(self):
        _, _, found = move((24, 20), np.float64, 6, iterations=2)
        density, velocity = found.density, found.velocity[0]
        before = density.tobytes(), velocity.tobytes()
        del found
        gc.collect()
        held = [np.full(density.shape, 7.0) for _ in range(20)]
        self.assertEqual((density.tobytes(), velocity.tobytes()), before)
        del held

    def test_solutions_are_given_back(self):
        def resident():
            with open("/proc/self/statm") as statm:
                return int(statm.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")

        size = move((128, 128), np.float32, 10, iterations=1)[2].planned_bytes
        before = resident()
        for _ in range(6):
            move((128, 128), np.float32, 10, iterations=1)
        self.assertLess(resident() - before, 2 * size)

    def test_plan(self):
        _, _, found = move((24, 20), np.float64, 6, iterations=2, threads=2)
        plan = thurible_smoke.plan((24, 20), [6], dtype=np.float64, threads=2, iterations=2)
        self.assertEqual(plan.bytes, found.planned_bytes)
        self.assertEqual(plan.bytes, sum(size for _, size, depth in plan.ledger if depth == 0))
        self.assertEqual(plan.method_bytes, plan.ledger[0][1])
        self.assertEqual(plan.paper_bound, 4 * 3 * 6 * 24 * 20 * 8 * 4 // 3)
        self.assertEqual(thurible_smoke.plan((24, 20), {6: None, 4: None}, threads=1).bytes, thurible_smoke.plan((24, 20), [4, 6], threads=1).bytes)
        with self.assertRaisesRegex(ValueError, "dtype is int32"):
            thurible_smoke.plan((24, 20), [6], dtype=np.int32)
        for method in ("direct", "lbfgs"):
            options = {"history": 5, "history_precision": "half"}
            _, _, found = move((24, 20), np.float32, 6, method=method, iterations=4, threads=1, options=options)
            in_halves = thurible_smoke.plan((24, 20), [6], method=method, threads=1, options=options)
            in_full = thurible_smoke.plan((24, 20), [6], method=method, threads=1, options={"history": 5})
            self.assertEqual(found.planned_bytes, in_halves.bytes)
            self.assertLess(in_halves.bytes, in_full.bytes)

    def test_ceiling(self):
        needed = thurible_smoke.plan((24, 20), [6], threads=1, options={"history": 1}).bytes
        _, _, found = move((24, 20), np.float32, 6, iterations=2, threads=1, memory_limit=needed)
        self.assertEqual(found.planned_bytes, needed)
        with self.assertRaisesRegex(MemoryError, f"needs {needed:,} bytes, but memory_limit allows {needed - 1:,}; raise memory_limit"):
            move((24, 20), np.float32, 6, threads=1, memory_limit=needed - 1)
        with self.assertRaises(MemoryError):
            thurible_smoke.plan((4096, 4096, 4096), [100000])


class Watching(unittest.TestCase):
    def test_callback_hears_every_iteration(self):
        heard, caller = [], threading.get_ident()
        _, _, found = move((24, 20), np.float32, 6, iterations=4, threads=2, progress=lambda entry: heard.append((entry.iteration, threading.get_ident())))
        self.assertEqual([iteration for iteration, _ in heard], [entry.iteration for entry in found.history])
        self.assertEqual({thread for _, thread in heard}, {caller})

    def test_false_stops(self):
        for stop in (1, 3):
            _, _, found = move((24, 20), np.float32, 6, iterations=50, progress=lambda entry: entry.iteration < stop)
            self.assertEqual((found.status, len(found.history)), ("cancelled", stop))
            self.assertTrue(np.isfinite(found.density).all() and found.objective > 0)

    def test_exceptions_pass_through(self):
        class Enough(Exception):
            pass

        def progress(entry):
            raise Enough(entry.iteration)

        with self.assertRaises(Enough) as caught:
            move((24, 20), np.float32, 6, progress=progress)
        self.assertEqual(caught.exception.args, (1,))
        with self.assertRaisesRegex(TypeError, "what progress returned is 'no', but must be None, True or False"):
            move((24, 20), np.float32, 6, progress=lambda entry: "no")

    def test_references_are_given_back(self):
        class Callback:
            def __call__(self, entry):
                pass

        callback = Callback()
        alive = weakref.ref(callback)
        move((24, 20), np.float32, 6, iterations=2, progress=callback)
        del callback
        gc.collect()
        self.assertIsNone(alive())

    def test_interrupt(self):
        """Ctrl-C within an iteration, without a callback."""
        # A shell that starts the tests in the background has Ctrl-C ignored.
        self.addCleanup(signal.signal, signal.SIGINT, signal.signal(signal.SIGINT, signal.default_int_handler))
        timer = threading.Timer(0.4, os.kill, (os.getpid(), signal.SIGINT))
        began = time.process_time()
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            move((256, 256), np.float64, 60, iterations=500, options={"tolerance": 1e-12})
        self.assertLess(time.process_time() - began, 20)

    def test_other_threads_run(self):
        counted, over = [0], threading.Event()

        def count():
            while not over.is_set():
                counted[0] += 1
                time.sleep(0.001)

        beside = threading.Thread(target=count)
        seen = []
        beside.start()
        move((128, 128), np.float32, 20, iterations=5, threads=1, progress=lambda entry: seen.append(counted[0]))
        over.set()
        beside.join()
        # Counted between two iterations, in which no line of Python of the solving thread ran.
        self.assertGreater(max(after - before for before, after in zip(seen, seen[1:])), 5)


class Refusals(unittest.TestCase):
    def setUp(self):
        self.source = blob((12, 12), [0.5, 0.4], 0.2, np.float32)
        self.target = blob((12, 12), [0.5, 0.6], 0.2, np.float32)

    def refuse(self, kind, words, source=None, keyframes=None, **choices):
        with self.assertRaisesRegex(kind, words):
            thurible_smoke.solve(self.source if source is None else source, {6: self.target} if keyframes is None else keyframes, **choices)

    def test_arrays(self):
        self.refuse(TypeError, "source is a list; give a NumPy array", source=[[1.0]])
        self.refuse(ValueError, r"source has dtype int64; .*astype", source=self.source.astype(np.int64))
        self.refuse(ValueError, "source has 1 axes", source=self.source[0])
        self.refuse(ValueError, "source cannot be used: value 3 is not finite", source=np.where(np.arange(144).reshape(12, 12) == 3, np.nan, self.source))
        self.refuse(ValueError, "source cannot be used: it is empty", source=0 * self.source)
        self.refuse(ValueError, r"keyframes\[6\] has dtype float64 where the source has float32", keyframes={6: self.target.astype(np.float64)})
        self.refuse(ValueError, r"keyframes\[6\] has shape \[12, 11\]", keyframes={6: self.target[:, 1:]})
        self.refuse(ValueError, r"keyframes\[6\] holds -.* at \[\d+, \d+\]; a density is never negative", keyframes={6: self.target - 1})
        self.refuse(ValueError, r"initial_velocity\[1\] has shape", initial_velocity=[np.zeros((12, 13), np.float32)] * 2)
        self.refuse(ValueError, "initial_velocity has 1 entries", initial_velocity=[np.zeros((12, 13), np.float32)])

    def test_masked_arrays(self):
        hidden = lambda array: np.ma.masked_array(array, mask=array > 0.9)
        self.refuse(TypeError, r"source is a masked array.*source\.filled\(0\)", source=hidden(self.source))
        self.refuse(TypeError, r"keyframes\[6\] is a masked array.*\.filled\(0\)", keyframes={6: hidden(self.target)})
        faces = [np.zeros((12, 13), np.float32), hidden(np.zeros((13, 12), np.float32))]
        self.refuse(TypeError, r"initial_velocity\[1\] is a masked array.*\.filled\(0\)", initial_velocity=faces)

    def test_undershoot_becomes_zero(self):
        """What a scheme leaves below 0 is taken as 0, with a warning; the array itself is not written to."""
        source = self.source.copy()
        source[0, 3] = -0.006
        before = source.copy()
        with self.assertWarnsRegex(UserWarning, "source holds 1 value below 0, the least -6.000e-3; it becomes 0"):
            found = thurible_smoke.solve(source, {6: self.target}, iterations=2)
        np.testing.assert_array_equal(source, before)
        np.testing.assert_array_equal(found.density[0], np.maximum(source, 0))

    def test_keyframes(self):
        self.refuse(ValueError, "keyframe is at step 7; it must be from 2 to steps = 6", keyframes={7: self.target}, steps=6)
        self.refuse(ValueError, "keyframe at step 6 is not after", keyframes=[(6, self.target), (6, self.target)])
        self.refuse(ValueError, "steps is missing", keyframes={})
        self.refuse(ValueError, "no keyframe", keyframes={}, steps=6)
        self.refuse(TypeError, "keyframes is 7, but must be a dict", keyframes=7)

    def test_numbers(self):
        for choices, words in [
            ({"dt": 0.0}, "dt is 0; it must be positive"),
            ({"dt": float("nan")}, "dt is NaN"),
            ({"length": -1}, "length is -1"),
            ({"force_weight": 0}, "force_weight is 0"),
            ({"viscosity": -1e-3}, "viscosity is -0.001"),
            ({"slip": False}, "by its viscosity, and that is 0"),
            ({"advection_tolerance": 0}, "advection_tolerance is 0"),
            ({"projection_tolerance": -1}, "projection_tolerance is -1"),
            ({"filters": 13}, "filters is 13; it must be at most 12"),
            ({"filters": -1}, "filters is -1, but must be"),
            ({"iterations": 0}, "iterations is 0"),
            ({"threads": 0}, "threads is 0"),
            ({"threads": -1}, "threads is -1, but must be"),
            ({"boundary": "closed"}, "boundary is \"closed\""),
            ({"boundary": ["wall"]}, "boundary has 1 entries"),
            ({"advection": "upwind"}, "advection is \"upwind\", but must be \"quick\""),
            ({"method": "newton"}, "method is \"newton\""),
            ({"method": "admm", "options": {"penalty": -1}}, "admm.penalty is -1"),
            ({"method": "admm", "options": {"nso_cycles": 64}}, "admm.nso_cycles is 64; it must be from 1 to 63"),
            ({"method": "admm", "options": {"nso": "magic"}}, "options.\"nso\". is \"magic\", but must be \"stfas\" or \"newton_cg\""),
            ({"options": {"history": 9}}, "direct.history is 9"),
            ({"options": {"history_precision": "quarter"}}, "options.\"history_precision\". is \"quarter\", but must be \"full\" or \"half\""),
            ({"options": [1]}, "options is no dict"),
            ({"progress": 3}, "progress cannot be called"),
        ]:
            with self.subTest(choices=choices):
                self.refuse(ValueError, words, **choices)

    def test_effects(self):
        plume = {"shape": self.source, "to": 4, "rate": 0.5}
        with self.assertRaisesRegex(ValueError, "source is None, and there are no emitters; give an array, or emitters"):
            thurible_smoke.solve(None, {6: self.target})
        for emitter, words in [
            ({"rate": None}, r"emitters\[0\] has neither a rate nor a target; give"),
            ({"target": 1.0}, r"emitters\[0\] has a rate and a target; .*take one of them out"),
            ({"rate": 0.0}, r"emitters\[0\]..rate.\] is 0; it must be positive and finite"),
            ({"from": 4}, r"emitters\[0\] emits from step 4 to step 4; it must be to a later one, at most steps = 6"),
            ({"to": 7}, r"emitters\[0\] emits from step 0 to step 7; .*at most steps = 6"),
            ({"shape": None}, r"emitters\[0\] has no shape; give an array"),
            ({"shape": 0 * self.source}, r"emitters\[0\]..shape.\] cannot be used: it is empty"),
            ({"shape": self.source[1:]}, r"emitters\[0\]..shape.\] has shape \[11, 12\] where \[12, 12\] is needed"),
            ({"shape": self.source.astype(np.float64)}, r"emitters\[0\]..shape.\] has dtype float64 where the source has float32"),
            ({"rate": None, "target": 1.0}, "the mass of the smoke is not known before; take match_mass = False, or a rate$"),
        ]:
            with self.subTest(emitter=emitter):
                self.refuse(ValueError, words, emitters=[{**plume, **emitter}])
        with self.assertRaisesRegex(ValueError, r"keyframes\[6\] has dtype float32 where emitters\[0\]..shape.\] has float64"):
            thurible_smoke.solve(None, {6: self.target}, emitters=[{**plume, "shape": self.source.astype(np.float64)}])
        with self.assertRaisesRegex(ValueError, r"keyframes\[2\] cannot be used: there is no smoke yet"):
            thurible_smoke.solve(None, {2: self.target, 6: self.target}, emitters=[{**plume, "from": 2}])
        for choices, words in [
            ({"buoyancy": [0.1]}, "buoyancy has 1 entries, but must be a number, or a sequence of 2"),
            ({"buoyancy": float("nan")}, "buoyancy is NaN; it must be finite"),
            ({"schedule": {1: 0.5}, "method": "admm"}, "the method admm knows no schedule; take another method, or leave it out$"),
            ({"schedule": {1: 0.0}}, r"schedule\[1\] is 0; it must be positive"),
            ({"schedule": [(1, 1.0), (1, 2.0)]}, "the schedule's step 1 is not after the one before it"),
            ({"weights": {6: -1.0}}, r"weights\[6\] is -1; it must be positive"),
            ({"weights": {5: 1.0}}, "weights has step 5, where no keyframe stands; give a step of keyframes"),
            ({"weights": [(6, 1.0), (6, 9.0)]}, "weights has step 6 twice; give each step once"),
            ({"emitters": [{**plume, "rate": None, "target": 1.0}]}, "take match_mass = False"),
            ({"boundary": "open"}, "take match_mass = False"),
            ({"regions": {5: self.target}}, "regions has step 5, where no keyframe stands"),
            ({"regions": {6: self.target[1:]}}, r"regions\[6\] has shape"),
            ({"regions": {6: self.target + 1}}, r"regions\[6\] cannot be used: value \d+ is above 1"),
            ({"release": 6}, "release is 6; it must be from 2 to a step before the end at 6"),
            ({"release": 4, "steps": 8}, "a keyframe is at step 6, after the release at step 4"),
        ]:
            with self.subTest(choices=choices):
                self.refuse(ValueError, words, **choices)
        self.refuse(TypeError, r"emitters is 3, but must be a list of dicts", emitters=3)
        self.refuse(ValueError, r"emitters\[0\] is no dict; give a dict of shape, from, to", emitters=[3])
        self.refuse(TypeError, r"there is no key of emitters\[0\] begin; there are shape, from", emitters=[{**plume, "begin": 1}])
        self.refuse(TypeError, r"emitters\[0\]..from.\] is 'soon', but must be a whole number from 0", emitters=[{**plume, "from": "soon"}])
        self.refuse(TypeError, "buoyancy is 'up', but must be a number, or a sequence of 2", buoyancy="up")
        self.refuse(TypeError, "regions is True, but must be a dict", regions=True)
        for name in ("solids", "mask"):
            with self.assertRaisesRegex(TypeError, f"{name} is 'no', but must be an array, or where a plan is made True or False"):
                thurible_smoke.plan((12, 12), [6], **{name: "no"})
        with self.assertRaisesRegex(ValueError, "keyframes cannot be gone through; give the steps"):
            thurible_smoke.plan((12, 12), 6)

    def test_types(self):
        self.refuse(TypeError, "dt is 'soon', but must be a number", dt="soon")
        self.refuse(TypeError, "match_mass is 'yes', but must be True or False", match_mass="yes")
        self.refuse(TypeError, "options.\"nested\". is 1, but must be True or False", options={"nested": 1})
        self.refuse(TypeError, "there is no argument stepz; there are steps", stepz=3)
        self.refuse(TypeError, "there is no option of this method penalty; there are history", options={"penalty": 1.0})


class Guide(unittest.TestCase):
    def test_a_flow_is_followed(self):
        y, x = np.mgrid[0:24, 0:20]
        source = (np.hypot(x - 9.5, y - 7.5) < 4).astype(np.float64)
        rises = thurible_smoke.solve(source, {}, steps=6, method="simulate", buoyancy=5e-3)
        still = thurible_smoke.solve(source, {}, steps=6, method="guide", reference=rises.velocity)
        apart = np.linalg.norm(still.density[6] - rises.density[6]) / np.linalg.norm(source - rises.density[6])
        self.assertLess(apart, 0.25)
        loose = thurible_smoke.solve(source, {}, steps=6, method="guide", reference=rises.velocity, options={"kinetic": 100.0})
        self.assertGreater(np.linalg.norm(loose.density[6] - rises.density[6]), np.linalg.norm(still.density[6] - rises.density[6]))
        with self.assertRaisesRegex(ValueError, r"reference\[0\] has shape"):
            thurible_smoke.solve(source, {}, steps=5, method="guide", reference=rises.velocity)
        with self.assertRaisesRegex(ValueError, "there is no flow to follow"):
            thurible_smoke.solve(source, {}, steps=6, method="guide")


class Track(unittest.TestCase):
    """The flow behind frames."""

    def frames(self, dtype, shape=(20, 24), count=4):
        return np.stack([blob(shape, [0.5] * (len(shape) - 1) + [0.35 + 0.03 * k], 0.25, dtype) for k in range(count)])

    def test_a_moving_blob_is_found(self):
        for dtype, boundary in [(np.float32, "wall"), (np.float64, ["periodic", "wall"])]:
            frames = self.frames(dtype)
            found = thurible_smoke.track(frames, boundary=boundary, length=24.0, threads=2, options={"beta": 0.01, "alpha": 0.1})
            u, v = found.velocity
            self.assertEqual((u.dtype, u.shape), (dtype, (3, 20, 25 if boundary == "wall" else 24)))
            self.assertEqual(v.shape, (3, 21, 24))
            self.assertGreater(u[2, 9:11, 10].mean(), 0.3)
            for own, predicted, correction in zip(found.velocity, found.predicted, found.correction):
                np.testing.assert_allclose(own, predicted + correction, atol=1e-5)
            if boundary == "wall":
                self.assertLess(np.abs(np.diff(u, axis=2) + np.diff(v, axis=1)).max(), 1e-4)
            np.testing.assert_array_equal(found.density[0], frames[0])
            self.assertEqual([pair["frame"] for pair in found.history], [0, 1, 2])
            self.assertLess(found.history[0]["misfit"], 0.9 * found.history[0]["misfit_predicted"])
            self.assertGreater(found.planned_bytes, 0)

    def test_forces_bring_each_flow_to_the_next(self):
        for boundary in "wall", "periodic":
            frames = self.frames(np.float64)
            choices = {"boundary": boundary, "dt": 0.5, "length": 2.0}
            self.assertIsNone(thurible_smoke.track(frames, **choices).force)
            found = thurible_smoke.track(frames, options={"forces": True}, **choices)
            steps = len(frames) - 2
            operator = thurible_smoke.Operator(frames.shape[1:], steps, tolerance=1e-12, **choices)
            densities, velocities = operator.simulate(frames[0], [v[0] for v in found.velocity], found.force)
            for reached, tracked, force in zip(velocities, found.velocity, found.force):
                self.assertEqual(len(force), steps)
                size = np.abs(tracked).max()
                self.assertGreater(np.abs(tracked[-1] - tracked[0]).max(), 0.01 * size)
                np.testing.assert_allclose(reached[-1], tracked[-1], atol=1e-5 * size)

    def test_what_no_flow_does_is_said(self):
        frames = self.frames(np.float32)
        self.assertEqual(thurible_smoke.track(frames).remarks, [])
        frames[0] = 0
        found = thurible_smoke.track(frames)
        self.assertEqual(len(found.remarks), 1)
        self.assertIn("from frame 0 to 1 smoke appears where there was none at all", found.remarks[0])
        self.assertIn("begin at frame 1 by frames[1:]", found.remarks[0])
        # It is no motion either.
        self.assertLess(max(np.abs(component[0]).max() for component in found.velocity), 1e-3)

    def test_in_3d_and_by_every_method(self):
        frames = self.frames(np.float32, (9, 10, 12), 3)
        for method in ["direct", "admm", "horn_schunck"]:
            found = thurible_smoke.track(frames, method=method, options={"levels": 2, "readvect": False})
            self.assertEqual([component.shape for component in found.velocity], [(2, 9, 10, 13), (2, 9, 11, 12), (2, 10, 10, 12)])
            self.assertIsNone(found.density)

    def test_what_is_wrong_is_refused(self):
        frames = self.frames(np.float32)
        for error, words, given in [
            (ValueError, "a flow needs two frames", {"frames": frames[:1]}),
            (ValueError, "no smoke", {"frames": 0 * frames}),
            (ValueError, "frame 2 has no smoke anywhere, and the frame before has some; give frames\\[:2\\]", {"frames": np.where(np.arange(4)[:, None, None] == 2, 0, frames)}),
            (ValueError, "value 5 is not finite", {"frames": np.where(np.arange(frames.size).reshape(frames.shape) == 5, np.nan, frames)}),
            (ValueError, "has 2 axes", {"frames": frames[0]}),
            (ValueError, "frames has dtype uint8; .*astype", {"frames": np.uint8(255 * frames)}),
            (ValueError, "frames has dtype float16; .*astype", {"frames": frames.astype(np.float16)}),
            (ValueError, "must be .direct. or", {"method": "magic"}),
            (TypeError, "there is no option of this method gravity", {"options": {"gravity": 1}}),
            (ValueError, "method.* is an argument of its own", {"options": {"method": "horn_schunck"}}),
            (ValueError, "has 4 values along its last axis, which looks like colour", {"frames": np.repeat(frames[..., None], 4, -1)}),
            (ValueError, "threads is -1, but must be", {"threads": -1}),
            (ValueError, "memory_limit is 11805.*, but must be", {"memory_limit": 2**70}),
            (TypeError, "length is 'x', but must be a number", {"length": "x"}),
            (TypeError, "initial_velocity is 's', but must be a tuple of arrays", {"initial_velocity": "s"}),
            (MemoryError, "memory_limit", {"memory_limit": 1000}),
        ]:
            with self.assertRaisesRegex(error, words):
                thurible_smoke.track(**{"frames": frames, **given})

    def test_what_is_made_is_no_motion(self):
        made = blob((20, 24), [0.5, 0.5], 0.2, np.float64)
        frames = np.stack([blob((20, 24), [0.4, 0.6], 0.5, np.float64) + k * made for k in range(3)])
        fastest = [max(pair["fastest"] for pair in thurible_smoke.track(frames, emission=emission).history)
                   for emission in (None, np.stack([made, made]))]
        self.assertGreater(fastest[0], 1e-3)
        self.assertLess(fastest[1], 1e-6)
        with self.assertRaisesRegex(ValueError, "emission has shape"):
            thurible_smoke.track(frames, emission=made)
        with self.assertRaisesRegex(ValueError, "emission cannot be used: value 0 is negative"):
            thurible_smoke.track(frames, emission=np.stack([made, made]) - 1)


class Tomography(unittest.TestCase):
    """The density behind pictures."""

    side, width = 32, 48

    def camera(self, angle):
        c, s = np.cos(angle), np.sin(angle)
        return {"kind": "orthographic", "across": [c, s], "forward": [-s, c], "pitch": 1.0, "at": [0.5 * (self.width - self.side * (c + s)), 0.5]}

    def chords(self, camera, dtype=np.float64):
        """What it sees of a disc of radius 8 at (14, 17)."""
        parts = (np.arange(8 * self.width) + 0.5) / 8
        far = camera["across"][0] * 14 + camera["across"][1] * 17 + camera["at"][0] - parts
        return (2 * np.sqrt(np.maximum(64 - far**2, 0))).reshape(-1, 8).mean(1).astype(dtype)

    def disc(self):
        at = np.arange(self.side) + 0.5
        return (np.hypot(at[None, :] - 14, at[:, None] - 17) < 8).astype(float)

    def test_a_disc_comes_back(self):
        cameras = [self.camera(np.pi * k / 10) for k in range(10)]
        novel = {**self.camera(0.5), "pixels": [self.width]}
        for method, prior, dtype in [("walk", "sad", np.float32), ("walk", "tv", np.float64), ("sart", "none", np.float64)]:
            pictures = [self.chords(camera, dtype) for camera in cameras]
            found = thurible_smoke.tomography(pictures, cameras, (self.side, self.side), method=method, prior=prior, novel=[novel])
            self.assertEqual((found.density.dtype, found.density.shape), (dtype, (self.side, self.side)))
            self.assertLess(np.sqrt(np.mean((found.density - self.disc()) ** 2)), 0.1)
            np.testing.assert_allclose(found.reprojected[3], pictures[3], atol=1.0)
            np.testing.assert_allclose(found.novel[0], self.chords(novel), atol=1.5)
            self.assertLess(found.history[0]["residual_relative"], 0.06)

    def test_frames_and_views_without_a_volume(self):
        cameras = [self.camera(np.pi * k / 8) for k in range(8)]
        novel = {**self.camera(0.3), "pixels": [self.width]}
        pictures = [np.stack([self.chords(camera), 0.5 * self.chords(camera), 0 * self.chords(camera)]) for camera in cameras]
        found = thurible_smoke.tomography(pictures, cameras, (self.side, self.side), prior="image_tv", novel=[novel], options={"budget": 3e5})
        self.assertIsNone(found.density)
        self.assertEqual(found.novel[0].shape, (3, self.width))
        for frame, part in enumerate([1, 0.5, 0]):
            far = np.linalg.norm(found.novel[0][frame] - part * self.chords(novel))
            self.assertLessEqual(far, 0.1 * part * np.linalg.norm(self.chords(novel)))
        self.assertEqual([entry["frame"] for entry in found.history], [0, 1])
        again = thurible_smoke.tomography(pictures, cameras, (2 * self.side, self.side), prior="image_tv", novel=[novel], options={"budget": 1e4})
        self.assertEqual(again.planned_bytes, found.planned_bytes)

    def test_in_3d(self):
        cameras = [{"kind": "orthographic", "across": across, "down": [0, 0, -1], "forward": forward, "at": [0, 8], "pitch": 1}
                   for across, forward in [([1, 0, 0], [0, 1, 0]), ([0, 1, 0], [1, 0, 0])]]
        picture = np.zeros((8, 8), np.float32)
        picture[2:6, 1:6] = 5
        found = thurible_smoke.tomography([picture, picture], cameras, (8, 8, 8), options={"budget": 2e5})
        self.assertEqual(found.density.shape, (8, 8, 8))
        self.assertAlmostEqual(found.density.sum() / (5 * picture[2:6, 1:6].sum() / 5), 1.0, delta=0.05)

    def test_what_is_wrong_is_refused(self):
        cameras = [self.camera(0.0), self.camera(1.0)]
        pictures = [self.chords(camera) for camera in cameras]
        cells = (self.side, self.side)
        for error, words, given in [
            (ValueError, "pictures has 1 entries, and there are 2 cameras", {"pictures": pictures[:1]}),
            (ValueError, "cells is", {"cells": [4]}),
            (ValueError, r"pictures\[0\] has dtype uint8; .*astype", {"pictures": [np.uint8(picture) for picture in pictures]}),
            (ValueError, r"pictures\[1\] has dtype float32 where pictures\[0\] has float64", {"pictures": [pictures[0], pictures[1].astype(np.float32)]}),
            (ValueError, "has a pixel, .7., that is not finite", {"pictures": [pictures[0], np.where(np.arange(self.width) == 7, np.nan, pictures[1])]}),
            (ValueError, r"pictures\[1\] holds -\d.*numpy.maximum", {"pictures": [pictures[0], pictures[1] - 1]}),
            (ValueError, r"pictures\[0\] is dark in frame 0", {"pictures": [0 * pictures[0], pictures[1]]}),
            (ValueError, "nothing but zeros", {"pictures": [0 * picture for picture in pictures]}),
            (ValueError, "hull_threshold is 1000,", {"options": {"hull_threshold": 1000.0}}),
            (ValueError, r"cells is -1|cells is \(-1", {"cells": (-1, 4)}),
            (ValueError, "memory_limit is -1", {"memory_limit": -1}),
            (ValueError, r'cameras\[1\]."across". is 2.0.* long, and must be 1.0', {"cameras": [cameras[0], {**cameras[1], "across": [2.0, 0.0]}]}),
            (ValueError, "give 2 finite numbers", {"cameras": [cameras[0], {**cameras[1], "across": [1.0, 0.0, 7.0]}]}),
            (ValueError, "forward.* is 0.0", {"cameras": [cameras[0], {**cameras[1], "forward": [0.0, 0.0]}]}),
            (ValueError, "pitch.* must be positive", {"cameras": [cameras[0], {**cameras[1], "pitch": -1}]}),
            (ValueError, "sees nothing of the box", {"cameras": [cameras[0], {**cameras[1], "at": [1000.0]}]}),
            (ValueError, "is missing", {"cameras": [cameras[0], {"kind": "orthographic"}]}),
            (TypeError, "named colour", {"cameras": [cameras[0], {**cameras[1], "colour": 1}]}),
            (ValueError, "prior is one of pictures", {"prior": "image_sad"}),
            (ValueError, "sigma must be above 0", {"options": {"sigma": 0}}),
            (TypeError, "there is no option gravity", {"options": {"gravity": 1}}),
            (MemoryError, "memory_limit", {"memory_limit": 100}),
        ]:
            with self.assertRaisesRegex(error, words):
                thurible_smoke.tomography(**{"pictures": pictures, "cameras": cameras, "cells": cells, **given})

    def test_what_is_a_little_below_zero_becomes_zero(self):
        cameras = [self.camera(np.pi * k / 4) for k in range(4)]
        pictures = [self.chords(camera) for camera in cameras]
        noisy = [np.where(picture == 0, -1e-3, picture) for picture in pictures]
        with self.assertWarnsRegex(UserWarning, r"pictures\[\d\] holds .* below 0.* they become 0"):
            found = thurible_smoke.tomography(noisy, cameras, (self.side, self.side), options={"budget": 1e4})
        np.testing.assert_array_equal(found.density, thurible_smoke.tomography(pictures, cameras, (self.side, self.side), options={"budget": 1e4}).density)


class States(unittest.TestCase):
    """What is kept of a solve goes on with the same bits, and what is not what was kept is refused."""

    def test_a_solve_goes_on(self):
        for dtype, method, options in [(np.float32, "direct", {"nested": False, "tolerance": 1e-12}), (np.float64, "lbfgs", {"tolerance": 1e-12})]:
            with self.subTest(method=method), tempfile.TemporaryDirectory() as folder:
                choices = {"method": method, "options": options, "iterations": 12}
                state = pathlib.Path(folder) / "state"
                _, _, whole = move((24, 20), dtype, 6, **choices)
                _, _, part = move((24, 20), dtype, 6, checkpoint=state, checkpoint_every=0, progress=lambda seen: seen.iteration < 5, **choices)
                self.assertEqual((part.status, os.listdir(folder)), ("cancelled", ["state"]))
                _, _, rest = move((24, 20), dtype, 6, resume=str(state), threads=1, **choices)
                np.testing.assert_array_equal(rest.density, whole.density)
                for one, other in zip(rest.force, whole.force):
                    np.testing.assert_array_equal(one, other)
                self.assertEqual([seen.objective for seen in rest.history], [seen.objective for seen in whole.history][4:])

    def test_what_is_not_what_was_kept_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            state = pathlib.Path(folder) / "state"
            move((12, 10), np.float32, 4, checkpoint=state, checkpoint_every=0, iterations=4)
            whole = state.read_bytes()
            with self.assertRaisesRegex(ValueError, "other arrays or choices"):
                move((12, 10), np.float32, 4, resume=state, force_weight=3.0)
            with self.assertRaisesRegex(ValueError, "other arrays or choices"):
                thurible_smoke.solve(np.ones((12, 10), np.float32), {4: np.eye(12, 10, dtype=np.float32)}, resume=state)
            for damaged in [b"", whole[:5], whole[:-1], whole[:100], whole + b"0", whole[:1500] + bytes([whole[1500] ^ 1]) + whole[1501:]]:
                state.write_bytes(damaged)
                with self.assertRaisesRegex(ValueError, "damaged"):
                    move((12, 10), np.float32, 4, resume=state, iterations=4)
            with self.assertRaises(FileNotFoundError):
                move((12, 10), np.float32, 4, resume=state.with_name("none"))
            for place in (folder, ".", ""):
                with self.assertRaisesRegex(ValueError, "checkpoint is the folder"):
                    move((12, 10), np.float32, 4, checkpoint=place)
            # A place that cannot be written to is refused before the solve; one that goes meanwhile is told of, also where the solve is interrupted.
            place = pathlib.Path(folder) / "place"
            with self.assertRaisesRegex(OSError, "checkpoint: cannot write .*a folder that is there"):
                move((12, 10), np.float32, 4, checkpoint=place / "state", checkpoint_every=0, iterations=4)
            for last in (4, 2):
                place.mkdir()

                def goes(seen):
                    shutil.rmtree(place, ignore_errors=True)
                    if seen.iteration >= last:
                        raise InterruptedError

                with self.assertWarnsRegex(RuntimeWarning, "could not be kept"), self.assertRaises(InterruptedError):
                    move((12, 10), np.float32, 4, checkpoint=place / "state", checkpoint_every=0, iterations=20, options={"nested": False, "tolerance": 1e-12}, progress=goes)


class Stubs(unittest.TestCase):
    def test_they_say_what_is_there(self):
        stubs = pathlib.Path(thurible_smoke.__file__).with_name("__init__.pyi")
        self.assertTrue(stubs.with_name("py.typed").exists())
        for node in ast.parse(stubs.read_text()).body:
            if isinstance(node, ast.FunctionDef):
                arguments = [argument.arg for argument in node.args.args + node.args.kwonlyargs]
                self.assertEqual(arguments, list(inspect.signature(getattr(thurible_smoke, node.name)).parameters))
                defaults = [ast.literal_eval(default) for default in node.args.kw_defaults]
                signature = inspect.signature(getattr(thurible_smoke, node.name)).parameters.values()
                self.assertEqual(defaults, [parameter.default for parameter in signature if parameter.kind is parameter.KEYWORD_ONLY])
            elif isinstance(node, ast.ClassDef) and node.name != "Options":
                stated = {member.name for member in node.body if isinstance(member, ast.FunctionDef) and not member.name.startswith("_")}
                self.assertEqual(stated, {name for name in vars(getattr(thurible_smoke, node.name)) if not name.startswith("_")})


if __name__ == "__main__":
    unittest.main()
