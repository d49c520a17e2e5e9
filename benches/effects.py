"""What each effect costs: python3 benches/effects.py target/release/thurible [METHOD] [TURNS] (needs nothing but Python).

Solves the letter of examples/letter_f.toml, 20 iterations on the finest grid without a nested start, once plain and once with each effect, in
turns, and prints a Markdown table of the least seconds and of bytes, both beside those of the plain scene.
"""
import json
import subprocess
import sys
import tempfile
from pathlib import Path

SCENE = """
[grid]
cells = [128, 128]
{grid}
[time]
steps = {steps}
[source]
circle = {{ center = [0.5, 0.5], radius = 0.184 }}
[[keyframe]]
step = 40
text = "F"
height = 0.5
{keyframe}
[flow]
{flow}
[control]
match_mass = false
{control}
{more}
[method]
iterations = 20
{windows}
[method.direct]
nested = false
tolerance = 1e-12
[method.lbfgs]
tolerance = 1e-12
[output]
frames = false
"""

EFFECTS = [
    ("plain", {}),
    ("an emitter, by a rate", {"more": '[[emitter]]\nto = 20\nrate = 0.02\ncircle = { center = [0.5, 0.2], radius = 0.1 }'}),
    ("an emitter, up to a target", {"more": '[[emitter]]\nto = 20\ntarget = 0.5\ncircle = { center = [0.5, 0.2], radius = 0.1 }'}),
    ("an emitter that pushes its smoke", {"more": '[[emitter]]\nto = 20\nrate = 0.02\nvelocity = [0.0, 0.01]\ncircle = { center = [0.5, 0.2], radius = 0.1 }'}),
    ("buoyancy", {"flow": "buoyancy = 1e-4"}),
    ("a weight and a region", {"keyframe": "region = { box = { min = [0, 0], max = [1, 1] } }"}),
    ("a schedule", {"control": "schedule = [[0, 2.0], [39, 1.0]]"}),
    ("no smoothness", {"control": "smoothness = 0"}),
    ("viscosity", {"flow": "viscosity = 1e-5"}),
    ("viscosity, and walls to which the flow sticks", {"flow": "viscosity = 1e-5\nslip = false"}),
    ("an obstacle", {"more": "[[obstacle]]\ncircle = { center = [0.85, 0.85], radius = 0.08 }"}),
    ("the same, and the flow sticks to it", {"flow": "viscosity = 1e-5\nslip = false", "more": "[[obstacle]]\ncircle = { center = [0.85, 0.85], radius = 0.08 }"}),
    ("a mask", {"control": "mask = { box = { min = [-0.2, -0.2], max = [1.2, 0.9] } }"}),
    ("open sides", {"grid": 'boundary = ["open", ["wall", "open"]]'}),
    ("20 steps more, searched", {"steps": 60, "keyframe": "hold = 0"}),
    ("20 steps more, released", {"steps": 60, "more": "[[release]]\nfrom = 40"}),
    ("20 steps more, held", {"steps": 60, "keyframe": "hold = 20"}),
    ("in windows of 20 steps, 10 of them kept", {"windows": "window = 20\nstride = 10"}),
    (
        "three templates, by the method `templates`",
        {"method": "templates", "control": "smoothness = 0", "more": "".join(f'[[template]]\nkind = "{kind}"\ncenter = [0.5, {y}]\nradius = 0.3\n' for kind, y in (("wind", 0.4), ("vortex", 0.5), ("attract", 0.6)))},
    ),
]


def solve(program, method, effect):
    parts = {"steps": 40, "grid": "", "keyframe": "", "flow": "", "control": "", "more": "", "windows": "", "method": method, **effect}
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder, "scene.toml")
        scene.write_text(SCENE.format(**parts))
        command = [program, "solve", str(scene), "--method", parts["method"], "--quiet", "-o", str(Path(folder, "out"))]
        ended = subprocess.run(command, capture_output=True, text=True)
        if ended.returncode not in (0, 5):
            sys.exit(ended.stderr)
        report = json.loads(Path(folder, "out", "report.json").read_text())
    return report["seconds"]["total"] - report["seconds"]["setup"], report["memory"]["planned_bytes"], len(report["history"])


def main():
    if not sys.argv[1:]:
        sys.exit(__doc__)
    program, method, turns = (sys.argv[1:] + ["direct", "3"][len(sys.argv) - 2 :])[:3]
    found = {name: [] for name, _ in EFFECTS}
    for _ in range(int(turns)):
        for name, effect in EFFECTS:
            found[name].append(solve(program, method, effect))
    seconds = {name: min(seconds for seconds, _, _ in runs) for name, runs in found.items()}
    per_iteration = {name: seconds[name] / runs[0][2] for name, runs in found.items()}
    size = {name: runs[0][1] for name, runs in found.items()}
    print("| scene | seconds of an iteration | times plain | MiB | bytes a cell and step more |\n|---|---|---|---|---|")
    for name, runs in found.items():
        more = (size[name] - size["plain"]) / (128 * 128 * 40)
        times = per_iteration[name] / per_iteration["plain"]
        print(f"| {name} | {per_iteration[name]:.4f} | {times:.2f} | {size[name] / 2**20:.1f} | {more:.1f} |")


if __name__ == "__main__":
    main()
