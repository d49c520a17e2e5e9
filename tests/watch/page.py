"""The page of a solve that runs, in Chromium: frames, curves and the time that is left come, frames change, and its button stops the solve.
Usage: page.py CHROMIUM ADDRESS FOLDER, the folder for the browser's own files."""

import fcntl
import json
import os
import select
import signal
import sys
import time

PATIENCE = 120


class Browser:
    """A browser without a window, which is asked through two pipes (the DevTools protocol)."""

    def __init__(self, program, folder):
        high = [fcntl.fcntl(end, fcntl.F_DUPFD, 10) for end in (*os.pipe(), *os.pipe())]
        asked, self.ask, self.answers, answering = high
        options = ["--headless", "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe", f"--user-data-dir={folder}"]
        silent = [(os.POSIX_SPAWN_OPEN, number, os.devnull, os.O_RDWR, 0) for number in (0, 1, 2)]
        # It reads descriptor 3 and writes descriptor 4.
        ends = [(os.POSIX_SPAWN_DUP2, asked, 3), (os.POSIX_SPAWN_DUP2, answering, 4)]
        self.process = os.posix_spawn(program, [program, *options], os.environ, file_actions=silent + ends)
        os.close(asked)
        os.close(answering)
        self.rest, self.number, self.session = b"", 0, {}
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = {"sessionId": self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]}

    def call(self, method, **parameters):
        self.number += 1
        os.write(self.ask, json.dumps({"id": self.number, "method": method, "params": parameters, **self.session}).encode() + b"\0")
        end = time.monotonic() + PATIENCE
        while True:
            message, zero, rest = self.rest.partition(b"\0")
            if zero:
                self.rest = rest
                answer = json.loads(message)
                if answer.get("id") == self.number:
                    return answer["result"]
            elif not select.select([self.answers], [], [], max(0.0, end - time.monotonic()))[0]:
                sys.exit(f"page: the browser does not answer {method}")
            elif part := os.read(self.answers, 1 << 16):
                self.rest += part
            else:
                sys.exit("page: the browser is gone")

    def value(self, script):
        return self.call("Runtime.evaluate", expression=script, returnByValue=True)["result"].get("value")

    def until(self, what, script):
        end = time.monotonic() + PATIENCE
        while not (found := self.value(script)):
            if time.monotonic() > end:
                sys.exit(f"page: {what} does not come; it says: {self.value('document.body.innerText')[:300]!r}")
            time.sleep(0.1)
        print(f"{what}: {found}")
        return found


def main():
    program, address, folder = sys.argv[1:]
    browser = Browser(program, folder)
    try:
        browser.call("Page.navigate", url=address)
        first = "document.querySelector('#frames img')"
        browser.until("a frame", f"{first}?.complete && {first}.naturalWidth > 0 && {first}.src")
        browser.until("a curve", "document.querySelectorAll('#charts polyline').length")
        browser.until("the time that is left", "/Iteration \\d+ of at most \\d+, about .* left/.exec(document.getElementById('lead')?.textContent)?.[0]")
        before = browser.value(f"{first}.src")
        browser.until("another frame", f"{first}.src != {json.dumps(before)} && {first}.complete && {first}.naturalWidth > 0 && {first}.src")
        browser.value("document.getElementById('stop').click()")
        badge = "document.getElementById('badge').textContent"
        browser.until("the end", f"/^(over|gone)$/.test({badge}) && {badge}")
    finally:
        os.kill(browser.process, signal.SIGKILL)


main()
