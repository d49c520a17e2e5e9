#!/usr/bin/env python3
"""How honest the time that is left was: a part of docs/watching.md.

    python3 benches/clock.py DIR ...

Of each result folder, at every iteration from half of the search's time on: by how much the end that was expected then is off, at most, in
parts of the whole time.
"""
import json
import pathlib
import sys


def worst(history):
    end = history[-1]["seconds"]
    late = [row for row in history[:-1] if row["seconds"] >= end / 2]
    ends = [row["seconds"] + row["seconds_left"] for row in late if "seconds_left" in row]
    return len(late), len(ends), max((abs(other - end) / end for other in ends), default=0.0)


print("| result | method | iterations | seconds | told, of the second half | off at most |")
print("| --- | --- | --- | --- | --- | --- |")
for folder in sys.argv[1:]:
    report = json.loads((pathlib.Path(folder) / "report.json").read_text())
    history = report["history"]
    if len(history) < 2:
        print(f"| {folder} | {report['method']} | {len(history)} | | | |")
        continue
    late, told, off = worst(history)
    print(f"| {folder} | {report['method']} | {len(history)} | {history[-1]['seconds']:.1f} | {told} of {late} | {100 * off:.0f} % |")
