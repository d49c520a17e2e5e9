#!/usr/bin/env python3
"""What ranks exchange, counted and fitted, and what that makes of many of them: the tables of docs/mpi.md.

    python3 benches/ranks.py target/release/thurible-mpi            counts, fit and tables
    python3 benches/ranks.py target/release/thurible-mpi --beside   2 ranks beside 2 threads, 64^3 x 60

Iterations of the direct method on one grid, in f32, walls all around; steps in the proportion of cells, so that smoke crosses as many cells in a
step on every grid. Counts are the differences of two runs of different lengths. Nothing but Python is needed, and mpirun.
"""

import argparse
import json
import math
import os
import re
import statistics
import subprocess
import tempfile
from pathlib import Path

SCENE = """
[grid]
cells = [{n}, {n}, {n}]
[time]
steps = {steps}
[source]
sphere = {{ center = [0.4, 0.4, 0.5], radius = 0.22 }}
[[keyframe]]
step = {steps}
sphere = {{ center = [0.6, 0.55, 0.5], radius = 0.22 }}
[method]
name = "direct"
iterations = {iterations}
[method.direct]
nested = false
tolerance = 1e-12
[output]
frames = false
"""
SAID = re.compile(r"rank (\d+) of \d+ sent (\d+) messages, (\d+) bytes, (\d+) messages of numbers, in ([0-9.]+) s")
NUMBER = 4  # bytes
REACH = 2  # planes on either side that a rank has copies of
TOGETHER = 1024  # values of strips of rows that are put together for a message (core/exec/ranks.rs)
PRODUCTS = 13  # sums at a time, of five pairs, of which 256 go on together


def cut(n, ranks):
    """Ranks along y and z, as std_runner/blocks.rs has them where nobody says it."""
    held = lambda ranks: n + (2 * REACH * ranks if ranks > 1 else 0)
    if ranks <= 8 and n >= 8 * ranks:
        return 1, ranks
    ways = [(y, ranks // y) for y in range(1, ranks) if ranks % y == 0 and n >= REACH * max(y, ranks // y)]
    return min(ways, key=lambda way: held(way[0]) * held(way[1]), default=None)


def run(program, folder, n, steps, iterations, ranks, threads=1, blocks=None, tries=5):
    """A solve: what each rank sent, and the seconds of each iteration but the first."""
    scene, out = folder / "scene.toml", folder / "out"
    scene.write_text(SCENE.format(n=n, steps=steps, iterations=iterations))
    launch = ["mpirun", "--oversubscribe", "--allow-run-as-root", "--mca", "mpi_yield_when_idle", "1", "--bind-to", "none", "-n", str(ranks)]
    solve = [str(program), "solve", str(scene), "--threads", str(threads), "--quiet", "--force", "--checkpoint", "off", "-o", str(out)]
    solve += ["--blocks", "x".join(map(str, blocks))] if blocks else []
    ended = subprocess.run(launch + solve, env={**os.environ, "THURIBLE_MPI_TRAFFIC": "1"}, capture_output=True, text=True)
    if ended.returncode not in (0, 5):
        raise SystemExit(f"exit code {ended.returncode}: {ended.stderr}")
    sent = {int(rank): tuple(map(float, rest)) for rank, *rest in SAID.findall(ended.stderr)}
    if len(sent) < ranks and ranks > 1:
        # mpirun mixes what ranks say at the same time, now and then.
        if tries == 0:
            raise SystemExit(f"the ranks' lines are not to be read: {ended.stderr}")
        return run(program, folder, n, steps, iterations, ranks, threads, blocks, tries - 1)
    seconds = [entry["seconds"] for entry in json.loads((out / "report.json").read_text())["history"]]
    return sent, [after - before for before, after in zip(seconds, seconds[1:])]


def an_iteration(options, folder, n, steps, ranks, blocks=None):
    """What each rank sends in an iteration and how long it waits for that, undisturbed, and the least seconds of an iteration."""
    few, more = 3, 7
    seconds, sent = [], {}
    for count in (few, more) * options.rounds:
        now, some = run(options.program, folder, n, steps, count, ranks, blocks=blocks)
        seconds += some
        for rank, (*counts, waited) in now.items():
            least = min(waited, sent.get((count, rank), (math.inf,))[-1])
            sent[count, rank] = (*counts, least)
    each = [[(b - a) / (more - few) for a, b in zip(sent[few, rank], sent[more, rank])] for rank in range(ranks)]
    return each, min(seconds)


def deal(sent, n, slots):
    """What four ranks between walls send in an iteration and slot, by kind: the second has a neighbour more than the first; the last tells sums, the first maxima."""
    messages, bytes_, numbers, _ = (list(column) for column in zip(*sent))
    large = [all_ - few for all_, few in zip(messages, numbers)]
    sums = numbers[3] - numbers[2]
    beside = large[1] - large[0]
    return {
        "sums": sums / slots,
        "maxima": (numbers[2] - sums) / slots,
        "copies": beside / slots,
        "turns": (large[0] - beside) / 3 / slots,
        "planes": (bytes_[1] - bytes_[0]) / (slots * n**2 * NUMBER),
        "slabs": (bytes_[0] - (bytes_[1] - bytes_[0])) / (slots * n**3 / 4 * NUMBER) / (3 / 4),
    }


def sides(place, count):
    return (place > 0) + (place + 1 < count)


def strips(n, planes):
    """Messages of the copies of rows of so many planes: one for each that is long, or for several together."""
    return math.ceil(planes / max(1, TOGETHER // (REACH * n)))


def sends(kinds, n, slots, blocks, rank):
    """Messages and bytes that a rank between walls sends in an iteration; the numbers of sums and maxima are those of all ranks in the mean."""
    y, z = blocks
    ranks, row, plane = y * z, rank % y, rank // y
    numbers = (kinds["sums"] + kinds["maxima"]) * 2 * (ranks - 1) / ranks
    # The sums of planes go on along y before those of all along z.
    numbers += kinds["sums"] * math.ceil(PRODUCTS * n / z / 256) * (y - 1) / y
    turned = kinds["turns"] * ((z - 1) + (y - 1) / 2)
    copied = kinds["copies"] * (sides(plane, z) + (sides(row, y) * strips(n, n / z) if y > 1 else 0))
    held = n / y + (REACH * sides(row, y) if y > 1 else 0)
    planes = kinds["planes"] * n * (sides(plane, z) * held + (sides(row, y) * n / z if y > 1 else 0))
    slabs = kinds["slabs"] * n**3 / ranks * ((z - 1) / z + (y - 1) / y / 2)
    return (numbers + copied + turned) * slots, (planes + slabs) * slots * NUMBER


def seconds(kinds, rate, n, slots, blocks, threads, latency, bandwidth):
    """Those of an iteration: work, copies of planes and rows worked on too, and waiting for messages."""
    y, z = blocks
    ranks = y * z
    _, bytes_ = sends(kinds, n, slots, blocks, (1 if y > 1 else 0) + y)
    doublings = math.ceil(math.log2(ranks))
    work = rate * n**3 * slots / ranks / threads
    copies = work * ((1 + 2 * REACH * z / n) * (1 + (2 * REACH * y / n if y > 1 else 0)) - 1)
    # A sum goes from rank to rank and is told to all; a maximum is asked and told by a tree; the others go to both sides at once.
    along = (z - 1) + (y - 1) * math.ceil(PRODUCTS * n / z / 256)
    chain = kinds["sums"] * (along + doublings) + kinds["maxima"] * 2 * doublings
    copied = 2 * kinds["copies"] * (1 + (strips(n, n / z) if y > 1 else 0))
    waits = (chain + copied + kinds["turns"] * ((z - 1) + (y - 1) / 2)) * slots * latency
    return work, copies, waits, bytes_ / bandwidth


def least_squares(rows):
    """t and 1 / b of seconds = t messages + bytes / b, relative errors counted alike."""
    (a, b, c, d, e) = (0.0,) * 5
    for messages, bytes_, waited in rows:
        m, y = messages / waited, bytes_ / waited
        a, b, c, d, e = a + m * m, b + m * y, c + y * y, d + m, e + y
    determinant = a * c - b * b
    latency, per_byte = (d * c - e * b) / determinant, (a * e - b * d) / determinant
    # What is lost in the noise is 0, and the other one explains all.
    if latency < 0:
        return 0.0, e / c
    return (latency, per_byte) if per_byte >= 0 else (d / a, 0.0)


def table(options):
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        found = {}
        for n in options.cells:
            for ranks in (1, 2, 4):
                found[n, (1, ranks)] = an_iteration(options, folder, n, n // 2, ranks, (1, ranks) if ranks > 1 else None)
    print("Counted in an iteration and slot (4 ranks); a slot is a step but the last")
    print(f"{'cells':>8}{'sums':>8}{'maxima':>8}{'copies to a side':>18}{'turns':>8}{'planes to a side':>18}{'slabs turned':>14}")
    for n in options.cells:
        kinds = deal(found[n, (1, 4)][0], n, n // 2 - 1)
        print(f"{n:>6}^3" + "".join(f"{kinds[kind]:>{width}.2f}" for kind, width in (("sums", 7), ("maxima", 8), ("copies", 18), ("turns", 8), ("planes", 18), ("slabs", 14))))
    n = options.cells[-1]
    print(f"\nPredicted from those of {n}^3 on 4 ranks, and counted: messages and bytes of all ranks in an iteration")
    rows, kinds = {2: [], 4: []}, deal(found[n, (1, 4)][0], n, n // 2 - 1)
    for m in options.cells:
        for blocks in ((1, 2), (1, 4)):
            sent, _ = found[m, blocks]
            rows[len(sent)] += [(rank[0], rank[1], rank[3]) for rank in sent if rank[3] > 0]
            foretold(kinds, m, m // 2 - 1, blocks, sent)
    blocks_foretold(options)
    print("\nFitted here: seconds that a rank waits in an iteration = t messages + bytes / b; the largest error of the fit")
    for ranks, own in rows.items():
        latency, per_byte = least_squares(own)
        bandwidth = f"{1e-9 / per_byte:.2f} GB/s" if per_byte > 0 else "more bytes a second than can be told"
        off = max(abs(latency * m + per_byte * b - waited) / waited for m, b, waited in own)
        print(f"{ranks} ranks: {latency * 1e6:.0f} microseconds a message, {bandwidth}, {100 * off:.0f} %")
    for m in options.cells:
        print(f"{m}^3: an iteration takes at least {', '.join(f'{found[m, blocks][1] * 1e3:.0f} ms on {blocks[0]}x{blocks[1]}' for blocks in ((1, 1), (1, 2), (1, 4)))} ranks")
    project(options, kinds, options.work or found[n, (1, 1)][1] / (n**3 * (n // 2 - 1)))
    memory(options)


def foretold(kinds, n, slots, blocks, sent):
    messages, bytes_ = sum(rank[0] for rank in sent), sum(rank[1] for rank in sent)
    said = [sum(column) for column in zip(*(sends(kinds, n, slots, blocks, rank) for rank in range(len(sent))))]
    print(f"{n:>6}^3 on {blocks[0]}x{blocks[1]}:{said[0]:>10.0f}{messages:>10.0f}{said[1]:>14.0f}{bytes_:>14.0f}")


def blocks_foretold(options, n=64, steps=16):
    """What blocks send, by the counts of slabs: in a box of whole groups of what is transformed together, as the tables have them."""
    with tempfile.TemporaryDirectory() as place:
        slabs, blocks = (an_iteration(options, Path(place), n, steps, 4, blocks)[0] for blocks in ((1, 4), (2, 2)))
    foretold(deal(slabs, n, steps - 1), n, steps - 1, (2, 2), blocks)


def project(options, kinds, rate):
    t, b, threads = options.latency, options.bandwidth, options.threads
    print(f"\nWork: {rate * 1e9:.0f} ns a cell and slot on one core. Network: {t * 1e6:.1f} microseconds, {b / 1e9:.1f} GB/s a rank. {threads} threads a rank")
    print("\nStrong: ranks along y x z, seconds of an iteration (part of them that is a rank's own cells' work)")
    all_ranks = [64 << i for i in range(7)]
    print(f"{'cells':>12}" + "".join(f"{ranks:>21}" for ranks in all_ranks))
    for n in (256, 512, 1024):
        slots, line = n * 120 // 256 - 1, ""
        for ranks in all_ranks:
            blocks = cut(n, ranks)
            parts = seconds(kinds, rate, n, slots, blocks, threads, t, b)
            line += f"{f'{blocks[0]}x{blocks[1]}: {sum(parts):.2f} ({100 * parts[0] / sum(parts):.0f} %)':>21}"
        print(f"{n:>6}^3 x {slots + 1:<3}{line}")
    print("\nWeak: seconds of an iteration by what takes them, as many cells a rank")
    print(f"{'cells':>12}{'ranks':>8}{'blocks':>10}{'work':>10}{'of copies':>10}{'messages':>10}{'bytes':>10}")
    for n, ranks in ((256, 64), (512, 512), (1024, 4096)):
        slots, blocks = n * 120 // 256 - 1, cut(n, ranks)
        parts = seconds(kinds, rate, n, slots, blocks, threads, t, b)
        print(f"{n:>6}^3 x {slots + 1:<3}{ranks:>7}{blocks[0]:>6}x{blocks[1]:<3}" + "".join(f"{part:>10.2f}" for part in parts))


def memory(options):
    """The largest rank's, as it is planned."""
    print("\nMemory of the largest rank, GiB, on one grid / with nested starts")
    all_ranks = [64, 256, 1024, 4096]
    print(f"{'cells':>12}" + "".join(f"{ranks:>16}" for ranks in all_ranks))
    with tempfile.TemporaryDirectory() as place:
        scene = Path(place) / "scene.toml"
        for n in (256, 512, 1024):
            steps, line = n * 120 // 256, ""
            scene.write_text(SCENE.format(n=n, steps=steps, iterations=1))
            for ranks in all_ranks:
                said = []
                for nested in ("false", "true"):
                    plan = [str(options.program), "plan", str(scene), "--ranks", str(ranks), "--json", "--precision", "f32", "--set", f"method.direct.nested={nested}"]
                    lines = subprocess.run(plan, capture_output=True, text=True, check=True).stdout.splitlines()
                    each = json.loads(lines[-1])["ranks"]
                    said.append(max(rank["block_bytes"] for rank in each) / 2**30)
                line += f"{' / '.join(f'{gib:.1f}' for gib in said):>16}"
            print(f"{n:>6}^3 x {steps:<3}{line}")


def beside(options):
    """2 threads and 2 ranks in turn, so that what else the machine does befalls both."""
    n, steps = 64, 60
    times = {"2 threads": [], "2 ranks": []}
    with tempfile.TemporaryDirectory() as place:
        for _ in range(options.rounds):
            for name, ranks, threads in (("2 threads", 1, 2), ("2 ranks", 2, 1)):
                _, each = run(options.program, Path(place), n, steps, 4, ranks, threads)
                print(f"{name}: {', '.join(f'{seconds:.2f}' for seconds in each)} s", flush=True)
                times[name] += each
    medians = {name: statistics.median(each) for name, each in times.items()}
    for name, each in times.items():
        print(f"{name}: median {medians[name]:.2f} s an iteration, from {min(each):.2f} to {max(each):.2f}, of {len(each)}")
    print(f"ratio {medians['2 ranks'] / medians['2 threads']:.3f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("--beside", action="store_true")
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--cells", type=int, nargs="+", default=[24, 48], help="of at least 24: a message of fewer rows would look like one of numbers")
    parser.add_argument("--latency", type=float, default=1e-6, help="seconds of a message [default: InfiniBand's, see docs/mpi.md]")
    parser.add_argument("--bandwidth", type=float, default=12.5e9, help="bytes a second of a rank")
    parser.add_argument("--work", type=float, help="seconds of a cell and slot on one core, where others use this machine [default: as measured]")
    parser.add_argument("--threads", type=int, default=8, help="of a rank in the tables, each as fast as one core here")
    options = parser.parse_args()
    if not options.beside and len(set(options.cells)) < 2:
        parser.error("give at least two --cells: seconds of a message and of a byte cannot be told apart by one")
    options.program = options.program.resolve()
    beside(options) if options.beside else table(options)


if __name__ == "__main__":
    main()
