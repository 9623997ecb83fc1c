"""A headless Chromium that is asked over a pipe: no driver, no port, no package."""

import base64
import fcntl
import json
import os
import shutil
import signal
import tempfile
import time
from pathlib import Path

NAMES = ["chromium", "chromium-browser", "google-chrome", "chrome"]
_FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-extensions",
    "--disable-background-networking",
    "--no-first-run",
    "--hide-scrollbars",
    "--allow-file-access-from-files",
    "--remote-debugging-pipe",
]
_LONGEST_S = 30.0


def chromium():
    """Path of an installed Chromium, or None."""
    return next(filter(None, map(shutil.which, NAMES)), None)


def _pipe():
    """Give both ends of a pipe, out of the way of the descriptors that the browser gets."""
    ends = []
    for end in os.pipe():
        ends.append(fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, 10))
        os.close(end)
    return ends


class Browser:
    """One Chromium with one tab, as a context manager."""

    def __init__(self, program):
        self._number = 0
        self._unread = b""
        self._profile = tempfile.TemporaryDirectory(prefix="guide-", ignore_cleanup_errors=True)
        commands, self._commands = _pipe()
        self._answers, answers = _pipe()
        command = [program, *_FLAGS, f"--user-data-dir={self._profile.name}"]
        self._process = os.posix_spawn(
            program,
            command,
            os.environ,
            file_actions=[
                (os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0),
                (os.POSIX_SPAWN_OPEN, 2, os.devnull, os.O_WRONLY, 0),
                # the descriptors on which Chromium listens and answers
                (os.POSIX_SPAWN_DUP2, commands, 3),
                (os.POSIX_SPAWN_DUP2, answers, 4),
            ],
        )
        os.close(commands)
        os.close(answers)
        self._tab = None
        target = self._ask("Target.createTarget", url="about:blank")["targetId"]
        self._tab = self._ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self._ask("Page.enable")

    def __enter__(self):
        """Give itself."""
        return self

    def __exit__(self, *_):
        """End the browser and what it wrote."""
        os.kill(self._process, signal.SIGKILL)
        os.waitpid(self._process, 0)
        os.close(self._commands)
        os.close(self._answers)
        self._profile.cleanup()

    def size(self, width, height=900, *, dark=False, media=""):
        """Set the window's size in CSS pixels, the preferred colours, and the medium."""
        self._ask(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self._ask("Emulation.setEmulatedMedia", media=media, features=[scheme])

    def open(self, path):
        """Open a file and wait until it, its scripts and its fonts are there."""
        self._ask("Page.navigate", url=Path(path).resolve().as_uri())
        ready = "document.readyState === 'complete' && location.href !== 'about:blank'"
        until = time.monotonic() + _LONGEST_S
        while not self.value(ready):
            if time.monotonic() > until:
                raise TimeoutError(f"{path} does not load")
            time.sleep(0.01)
        self.value("document.fonts.ready.then(() => true)")

    def value(self, expression):
        """Evaluate JavaScript in the page; promises are awaited."""
        answer = self._ask(
            "Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True
        )
        if "exceptionDetails" in answer:
            raise RuntimeError(f"{expression}: {answer['exceptionDetails']}")
        return answer["result"].get("value")

    def picture(self, path):
        """Write what the window shows as PNG."""
        Path(path).write_bytes(
            base64.b64decode(self._ask("Page.captureScreenshot", format="png")["data"])
        )

    def _ask(self, method, **parameters):
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._tab is not None:
            message["sessionId"] = self._tab
        os.write(self._commands, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._answer()
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']['message']}")
                return answer["result"]

    def _answer(self):
        while b"\0" not in self._unread:
            part = os.read(self._answers, 1 << 16)
            if not part:
                raise RuntimeError("the browser has ended")
            self._unread += part
        answer, self._unread = self._unread.split(b"\0", 1)
        return json.loads(answer)
