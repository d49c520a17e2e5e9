#!/usr/bin/env python3
"""Mutation testing with one compilation: schemata.py plant FILE.. | schemata.py run LIST PROGRAM[,PROGRAM] [ARGUMENT ..]

plant changes copies of sources in place. Every place where something may be changed asks at run time whether it is its turn: a function gives
a constant at once, a condition is the other way round, a number is one more, a sum is a difference. It prints a line for each place. Every crate
that is changed needs `pub fn mutant(number: usize) -> bool` at its root, which the scripts `readers`, `core` and `program` take from `turn.rs`.

run runs the test programs once for each line of LIST (a file of such lines) with MUTANT set, and prints the lines that no test noticed.
The arguments are the last one's.
What takes ten times as long as the untouched program counts as noticed.
"""
import os
import re
import subprocess
import sys
import time

# What a function of such a type gives instead.
CONSTANTS = [
    (r"bool", ["true", "false"]),
    (r"usize|u64|u32|u16|u8|i64|i32", ["0", "1"]),
    (r"f64|f32", ["0.0", "1.0", "-1.0"]),
    (r"Option<.*>", ["None"]),
    (r"String", ["String::new()"]),
    (r"Vec<.*>", ["Vec::new()"]),
    (r"(?:Read|Result)<\(\)(?:, \w+)?>", ["Ok(())"]),
    (r"(?:Read|Result)<bool(?:, \w+)?>", ["Ok(true)", "Ok(false)"]),
    (r"(?:Read|Result)<(?:usize|u64|u32|i64|i32)(?:, \w+)?>", ["Ok(0)", "Ok(1)"]),
    (r"(?:Read|Result)<(?:f64|f32)(?:, \w+)?>", ["Ok(0.0)", "Ok(1.0)"]),
    (r"(?:Read|Result)<Vec<.*>(?:, \w+)?>", ["Ok(Vec::new())"]),
    (r"(?:Read|Result)<String(?:, \w+)?>", ["Ok(String::new())"]),
]
FUNCTION = re.compile(r"^\s*(?:pub(?:\([^)]*\))? )?fn (\w+)")
CONSTANT_FUNCTION = re.compile(r"^\s*(?:pub(?:\([^)]*\))? )?const (?:unsafe )?fn \w+")
CONDITION = re.compile(r"^(\s*(?:\} else )?if )(?!let )(.*?)( \{)$")
SWAPS = [(" + 1", " + 2"), (" - 1", " - 2"), (" < ", " <= "), (" > ", " >= "), (" <= ", " < "), (" >= ", " > "), (" == ", " != "), (" && ", " || "), (" || ", " && ")]
LET = re.compile(r"^(\s*let (?:mut )?\w+ = )([^{}|;]*?)(;)$")


def plant(paths):
    number = 0

    def ask(what, path, line):
        nonlocal number
        number += 1
        print(f"{number}\t{path}:{line + 1}\t{what}")
        return f"crate::mutant({number})"

    for path in paths:
        lines = open(path).read().split("\n")
        end = next((i for i, line in enumerate(lines) if line.startswith("#[cfg(test)]")), len(lines))
        out, index, open_function, constant = [], 0, None, None
        while index < end:
            line = lines[index]
            found = FUNCTION.match(line)
            if constant is None and CONSTANT_FUNCTION.match(line):
                # Nothing in it can ask, up to its own closing brace.
                constant = line[: len(line) - len(line.lstrip())] + "}"
            if constant is not None:
                out.append(line)
                if line == constant or CONSTANT_FUNCTION.match(line) and line.endswith("}"):
                    constant = None
                index += 1
                continue
            if found:
                open_function = [found[1], line]
            elif open_function:
                open_function[1] += " " + line.strip()
            condition = CONDITION.match(line)
            let = LET.match(line)
            if condition and " let " not in line and "||" != condition[2].strip():
                test = condition[2]
                changed = f"({ask(f'if {test}: the other way round', path, index)} != ({test}))"
                for old, new in SWAPS:
                    if test.count(old) == 1 and "<" not in test.replace(old, ""):
                        other = test.replace(old, new)
                        if other != test and " ==" not in old:
                            changed = f"(if {ask(f'if {test}: {other}', path, index)} {{ {other} }} else {{ {changed} }})"
                line = condition[1] + changed + condition[3]
            elif let and not re.search(r"[?&\"']|as |\.\.|move|<", let[2]):
                test = let[2]
                for old, new in [(" + ", " - "), (" - ", " + "), (" * ", " + "), (" / ", " * "), *SWAPS]:
                    if test.count(old) == 1:
                        other = test.replace(old, new)
                        line = f"{let[1]}if {ask(f'{test}: {other}', path, index)} {{ {other} }} else {{ {test} }};"
                        break
            out.append(line)
            if open_function and line.endswith("{"):
                name, head = open_function
                open_function = None
                kind = re.search(r"-> (.*?)(?: where .*)? \{$", head)
                if kind is None:
                    out.append(f"        if {ask(f'{name}: does nothing', path, index)} {{ return; }}")
                else:
                    for pattern, values in CONSTANTS:
                        if re.fullmatch(pattern, kind[1]):
                            for value in values:
                                out.append(f"        if {ask(f'{name}: {value}', path, index)} {{ return {value}; }}")
                            break
            elif open_function and line.endswith(";"):
                open_function = None
            index += 1
        open(path, "w").write("\n".join(out + lines[end:]))


def run(listed, programs, arguments):
    def one(command, environment, limit):
        null = subprocess.DEVNULL
        try:
            done = subprocess.run(command, env=environment, timeout=limit, stdout=null, stderr=null)
        except subprocess.TimeoutExpired:
            return False
        return done.returncode == 0

    def passes(number, limit):
        environment = {**os.environ, "MUTANT": str(number), "RUST_BACKTRACE": "0"}
        *others, last = programs.split(",")
        return all(one([program], environment, limit) for program in others) and one([last, *arguments], environment, limit)

    begin = time.time()
    assert passes(0, 600), "the tests fail untouched"
    limit = 10 * (time.time() - begin) + 5
    all_lines = open(listed).read().splitlines()
    survivors = 0
    for done, line in enumerate(all_lines, 1):
        if passes(line.split("\t")[0], limit):
            survivors += 1
            print(line, flush=True)
        if done % 50 == 0:
            print(f"# {done} of {len(all_lines)}: {survivors} unnoticed", file=sys.stderr, flush=True)
    print(f"# {len(all_lines)} changes, {survivors} unnoticed", flush=True)


if __name__ == "__main__":
    if sys.argv[1] == "plant":
        plant(sys.argv[2:])
    else:
        run(sys.argv[2], sys.argv[3], sys.argv[4:])
