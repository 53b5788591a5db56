"""A Chromium with a window, on a screen of its own with a window manager, and the mouse and keyboard of that screen.

A browser without a window, and one that is driven by an automation protocol's input, pretend that they have the focus:
no menu opens, and no key goes elsewhere. Here `xdotool` presses, the X server delivers, and the browser is only asked
what its page shows (`Runtime.evaluate`). Debian: `apt-get install chromium xvfb openbox xdotool`.
"""

from __future__ import annotations

import itertools
import json
import os
import shutil
import subprocess
import time
import urllib.request
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from tests.support.browser import chromium_program
from tests.support.engines import running, said
from tests.support.ros_process import require

__all__ = ["RealWindow", "real_window"]

SIZE = (1280, 900)


class RealWindow:
    """The window, and what a person does in front of it."""

    def __init__(self, display: str, line: Any) -> None:
        self._display, self._line = display, line
        self._numbers = itertools.count(1)

    def call(self, method: str, **params: Any) -> Any:
        """Ask the browser's page; never with a method that sends input or changes the focus."""
        number = next(self._numbers)
        self._line.send(json.dumps({"id": number, "method": method, "params": params}))
        while True:
            answer = json.loads(self._line.recv(timeout=60))
            if answer.get("id") == number:
                assert "error" not in answer, answer
                return answer["result"]

    def evaluate(self, expression: str) -> Any:
        """Return the value of a JavaScript expression, as JSON."""
        answer = self.call("Runtime.evaluate", expression=f"JSON.stringify({expression})")
        assert "exceptionDetails" not in answer, answer
        return json.loads(answer["result"].get("value", "null"))

    def until(self, expression: str, seconds: float = 20.0) -> Any:
        """Wait until it is true."""
        deadline = time.monotonic() + seconds
        while not (found := self.evaluate(expression)):
            assert time.monotonic() < deadline, f"not true within {seconds} s: {expression}"
            time.sleep(0.03)
        return found

    def xdotool(self, *arguments: object) -> str:
        """The person's hands."""
        done = subprocess.run(
            ["xdotool", *map(str, arguments)],
            env=os.environ | {"DISPLAY": f":{self._display}"},
            capture_output=True,
            text=True,
            timeout=30,
            check=True,
        )
        return done.stdout

    def point(self, selector: str) -> tuple[int, int]:
        """Return the middle of an element, in pixels of the screen."""
        self.until(f"(document.querySelector({json.dumps(selector)})?.getClientRects().length ?? 0) > 0")
        x, y = self.evaluate(
            f"(() => {{ const box = document.querySelector({json.dumps(selector)}).getBoundingClientRect();"
            "return [screenX + (outerWidth - innerWidth) / 2 + box.x + box.width / 2,"
            "screenY + outerHeight - innerHeight + box.y + box.height / 2]; })()"
        )
        return round(x), round(y)

    def move(self, selector: str, dx: int = 0, dy: int = 0) -> None:
        """Put the mouse over an element."""
        x, y = self.point(selector)
        self.xdotool("mousemove", x + dx, y + dy)

    def click(self, selector: str, button: int = 1) -> None:
        """Click an element."""
        self.move(selector)
        self.xdotool("click", button)


@contextmanager
def real_window(folder: Path, url: str) -> Iterator[RealWindow]:
    """Open the address in a window with the focus; skip the test if something for it is not installed."""
    program = chromium_program()
    for name in ("Xvfb", "openbox", "xdotool"):
        require(shutil.which(name) is not None, f"{name} is not installed (Debian: xvfb openbox xdotool)")
    from websockets.sync.client import connect

    with ExitStack() as stack:
        size = f"{SIZE[0]}x{SIZE[1]}x24"
        screen = ["Xvfb", "-displayfd", "1", "-screen", "0", size, "-nolisten", "tcp"]
        display = said(stack.enter_context(running(screen, folder)), r"^(\d+)$")
        here = {"DISPLAY": f":{display}"}
        stack.enter_context(running(["openbox", "--sm-disable"], folder, **here))
        options = [
            "--no-sandbox", "--no-first-run", "--no-default-browser-check", "--disable-gpu", "--lang=en-US",
            "--disable-background-networking", "--disable-component-update", "--password-store=basic",
            "--window-position=0,0", f"--window-size={SIZE[0]},{SIZE[1]}", f"--user-data-dir={folder / 'profile'}",
            "--remote-debugging-port=0",
        ]  # fmt: skip
        lines = stack.enter_context(running([program, *options, url], folder, **here))
        address = said(lines, r"DevTools listening on ws://([^/]+)/")
        pages: list[Any] = []
        opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
        deadline = time.monotonic() + 60
        while not pages:
            assert time.monotonic() < deadline, "no page was opened"
            with opener.open(f"http://{address}/json/list", timeout=20) as answer:
                pages = [
                    one for one in json.load(answer) if one["type"] == "page" and one["url"].startswith(url)
                ]
        line = stack.enter_context(
            connect(pages[0]["webSocketDebuggerUrl"], max_size=None, open_timeout=60, proxy=None)
        )
        window = RealWindow(display, line)
        window.until("document.hasFocus() && document.querySelector('.markrow') !== null", 60)
        yield window
