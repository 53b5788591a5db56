"""Firefox and WebKitGTK (the engine family of Safari) for tests of the page, each by its remote protocol.

Debian has both: `apt-get install firefox-esr`, and `apt-get install webkit2gtk-driver xvfb`. No further driver is
needed: Firefox itself speaks WebDriver BiDi over a WebSocket, WebKit's driver speaks WebDriver over HTTP. Both have
one interface: evaluate, point, press keys, take a picture, close the window.
"""

from __future__ import annotations

import base64
import itertools
import json
import os
import queue
import re
import shutil
import socket
import subprocess
import threading
import time
import urllib.request
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from glob import glob
from pathlib import Path
from typing import Any

import pytest

from tests.support.ros import free_port

__all__ = ["ENGINES", "Engine", "Window", "firefox", "webkit"]

START_SECONDS = 60.0
"""A browser that starts for the first time, on a busy machine."""


class Window(ABC):
    """One window of a browser."""

    @abstractmethod
    def evaluate(self, expression: str) -> Any:
        """Return the value of a JavaScript expression, as JSON."""

    @abstractmethod
    def perform(self, *sources: dict[str, Any]) -> None:
        """WebDriver's input actions."""

    @abstractmethod
    def resize(self, width: int, height: int) -> None:
        """Set the size of the page."""

    @abstractmethod
    def picture(self) -> bytes:
        """Return a screenshot as PNG."""

    @abstractmethod
    def close(self) -> None:
        """As by the cross of its tab."""

    def until(self, expression: str, seconds: float = 20.0) -> Any:
        """Wait until it is true; a failure names the condition."""
        deadline = time.monotonic() + seconds
        while not (found := self.evaluate(expression)):
            assert time.monotonic() < deadline, f"not true within {seconds} s: {expression}"
            time.sleep(0.03)
        return found

    def shows(self, selector: str, text: str = "", seconds: float = 20.0) -> None:
        """Wait until a matching element is visible."""
        self.until(
            f"[...document.querySelectorAll({json.dumps(selector)})].some((one) => "
            f"one.getClientRects().length && one.innerText.includes({json.dumps(text)}))",
            seconds,
        )

    def point(self, selector: str, text: str = "") -> tuple[int, int]:
        """Return the middle of the first matching element, scrolled into view."""
        self.shows(selector, text)
        x, y = self.evaluate(
            f"(() => {{ const one = [...document.querySelectorAll({json.dumps(selector)})].find((one) => "
            f"one.getClientRects().length && one.innerText.includes({json.dumps(text)}));"
            "one.scrollIntoView({block: 'nearest'}); const box = one.getBoundingClientRect();"
            "return [Math.round(box.x + box.width / 2), Math.round(box.y + box.height / 2)]; })()"
        )
        return int(x), int(y)

    def pointer(self, *steps: dict[str, Any]) -> None:
        """The mouse."""
        self.perform(
            {"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}, "actions": list(steps)}
        )

    def move(self, x: int, y: int) -> None:
        self.pointer({"type": "pointerMove", "x": x, "y": y, "duration": 0})

    def down(self) -> None:
        self.pointer({"type": "pointerDown", "button": 0})

    def up(self) -> None:
        self.pointer({"type": "pointerUp", "button": 0})

    def click(self, selector: str, text: str = "") -> None:
        x, y = self.point(selector, text)
        self.pointer(
            {"type": "pointerMove", "x": x, "y": y, "duration": 0},
            {"type": "pointerDown", "button": 0},
            {"type": "pointerUp", "button": 0},
        )

    def key(self, value: str, *, down: bool) -> None:
        self.perform(
            {
                "type": "key",
                "id": "keys",
                "actions": [{"type": "keyDown" if down else "keyUp", "value": value}],
            }
        )


class Engine(ABC):
    """A browser that runs."""

    @abstractmethod
    def open(self, url: str) -> Window:
        """A new window with the page."""

    @abstractmethod
    def errors(self) -> list[str]:
        """Return the console errors and exceptions of pages since the last call."""


# -- Firefox: WebDriver BiDi over a WebSocket -----------------------------------------------------------------------


class _Bidi(Engine):
    def __init__(self, line: Any) -> None:
        self._line = line
        self._numbers = itertools.count(1)
        self._errors: list[str] = []
        self.call("session.new", capabilities={})
        self.call("session.subscribe", events=["log.entryAdded"])

    def call(self, method: str, **params: Any) -> Any:
        number = next(self._numbers)
        self._line.send(json.dumps({"id": number, "method": method, "params": params}))
        while True:
            answer = json.loads(self._line.recv(timeout=60))
            if answer.get("method") == "log.entryAdded" and answer["params"]["level"] == "error":
                self._errors.append(str(answer["params"]["text"]))
            if answer.get("id") == number:
                assert answer["type"] == "success", answer
                return answer["result"]

    def open(self, url: str) -> Window:
        context = self.call("browsingContext.create", type="tab")["context"]
        self.call("browsingContext.navigate", context=context, url=url, wait="complete")
        return _BidiWindow(self, context)

    def errors(self) -> list[str]:
        self.call("session.status")  # earlier events arrive before its answer
        errors, self._errors = self._errors, []
        return errors


class _BidiWindow(Window):
    def __init__(self, engine: _Bidi, context: str) -> None:
        self._engine, self._context = engine, context

    def _call(self, method: str, **params: Any) -> Any:
        return self._engine.call(method, context=self._context, **params)

    def evaluate(self, expression: str) -> Any:
        answer = self._engine.call(
            "script.evaluate",
            expression=f"JSON.stringify({expression})",
            target={"context": self._context},
            awaitPromise=False,
        )
        assert answer["type"] == "success", answer
        return json.loads(answer["result"].get("value", "null"))

    def perform(self, *sources: dict[str, Any]) -> None:
        self._call("input.performActions", actions=list(sources))

    def resize(self, width: int, height: int) -> None:
        self._call("browsingContext.setViewport", viewport={"width": width, "height": height})

    def picture(self) -> bytes:
        return base64.b64decode(self._call("browsingContext.captureScreenshot")["data"])

    def close(self) -> None:
        self._call("browsingContext.close")


@contextmanager
def firefox(folder: Path) -> Iterator[Engine]:
    """Run headless Firefox in a new profile; skip the test if it is not installed."""
    found = os.environ.get("WOOSH_FIREFOX") or shutil.which("firefox-esr") or shutil.which("firefox")
    if found is None:
        pytest.skip("no Firefox: neither $WOOSH_FIREFOX nor firefox-esr or firefox in PATH")
    from websockets.sync.client import connect

    profile = folder / "profile"
    profile.mkdir(parents=True)
    (profile / "user.js").write_text(
        'user_pref("intl.accept_languages", "en-US, en");\n'
        'user_pref("browser.shell.checkDefaultBrowser", false);\n'
        'user_pref("datareporting.policy.dataSubmissionEnabled", false);\n'
        'user_pref("app.update.enabled", false);\n'
        'user_pref("network.captive-portal-service.enabled", false);\n'
        'user_pref("network.connectivity-service.enabled", false);\n'
        'user_pref("services.settings.server", "data:,");\n'
        'user_pref("browser.safebrowsing.update.enabled", false);\n'
        'user_pref("remote.active-protocols", 1);\n'
    )
    with running(
        [found, "--headless", "--no-remote", "--profile", str(profile), "--remote-debugging-port", "0"],
        folder,
    ) as lines:
        address = said(lines, r"WebDriver BiDi listening on (ws://\S+)")
        with connect(f"{address}/session", max_size=None, open_timeout=START_SECONDS, proxy=None) as line:
            yield _Bidi(line)


# -- WebKit: WebDriver over HTTP ------------------------------------------------------------------------------------


class _Classic(Engine):
    def __init__(self, port: int, browser: str, console: list[str]) -> None:
        self._root, self._console = f"http://127.0.0.1:{port}", console
        self.frame = [0, 0]  # size of a window minus that of its page
        self._opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
        options = {
            "binary": browser,
            "args": ["--automation", "--enable-write-console-messages-to-stdout=true"],
        }
        wanted = {"alwaysMatch": {"webkitgtk:browserOptions": options}}
        session = self.call("POST", "/session", {"capabilities": wanted})
        self._root += f"/session/{session['sessionId']}"
        self._first = self.call("GET", "/window")

    def call(self, method: str, path: str, body: Any = None) -> Any:
        data = json.dumps(body or {}).encode() if method == "POST" else None
        request = urllib.request.Request(
            self._root + path, data, {"Content-Type": "application/json"}, method=method
        )
        with self._opener.open(request, timeout=START_SECONDS) as answer:
            return json.load(answer)["value"]

    def open(self, url: str) -> Window:
        self.call("POST", "/window", {"handle": self._first})
        window = self.call("POST", "/window/new", {"type": "window"})["handle"]
        self.call("POST", "/window", {"handle": window})
        self.call("POST", "/url", {"url": url})
        return _ClassicWindow(self, window)

    def errors(self) -> list[str]:
        errors = [line for line in self._console if re.search(r"CONSOLE .*\bERROR\b", line)]
        self._console.clear()
        return errors

    def close(self) -> None:
        self.call("DELETE", "")


class _ClassicWindow(Window):
    def __init__(self, engine: _Classic, handle: str) -> None:
        self._engine, self._handle = engine, handle

    def _call(self, method: str, path: str, body: Any = None) -> Any:
        return self._engine.call(method, path, body)

    def evaluate(self, expression: str) -> Any:
        script = {"script": f"return JSON.stringify({expression})", "args": []}
        return json.loads(self._call("POST", "/execute/sync", script) or "null")

    def perform(self, *sources: dict[str, Any]) -> None:
        self._call("POST", "/actions", {"actions": list(sources)})

    def resize(self, width: int, height: int) -> None:
        frame = self._engine.frame
        wanted, inner = [width, height], [0, 0]
        for _ in range(4):  # the size of its frame is not known before
            self._call("POST", "/window/rect", {"width": width + frame[0], "height": height + frame[1]})
            deadline = time.monotonic() + 0.7  # the page is told later
            while inner != wanted and time.monotonic() < deadline:
                time.sleep(0.03)
                inner = self.evaluate("[innerWidth, innerHeight]")
            if inner == wanted:
                return
            frame[:] = [frame[0] + width - inner[0], frame[1] + height - inner[1]]
        raise AssertionError(f"the page is {inner}, not {wanted}")

    def picture(self) -> bytes:
        return base64.b64decode(self._call("GET", "/screenshot"))

    def close(self) -> None:
        self._call("DELETE", "/window")


@contextmanager
def webkit(folder: Path) -> Iterator[Engine]:
    """Run WebKitGTK's MiniBrowser on a virtual screen; skip the test if it, or Xvfb, is not installed."""
    driver, screen = shutil.which("WebKitWebDriver"), shutil.which("Xvfb")
    browsers = glob("/usr/lib*/*/webkit2gtk-4.*/MiniBrowser") + glob("/usr/lib*/webkit2gtk-4.*/MiniBrowser")
    if driver is None or not browsers:
        pytest.skip("no WebKitWebDriver with its MiniBrowser (Debian: webkit2gtk-driver)")
    if screen is None:
        pytest.skip("no Xvfb: WebKitGTK needs a screen")
    style = folder / ".config/gtk-3.0/gtk.css"
    style.parent.mkdir(parents=True)
    # The buttons of its own frame would not let it be as narrow as a phone.
    style.write_text(
        "* { min-width: 0; padding: 0; margin: 0; border-width: 0; -gtk-icon-transform: scale(0); }"
    )
    with ExitStack() as stack:
        lines = stack.enter_context(
            running([screen, "-displayfd", "1", "-screen", "0", "1600x1200x24", "-nolisten", "tcp"], folder)
        )
        display = said(lines, r"^(\d+)$")
        port = free_port()
        lines = stack.enter_context(
            running([driver, f"--port={port}"], folder, DISPLAY=f":{display}", LIBGL_ALWAYS_SOFTWARE="1")
        )
        _listening(port)
        browser = _Classic(port, browsers[0], lines.seen)
        try:
            yield browser
        finally:
            browser.close()


ENGINES = {"firefox": firefox, "webkit": webkit}

# -- What both need -------------------------------------------------------------------------------------------------


class _Lines:
    """The output of a program, line by line."""

    def __init__(self) -> None:
        self.seen: list[str] = []
        self.coming: queue.Queue[str] = queue.Queue()

    def take(self, line: str) -> None:
        self.seen.append(line)
        self.coming.put(line)


def said(lines: _Lines, pattern: str) -> str:
    deadline = time.monotonic() + START_SECONDS
    while True:
        try:
            line = lines.coming.get(timeout=max(0.0, deadline - time.monotonic()))
        except queue.Empty:
            raise AssertionError(f"nothing like {pattern!r} in {lines.seen[-20:]}") from None
        if found := re.search(pattern, line):
            return found[1]


def _listening(port: int) -> None:
    deadline = time.monotonic() + START_SECONDS
    while True:
        with suppress(ConnectionRefusedError), socket.create_connection(("127.0.0.1", port), 5):
            return
        assert time.monotonic() < deadline, f"nobody listens at port {port}"
        time.sleep(0.05)


@contextmanager
def running(command: list[str], home: Path, **environment: str) -> Iterator[_Lines]:
    """Run a program with a temporary home; end it at the end, by force if necessary."""
    inherited = {name: value for name, value in os.environ.items() if "proxy" not in name.lower()}
    folders = {"HOME": home, "XDG_CONFIG_HOME": home / ".config", "XDG_RUNTIME_DIR": home}
    own = {name: str(folder) for name, folder in folders.items()} | {"MOZ_CRASHREPORTER_DISABLE": "1"}
    process = subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        env=inherited | own | environment,
    )
    assert process.stdout is not None
    lines = _Lines()

    def read(stream: Any) -> None:
        for line in stream:
            lines.take(line.rstrip("\n"))

    reader = threading.Thread(target=read, args=(process.stdout,), daemon=True)
    reader.start()
    try:
        yield lines
    finally:
        process.terminate()
        try:
            process.wait(15)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait(15)
        reader.join(5)
