"""OpenVDB's own module reads every grid equal to result.npz. Usage: volumes.py OUT, after check.py. Needs pyopenvdb and numpy."""

import json
import pathlib
import sys

import numpy as np

try:
    import pyopenvdb as vdb
except ImportError:
    import openvdb as vdb

OUT = pathlib.Path(sys.argv[1])


def turned(field, up, axes):
    """A field (z, y, x) or (y, x) as the file has it, (x, y, z), and its sign by component is told by `component`."""
    if axes == 2:
        flat = field.T
        return flat[:, :, None] if up == "y" else flat[:, None, :]
    field = field.transpose(2, 1, 0)
    return field if up == "z" else field.transpose(0, 2, 1)[:, :, ::-1]


def component(axis, up, axes):
    """The result's axis and the sign of a component of the file."""
    if axes == 2:
        return ((0, 1), (1, 1), None)[axis] if up == "y" else ((0, 1), None, (1, 1))[axis]
    return (axis, 1) if up == "z" else ((0, 1), (2, 1), (1, -1))[axis]


def middle(faces, axis, count):
    own = faces.ndim - 1 - axis
    faces = faces.astype(np.float64)
    if faces.shape[own] == count:
        return (faces + np.roll(faces, -1, own)) / 2
    return (np.delete(faces, 0, own) + np.delete(faces, -1, own)) / 2


def as_written(values, half):
    values = values.astype(np.float32)
    return values.astype(np.float16).astype(np.float32) if half else values


def same(grid, expected, where):
    found = np.zeros(expected.shape, np.float32)
    grid.copyToArray(found)
    assert np.array_equal(found, expected), (where, abs(found - expected).max())
    places = expected if expected.ndim == 3 else abs(expected).max(-1)
    active = np.argwhere(places != 0)
    assert grid.activeVoxelCount() == len(active), where
    if len(active):
        box = grid.evalActiveVoxelBoundingBox()
        assert box == (tuple(active.min(0)), tuple(active.max(0))), (where, box)


def check(case):
    result, export = pathlib.Path(case["result"]), pathlib.Path(case["export"])
    report, facts = (json.loads(path.read_text()) for path in (result / "report.json", export / "export.json"))
    arrays = np.load(result / "result.npz")
    cells, up, half = report["cells"], case["up"], case["half"]
    axes, side, factor = len(cells), report["length"] / max(cells), facts["velocity_factor"]
    density = arrays["density"] if "density" in arrays else arrays["captured"]
    files = sorted((export / "vdb").glob("*.vdb"))
    assert len(files) == len(density)
    for step, path in enumerate(files):
        grids, metadata = vdb.readAll(str(path))
        assert metadata["creator"].startswith("thurible ") and abs(metadata["fps"] - facts["fps"]) < 1e-4
        grids = {grid.name: grid for grid in grids}
        names = {"density", "velocity"} | ({"velocity_faces"} if case["staggered"] else set())
        assert set(grids) == names, set(grids)
        for grid in grids.values():
            assert np.allclose(grid.transform.voxelSize(), side) and grid["is_saved_as_half_float"] == half
            corner = grid.transform.indexToWorld((-0.5, -0.5, -0.5))
            low = -cells[1] * side if (up, axes) == ("y", 3) else 0
            assert np.allclose(corner, (0, 0, low), atol=1e-9), corner
        assert grids["density"].gridClass == "fog volume"
        same(grids["density"], as_written(turned(density[step], up, axes), half), (path, "density"))
        flow = min(step, report["steps"] - 1)
        names = [f"velocity_{name}" for name in "xyz"[:axes]]
        speed = [middle(arrays[name][flow], axis, cells[axis]) for axis, name in enumerate(names)]
        parts = []
        for axis in range(3):
            of = component(axis, up, axes)
            parts.append(turned(speed[of[0]] * of[1] * factor if of else np.zeros_like(speed[0]), up, axes))
        same(grids["velocity"], as_written(np.stack(parts, -1), half), (path, "velocity"))
        if case["staggered"]:
            grid = grids["velocity_faces"]
            assert grid.gridClass == "staggered"
            turns = []
            for axis in range(3):
                of = component(axis, up, axes)
                faces = turned(arrays[names[of[0]]][flow].astype(np.float64) * of[1] * factor if of else np.zeros_like(speed[0]), up, axes)
                if of and of[1] < 0 and arrays[names[of[0]]][flow].shape[axes - 1 - of[0]] == cells[of[0]]:
                    faces = np.roll(faces, 1, axis)
                turns.append(faces)
            size = np.max([part.shape for part in turns], 0)
            whole = np.zeros((*size, 3))
            for axis, part in enumerate(turns):
                whole[tuple(slice(0, count) for count in part.shape) + (axis,)] = part
            same(grid, as_written(whole, half), (path, "faces"))
    return len(files)


cases = json.loads((OUT / "cases.json").read_text())
print(f"dcc: OpenVDB reads {sum(map(check, cases))} files equal to result.npz")
