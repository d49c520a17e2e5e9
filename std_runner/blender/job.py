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

from .scene_file import Refused


def program(path):
    """The program thurible: the one that is named, or the one on the PATH."""
    found = shutil.which(path or "thurible")
    if found is None:
        where = path or "thurible, which is not on the PATH"
        raise Refused(f"Cannot run {where}; name the program in the preferences of the extension")
    return found


def memory(path, scene_file):
    """What a solve takes, in bytes, as `thurible plan --json` says."""
    ended = subprocess.run(
        [program(path), "plan", str(scene_file), "--json"], capture_output=True, text=True, encoding="utf-8", check=False
    )
    if ended.returncode != 0:
        raise Refused(ended.stderr.strip() or f"thurible plan ended with {ended.returncode}")
    for line in ended.stdout.splitlines():
        event = json.loads(line)
        if event.get("event") == "plan":
            return event["block_bytes"]
    raise Refused("thurible plan said nothing; is it of another version?")


class Job:
    """A solve, and the export that follows."""

    def __init__(self, path, scene_file, fps, iterations):
        self.program = program(path)
        self.result = pathlib.Path(scene_file).parent / "result"
        self.export = pathlib.Path(scene_file).parent / "volumes"
        self.fps, self.iterations = fps, max(1, iterations)
        self.progress, self.said, self.failure, self.cancelled = 0.0, "starting", None, False
        self.stage, self.done, self.cells, self.count = "solve", False, None, 0
        # The folder is the extension's own: an earlier result in it is one of an earlier press of the button.
        self._begin(["solve", str(scene_file), "--json", "--force", "-o", str(self.result)])

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
        while not self.lines.empty():
            self._hear(json.loads(self.lines.get()))
        if self.done or self.process.poll() is None:
            return self.done
        for reader in self.readers:
            reader.join()
        while not self.lines.empty():
            self._hear(json.loads(self.lines.get()))
        self._ended(self.process.returncode)
        return self.done

    def _hear(self, event):
        kind = event.get("event")
        if kind == "plan":
            self.cells = event.get("cells")
        elif kind == "iteration":
            # Coarser grids come first and cost little.
            if event.get("level") == self.cells:
                self.count += 1
            self.progress = max(self.progress, min(0.95, 0.95 * self.count / self.iterations))
            self.said = f"iteration {event.get('iteration')}, data {event.get('data', 0):.3g}"
        elif kind == "step":
            self.progress, self.said = max(self.progress, 0.95), f"writing step {event.get('step')}"
        elif kind == "warning":
            self.said = event.get("message", "")

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
            self.progress, self.said, self.done = 1.0, "done", True
