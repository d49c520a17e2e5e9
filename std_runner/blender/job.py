# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the program beside Blender: its lines of JSON are read by a thread, looked at by a timer, and never waited for."""

import json
import pathlib
import queue
import shutil
import signal
import subprocess
import sys
import threading

from . import volume
from .scene_file import PLACE, Refused

# The result's folder, and the one of the states of a solve that was not finished.
RESULT, STATES = "result", "result.checkpoint"
# How often a state is kept, so that what is cancelled, or ends with Blender, can go on.
KEPT = ["--checkpoint", "every=60s"]


def program(path):
    """The program thurible: the one that is named, or the one on the PATH."""
    found = shutil.which(path or "thurible")
    if found is None:
        where = path or "thurible, which is not on the PATH"
        raise Refused(f"Cannot run {where}; name the program in the preferences of the extension")
    return found


def event(line):
    """What a line of JSON says; nothing where it is broken, as the last one of a program that was ended may be."""
    try:
        found = json.loads(line)
    except ValueError:
        return {}
    return found if isinstance(found, dict) else {}


def memory(path, scene_file, resources):
    """What a solve takes, in bytes, as `thurible plan --json` says."""
    ended = subprocess.run(
        [program(path), "plan", str(scene_file), "--json", *resources], capture_output=True, text=True, encoding="utf-8", check=False
    )
    if ended.returncode != 0:
        raise Refused(ended.stderr.strip() or f"thurible plan ended with {ended.returncode}")
    for line in ended.stdout.splitlines():
        said = event(line)
        if said.get("event") == "plan":
            return said["block_bytes"]
    raise Refused("thurible plan said nothing; is it of another version?")


def is_unfinished(folder):
    """Whether a solve can go on from the states in a folder."""
    return (pathlib.Path(folder) / STATES).is_dir()


class Job:
    """A solve, from its beginning or from its last state, and the export that follows."""

    def __init__(self, path, scene_file, resources, goes_on, fps, iterations):
        self.program = program(path)
        folder = pathlib.Path(scene_file).parent
        self.result, self.export = folder / RESULT, volume.another(folder)
        # Where the smoke belongs, whatever becomes of the domain meanwhile.
        self.place = (folder / PLACE).read_bytes()
        self.fps, self.iterations = fps, max(1, iterations)
        self.progress, self.said, self.failure, self.cancelled = 0.0, "starting", None, False
        self.stage, self.done, self.cells, self.count = "solve", False, None, 0
        # What the user should know in the end.
        self.notes = []
        # The folder is the extension's own: an earlier result in it is one of an earlier press of the button.
        what = ["resume", str(self.result)] if goes_on else ["solve", str(scene_file), "-o", str(self.result)]
        self._begin([*what, "--json", "--force", *KEPT, *resources])

    def _begin(self, arguments):
        self.lines, self.errors, self.asked = queue.Queue(), [], False
        self.process = subprocess.Popen(
            [self.program, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, encoding="utf-8"
        )
        self.readers = [
            threading.Thread(target=self._read, args=(self.process.stdout, self.lines.put), daemon=True),
            threading.Thread(target=self._read, args=(self.process.stderr, self.errors.append), daemon=True),
        ]
        for reader in self.readers:
            reader.start()

    @staticmethod
    def _read(stream, take):
        with stream:
            for line in stream:
                take(line)

    def cancel(self):
        """Asks the program to stop: it writes what it has. On Windows a program without a console cannot be asked, and is ended."""
        self.cancelled = True
        # Asked twice, it ends at once and writes nothing.
        if self.asked or self.process.poll() is not None:
            return
        self.asked = True
        if sys.platform == "win32":
            self.process.terminate()
        else:
            self.process.send_signal(signal.SIGINT)

    def poll(self):
        """Takes what the program said since; whether all is over."""
        self._hear_all()
        if self.done or self.process.poll() is None:
            return self.done
        for reader in self.readers:
            reader.join()
        self._hear_all()
        self._ended(self.process.returncode)
        return self.done

    def _hear_all(self):
        while not self.lines.empty():
            self._hear(event(self.lines.get()))

    def _hear(self, said):
        kind = said.get("event")
        if kind == "plan":
            self.cells = said.get("cells")
        elif kind == "iteration":
            # Coarser grids come first and cost little.
            if said.get("level") == self.cells:
                self.count += 1
            self.progress = max(self.progress, min(0.95, 0.95 * self.count / self.iterations))
            self.said = f"iteration {said.get('iteration')}, data {said.get('data', 0):.3g}"
        elif kind == "step":
            self.progress, self.said = max(self.progress, 0.95), f"writing step {said.get('step')}"
        elif kind == "warning":
            self.notes.append(said.get("message", ""))
        elif kind == "result":
            missed = [keyframe["relative_l2"] for keyframe in said.get("keyframes", ()) if keyframe.get("relative_l2") is not None]
            if missed:
                self.notes.append(f"The keyframes are missed by {100 * max(missed):.3g} % at most.")
            self.notes += [remark for remark in said.get("remarks", ()) if remark not in self.notes]

    def _ended(self, code):
        # 5: stalled, 130: interrupted; both have written a result.
        fine = code in (0, 5, 130) and (self.stage == "export" or (self.result / "result.npz").is_file())
        if not fine:
            how = "cancelled before there was any smoke" if self.cancelled else f"thurible {self.stage} ended with {code}"
            self.failure = "".join(self.errors).strip() or how
            self.done = True
        elif self.stage == "solve":
            self.stage, self.said = "export", "writing volumes"
            fps = f"{self.fps:.6g}"
            self._begin(["export", str(self.result), "--format", "vdb", "--up", "z", "--fps", fps, "--json", "-o", str(self.export)])
        else:
            (self.export / PLACE).write_bytes(self.place)
            self.progress, self.said, self.done = 1.0, "done", True
