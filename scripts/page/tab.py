"""Tab of Chromium, used as a person uses it: files, keys, its log and its requests."""

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "guide"))

from browser import Browser, chromium

__all__ = ["LONGEST_S", "Tab", "chromium"]

LONGEST_S = 120.0


class Tab(Browser):
    """A browser that keeps what the page logs and which addresses it asks for."""

    def __init__(self, program):
        self.logged = []
        self.asked = []
        super().__init__(program)
        for domain in ("Runtime", "Log", "Network", "DOM"):
            self._ask(f"{domain}.enable")
        self._ask("Page.setBypassCSP", enabled=False)

    def _answer(self):
        answer = super()._answer()
        given = answer.get("params", {})
        match answer.get("method"):
            case "Runtime.consoleAPICalled" if given["type"] in ("error", "warning", "assert"):
                words = [str(one.get("value", one.get("description", ""))) for one in given["args"]]
                self.logged.append(" ".join(words))
            case "Runtime.exceptionThrown":
                thrown = given["exceptionDetails"]
                self.logged.append(thrown.get("exception", {}).get("description", thrown["text"]))
            case "Log.entryAdded" if given["entry"]["level"] in ("error", "warning"):
                self.logged.append(f"{given['entry']['text']} {given['entry'].get('url', '')}")
            case "Network.requestWillBeSent":
                self.asked.append(given["request"]["url"])
        return answer

    def visit(self, address):
        """Open an address and wait until the page has begun."""
        self._ask("Page.navigate", url=address)
        self.until("document.readyState === 'complete' && location.href !== 'about:blank'")

    def until(self, expression, longest_s=LONGEST_S):
        """Wait until an expression is true; give how long that took, in s."""
        begun = time.monotonic()
        while not self.value(f"Boolean({expression})"):
            if time.monotonic() - begun > longest_s:
                raise TimeoutError(f"not within {longest_s:.0f} s: {expression}")
            time.sleep(0.02)
        return time.monotonic() - begun

    def give(self, selector, paths):
        """Choose files in a file input."""
        root = self._ask("DOM.getDocument")["root"]["nodeId"]
        node = self._ask("DOM.querySelector", nodeId=root, selector=selector)["nodeId"]
        self._ask("DOM.setFileInputFiles", nodeId=node, files=[str(path) for path in paths])

    def key(self, name, code, number):
        """Press and release a key."""
        for kind in ("rawKeyDown", "keyUp"):
            self._ask(
                "Input.dispatchKeyEvent",
                type=kind,
                key=name,
                code=code,
                windowsVirtualKeyCode=number,
            )

    def click(self, selector):
        """Click by the element itself."""
        self.value(f"document.querySelector({selector!r}).click()")

    def keep_downloads(self, folder):
        """Let files that the page gives go into a folder."""
        self._ask("Page.setDownloadBehavior", behavior="allow", downloadPath=str(folder))

    def heap(self):
        """Give the bytes that JavaScript holds after a collection."""
        self._ask("HeapProfiler.collectGarbage")
        return self._ask("Runtime.getHeapUsage")["usedSize"]

    def whole_picture(self, path, width, *, dark):
        """Write a picture of the whole page."""
        self.size(width, 900, dark=dark)
        self.size(width, self.value("document.documentElement.scrollHeight"), dark=dark)
        time.sleep(0.4)
        self.picture(path)
        self.size(width, 900, dark=dark)
