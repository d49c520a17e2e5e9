"""The Python SOP of docs/houdini.md, with a module of a few lines in the place of Houdini's. Usage: houdini.py THURIBLE OUT."""

import json
import os
import pathlib
import shutil
import sys
import types

THURIBLE, OUT = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs" / "houdini.md"
SIDES = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]


class Matrix:
    def __init__(self, by):
        self.by = by

    def inverted(self):
        return Matrix([-one for one in self.by])


class BoundingBox:
    def __init__(self, other):
        self.low, self.high = list(other.low), list(other.high)

    def enlargeToContain(self, other):
        self.low, self.high = ([f(*pair) for pair in zip(*both)] for f, both in ((min, (self.low, other.low)), (max, (self.high, other.high))))

    def sizevec(self):
        return [high - low for low, high in zip(self.low, self.high)]

    def center(self):
        return [(high + low) / 2 for low, high in zip(self.low, self.high)]


class Cube:
    """A geometry: a cube, or what was read from a file."""

    def __init__(self, low, side):
        self.low, self.high = list(low), [one + side for one in low]
        self.read = None

    def freeze(self):
        return Cube(self.low, self.high[0] - self.low[0])

    def boundingBox(self):
        return BoundingBox(self)

    def transform(self, matrix):
        self.low, self.high = ([one + by for one, by in zip(point, matrix.by)] for point in (self.low, self.high))

    def saveToFile(self, path):
        ends = (self.low, self.high)
        points = [[ends[number >> axis & 1][axis] for axis in range(3)] for number in range(8)]
        lines = ["v " + " ".join(map(str, point)) for point in points] + ["f " + " ".join(str(corner + 1) for corner in side) for side in SIDES]
        pathlib.Path(path).write_text("\n".join(lines))

    def clear(self):
        self.low, self.high = [0.0] * 3, [0.0] * 3

    def loadFromFile(self, path):
        self.read = path


class Node:
    """A node whose inputs stand where thurible's box is not."""

    own = Cube([0.0] * 3, 0.0)

    def path(self):
        return "/obj/smoke/python1"

    given = [Cube([-3.0, 5.0, 7.0], 1.0), Cube([-2.5, 5.5, 7.5], 1.0)]

    def geometry(self):
        return self.own

    def inputs(self):
        return [types.SimpleNamespace(geometry=lambda one=one: one) for one in self.given]


class NodeError(Exception):
    pass


def main():
    home = OUT / "thurible" / "obj_smoke_python1"
    shutil.rmtree(home, ignore_errors=True)
    hou = types.ModuleType("hou")
    hou.pwd, hou.frame, hou.NodeError = Node, lambda: 1e9, NodeError
    hou.text = types.SimpleNamespace(expandString=lambda _: str(OUT / "thurible"))
    hou.fps = lambda: 30.0
    hou.hmath = types.SimpleNamespace(buildTranslate=lambda *by: Matrix(by))
    sys.modules["hou"] = hou
    os.environ["PATH"] = f"{THURIBLE.parent}{os.pathsep}{os.environ['PATH']}"
    code = PAGE.read_text().split("```python\n")[1].split("```")[0]
    # Fewer cells and steps than an artist asks for, and one iteration, which ends at its limit.
    few = code.replace("48, 48, 48", "16, 16, 16").replace("steps = 48", "steps = 6").replace("step = 48", "step = 6")
    few = few.replace('"--force"', '"--force", "--set", "method.iterations=1", "--set", "output.frames=false"')
    assert few.count("16, 16, 16") == 1 and few.count("method.iterations=1") == 1
    for _ in range(2):
        exec(few, {})
    (folder,) = [path for path in home.iterdir() if path.is_dir()]
    report = json.loads((folder / "result" / "report.json").read_text())
    assert report["length"] == 1.5 * 1.5 and report["status"] == "max_iterations", report["status"]
    # A force means the same in metres and seconds as in a box and steps of length 1.
    assert abs(report["force_weight"] * report["length"] ** 2 * 30**4 / 1000 - 1) < 1e-6, report["force_weight"]
    # What was moved to the box's place is back at its own.
    last = json.loads((folder / "volumes" / "export.json").read_text())["frames"][1]
    assert Node.own.read.endswith(f"smoke.{last:04}.vdb") and pathlib.Path(Node.own.read).is_file()
    moved = [round(one, 9) for one in Node.own.low]
    assert moved == [-3.375, 4.625, 8.875], moved
    # Other meshes are solved anew, in a folder of their own.
    Node.given = [Node.given[0], Cube([-2.5, 5.5, 7.5], 0.8)]
    exec(few, {})
    assert len([path for path in home.iterdir() if path.is_dir()]) == 2
    print("houdini: ok")


main()
