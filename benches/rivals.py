#!/usr/bin/env python3
"""What other programs take for a circle that becomes two, beside thurible, in one session: a part of docs/performance.md.

    python3 -m venv venv && venv/bin/pip install phiflow 'jax[cpu]' scipy
    python3 benches/rivals.py venv/bin/python ../shared/tools/rivals.py target/release/thurible-bench docs

Prints the lines of JSON that it got and puts a table between the marks of the page.
"""
import json
import pathlib
import re
import subprocess
import sys

SIZES = [(64, 20), (128, 40)]
MARKS = "<!-- begin rivals -->", "<!-- end rivals -->"


def lines(command):
    """What a program says in lines of JSON."""
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    print(said, end="", flush=True)
    return [json.loads(line) for line in said.splitlines() if line.startswith("{")]


def time(seconds):
    return "-" if seconds is None else f"{1000 * seconds:.1f} ms" if seconds < 0.1 else f"{seconds:.2f} s"


def main(python, rivals, program, folder):
    ours = {}
    for line in lines([program, "circles", "--json"]):
        if row := line.get("row"):
            ours[row["cells"][0], row["precision"]] = row
    table = [
        "| cells, steps | precision | PhiFlow: gradient | JAX: gradient | thurible: iteration | JAX: to 1 % | evaluations | thurible: to 1 % | iterations |",
        "|---|---|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for cells, steps in SIZES:
        for bits in (32, 64):
            size = ["--n", str(cells), "--N", str(steps), "--precision", str(bits)]
            [phiflow] = lines([python, rivals, "time", *size, "--reps", "3"])
            jax = [*size, "--engine", "jax", "--loop", "remat"]
            [timed] = lines([python, rivals, "time", *jax])
            [solved] = lines([python, rivals, "opt", *jax, "--rpaper", "100"])
            own, reached = ours[cells, f"f{bits}"], solved["reach"].get("0.01")
            table.append(
                f"| {cells} x {cells}, {steps} | f{bits} | {time(phiflow['grad_s']['median'])} | {time(timed['grad_s']['median'])} "
                f"| {time(own['iteration_seconds'])} "
                f"| {time(reached and reached['wall_s'])} | {reached['evals'] if reached else '-'} "
                f"| {time(own['solve_seconds'])} | {own['solve_iterations']} |"
            )
    page = pathlib.Path(folder, "performance.md")
    begin, end = map(re.escape, MARKS)
    text = "\n\n".join([MARKS[0], "\n".join(table), MARKS[1]])
    page.write_text(re.sub(f"{begin}.*?{end}", lambda _: text, page.read_text(), count=1, flags=re.DOTALL))


if __name__ == "__main__":
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    main(*sys.argv[1:])
