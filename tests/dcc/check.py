"""Exports results and reads them back with the programs that people use. Usage: check.py THURIBLE OUT

Needs numpy, vtk, usd-core, xarray and zarr. Writes the cases that volumes.py and blender.py look at too into OUT/cases.json.
"""

import json
import pathlib
import subprocess
import sys
import xml.etree.ElementTree

import numpy as np
import xarray
from pxr import Usd, UsdGeom, UsdVol
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLImageDataReader

THURIBLE, OUT = sys.argv[1], pathlib.Path(sys.argv[2])
STEPS = 6


def thurible(*arguments):
    subprocess.run([THURIBLE, *map(str, arguments), "--quiet"], check=True)


def simulated(name, scene, *more, precision="f32"):
    folder = OUT / name
    thurible("simulate", f"examples/{scene}.toml", "--set", "output.frames=false", "--set", f"time.steps={STEPS}",
             "--set", "flow.buoyancy=0.02", "--precision", precision, "-o", folder, *more)
    return folder


def exported(result, name, *more):
    folder = OUT / name
    thurible("export", result, "-o", folder, *more)
    return folder


def results():
    """Simulated, tracked, and carried on, in two and three dimensions, between walls and on rings, in both precisions."""
    deep = simulated("deep", "small_3d", "--set", "time.dt=0.0416667", "--set", "flow.buoyancy=12")
    flat = simulated("flat", "small_odd")
    ring = simulated("ring", "small_3d", "--set", 'grid.boundary=["periodic","wall","periodic"]', precision="f64")
    on, fine, track = OUT / "on", OUT / "fine", OUT / "track"
    thurible("readvect", deep, "-o", on)
    thurible("upsample", flat, "-o", fine)
    thurible("track", flat, "--set", "capture.first=1", "-o", track)
    return {"deep": deep, "flat": flat, "ring": ring, "on": on, "fine": fine, "track": track}


def middle(arrays, report):
    """The velocity in the middle of cells, (steps, 3, z, y, x), from the faces."""
    cells = report["cells"]
    parts = []
    for axis, name in enumerate("xyz"[: len(cells)]):
        faces = arrays[f"velocity_{name}"].astype(np.float64)
        own = faces.ndim - 1 - axis
        if faces.shape[own] == cells[axis]:
            beyond = np.roll(faces, -1, own)
        else:
            beyond, faces = np.delete(faces, 0, own), np.delete(faces, -1, own)
        parts.append((faces + beyond) / 2)
    while len(parts) < 3:
        parts.append(np.zeros_like(parts[0]))
    return np.stack(parts, 1)


def check_stage(folder, steps, up, fps):
    stage = Usd.Stage.Open(str(folder / "smoke.usda"))
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (1, steps + 1)
    assert stage.GetFramesPerSecond() == fps == stage.GetTimeCodesPerSecond(), stage.GetFramesPerSecond()
    assert UsdGeom.GetStageUpAxis(stage) == up and UsdGeom.GetStageMetersPerUnit(stage) == 1
    volume = UsdVol.Volume(stage.GetDefaultPrim())
    assert sorted(volume.GetFieldPaths()) == ["density", "velocity"]
    for field, path in volume.GetFieldPaths().items():
        asset = UsdVol.OpenVDBAsset(stage.GetPrimAtPath(path))
        assert asset.GetFieldNameAttr().Get() == field
        for frame in range(1, steps + 2):
            file = asset.GetFilePathAttr().Get(frame).resolvedPath
            assert file.endswith(f"smoke.{frame:04}.vdb") and pathlib.Path(file).is_file(), file


def check_images(folder, arrays, report):
    kind = np.float64 if report["precision"] == "f64" else np.float32
    speed = middle(arrays, report)
    listed = xml.etree.ElementTree.parse(folder / "smoke.pvd").getroot().findall("Collection/DataSet")
    steps = len(arrays["density"]) - 1
    assert len(listed) == steps + 1
    for step, entry in enumerate(listed):
        reader = vtkXMLImageDataReader()
        reader.SetFileName(str(folder / entry.get("file")))
        reader.Update()
        image = reader.GetOutput()
        cells = report["cells"]
        assert list(image.GetDimensions())[: len(cells)] == [count + 1 for count in cells]
        assert np.allclose(image.GetSpacing(), report["length"] / max(cells), rtol=1e-12, atol=0)
        time = vtk_to_numpy(image.GetFieldData().GetArray("TimeValue"))[0]
        assert time == step * report["dt"] and abs(float(entry.get("timestep")) - time) < 1e-9
        density = vtk_to_numpy(image.GetCellData().GetArray("density"))
        assert density.dtype == kind and np.array_equal(density, arrays["density"][step].ravel())
        velocity = vtk_to_numpy(image.GetCellData().GetArray("velocity"))
        expected = speed[min(step, steps - 1)].reshape(3, -1).T.astype(kind)
        assert np.array_equal(velocity, expected), abs(velocity - expected).max()


def check_group(folder, arrays, report):
    group = xarray.open_zarr(folder / "smoke.zarr", consolidated=False)
    held = {name for name, values in arrays.items() if values.ndim and values.size}
    assert held <= set(group.variables), held - set(group.variables)
    for name in held:
        assert group[name].dtype == arrays[name].dtype and np.array_equal(group[name].values, arrays[name]), name
    side = report["length"] / max(report["cells"])
    assert np.allclose(group.x, (np.arange(report["cells"][0]) + 0.5) * side)
    assert group.x.attrs["units"] == "m" and group.time.attrs["units"] == "s"
    name = "density" if "density" in arrays else "captured"
    third = group[name].sel(time=3 * report["dt"], method="nearest")
    assert np.array_equal(third.values, arrays[name][3])


def check_fields(folder, arrays, report, factor):
    lines = (folder / "fga" / f"smoke.{3:04}.fga").read_text().split("\n")
    cells = report["cells"]
    assert [int(x) for x in lines[0].rstrip(",").split(",")][: len(cells)] == cells
    found = np.array([[float(x) for x in line.rstrip(",").split(",")] for line in lines[3:-1]])
    expected = middle(arrays, report)[2].reshape(3, -1).T * factor
    assert np.allclose(found, expected, rtol=1e-6, atol=1e-12)


def check_memory():
    """A step takes what was said before, beside the program itself."""
    count, steps = 96, 3
    folder = OUT / "large"
    folder.mkdir(exist_ok=True)
    random = np.random.default_rng(0)
    arrays = {"density": random.random((steps + 1, count, count, count), np.float32)}
    for axis, name in enumerate("xyz"):
        shape = [steps, count, count, count]
        shape[3 - axis] += 1
        arrays[f"velocity_{name}"] = random.standard_normal(shape).astype(np.float32)
    np.savez(folder / "result.npz", **arrays)
    report = {"format": 1, "cells": [count] * 3, "boundary": ["wall"] * 3, "length": 1, "dt": 1, "steps": steps, "precision": "f32"}
    (folder / "report.json").write_text(json.dumps(report))
    for formats in ["usd", "vti", "zarr", "fga", "npz"]:
        script = "import resource, subprocess, sys; said = subprocess.run(sys.argv[1:], check=True, capture_output=True, text=True).stdout; " \
            "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024); print(said)"
        command = [THURIBLE, "export", folder, "--format", formats, "--json", "-o", OUT / "large_out"]
        ran = subprocess.run([sys.executable, "-c", script, *map(str, command)], check=True, capture_output=True, text=True)
        taken, plan = ran.stdout.split("\n")[:2]
        said = json.loads(plan)["bytes"]
        assert int(taken) < said + (16 << 20), (formats, int(taken), said)


def main():
    OUT.mkdir(parents=True, exist_ok=True)
    made = results()
    cases = []
    for name, result in made.items():
        report = json.loads((result / "report.json").read_text())
        arrays = dict(np.load(result / "result.npz"))
        raw = dict(arrays)
        arrays.setdefault("density", arrays.get("captured"))
        steps = len(arrays["density"]) - 1
        folder = exported(result, f"{name}_all", "--format", "usd,vti,zarr,npz,fga", "--up", "y", "--staggered", "--fps", "30")
        check_stage(folder, steps, "Y", 30)
        check_images(folder, arrays, report)
        check_group(folder, raw, report)
        again = np.load(folder / "smoke.npz")
        assert all(np.array_equal(again[key], values) for key, values in raw.items() if values.size)
        if name == "flat":
            check_fields(folder, arrays, report, report["dt"] * 30)
        cases.append({"result": str(result), "export": str(folder), "half": True, "up": "y", "staggered": True})
        for half in ["half", "float"]:
            for packed in ["blosc", "zip", "none"]:
                folder = exported(result, f"{name}_{half}_{packed}", "--format", "vdb", "--precision", half,
                                  "--compression", packed)
                cases.append({"result": str(result), "export": str(folder), "half": half == "half", "up": "z", "staggered": False})
    check_memory()
    stage = exported(made["deep"], "deep_stage")
    check_stage(stage, STEPS, "Z", 24)
    (OUT / "cases.json").write_text(json.dumps(cases))
    print(f"dcc: USD, VTK and xarray read {len(made)} results as they are")


main()
