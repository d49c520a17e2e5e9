#!/usr/bin/env python3
"""Counts the floating-point operations that each kernel executes, for `thurible-bench roofline --flops FILE`.

    cargo build --release -p thurible-bench && python3 benches/flops.py target/release/thurible-bench docs/flops.json

Needs valgrind and objdump. Callgrind says how often every instruction of the program runs, objdump which one it is: an addition,
subtraction, multiplication, division, square root, minimum or maximum counts once for each number of its vector, a fused
multiply-add twice. A kernel's share is the difference between running it n and n + 1 times, on one thread, divided by cells and
slots. Valgrind has no AVX-512 and not all of AVX2, so the baseline kernels are counted, which do the same operations in shorter vectors.
"""
import json
import os
import re
import subprocess
import sys
import tempfile

KERNELS = {"cycle": 1, "forward": 1, "backward": 1, "projection": 1, "direct": 3}
OPERATION = re.compile(r"^v?(f?n?m(?:add|sub)\d*|add|sub|mul|div|sqrt|min|max|addsub|hadd|hsub)(p|s)(s|d)$")


def weight(mnemonic, operands):
    """Operations of one execution of an instruction."""
    found = OPERATION.match(mnemonic)
    if not found:
        return 0
    operation, packed, kind = found.groups()
    bits = 128 if packed == "p" else {"s": 32, "d": 64}[kind]
    if packed == "p" and "%ymm" in operands:
        bits = 256
    fused = 2 if "m" in operation and re.search(r"m(add|sub)", operation) else 1
    return fused * bits // {"s": 32, "d": 64}[kind]


def weights(program):
    """Operations by address, of the instructions that have any."""
    listing = subprocess.run(["objdump", "-d", "--no-show-raw-insn", program], capture_output=True, text=True, check=True).stdout
    line = re.compile(r"^\s*([0-9a-f]+):\s+(\S+)\s*(.*)$", re.MULTILINE)
    return {int(at, 16): count for at, name, operands in line.findall(listing) if (count := weight(name, operands))}


def executed(program, order, table):
    """Operations of a run, and cells times slots."""
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "out")
        command = ["valgrind", "--tool=callgrind", "--dump-instr=yes", "--compress-pos=no", "--compress-strings=no", f"--callgrind-out-file={out}"]
        run = subprocess.run([*command, program, "roofline", "--threads", "1", "--only", order], capture_output=True, text=True, check=True)
        total = 0
        called = False
        with open(out) as lines:
            for line in lines:
                if line.startswith("calls="):
                    called = True  # The next line is the cost of the callee.
                elif line.startswith("0x"):
                    address, *_, count = line.split()
                    if not called:
                        total += table.get(int(address, 16), 0) * int(count)
                    called = False
        return total, int(run.stdout)


def main(program, path):
    table = weights(program)
    counts = {}
    for kernel, times in KERNELS.items():
        counts[kernel] = {}
        for dims in (2, 3):
            less, _ = executed(program, f"{kernel},{dims},{times}", table)
            more, size = executed(program, f"{kernel},{dims},{times + 1}", table)
            counts[kernel][str(dims)] = round((more - less) / size, 1)
            print(kernel, dims, counts[kernel][str(dims)], flush=True)
    with open(path, "w") as file:
        json.dump(counts, file, indent=1)
        file.write("\n")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
