"""A terminal for tests: a screen for our commands' output, and a process on a pseudo-terminal."""

from __future__ import annotations

import codecs
import fcntl
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import termios
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path

__all__ = ["ELSEWHERE", "LAUNCH", "Screen", "Terminal"]

ROOT = Path(__file__).resolve().parents[2]
SEQUENCE = re.compile(r"\x1b\[(?P<private>\??)(?P<numbers>[\d;]*)(?P<final>[A-Za-z])")
# The child makes the pseudo-terminal its controlling terminal, so Ctrl-C sends a signal.
LAUNCH = (
    "import fcntl, runpy, sys, termios; fcntl.ioctl(0, termios.TIOCSCTTY, 0); "
    "module = sys.argv[1]; sys.argv = sys.argv[1:]; runpy.run_module(module, run_name='__main__')"
)

ELSEWHERE = "import runpy, sys; module = sys.argv[1]; sys.argv = sys.argv[1:]; runpy.run_module(module, run_name='__main__')"
"""The same for a program of another session: the terminal sends it no signal."""


class Screen:
    """A screen of characters: renders the part of ECMA-48 that our commands use.

    Attributes:
        lines: The visible lines.
        alternate: True while the alternate screen is shown.
        cursor_visible: True while the cursor is visible.
        unknown: Sequences that this renderer does not support; tests expect none.
        seen: The final characters of all sequences; "m" is a colour.
    """

    def __init__(self, columns: int, rows: int) -> None:
        self.columns, self.rows = columns, rows
        self.alternate, self.cursor_visible = False, True
        self.unknown: list[str] = []
        self.seen: list[str] = []
        self._cells = self._blank()
        self._kept = self._cells
        self._row = self._column = 0
        self._decoder = codecs.getincrementaldecoder("utf-8")("strict")
        self._rest = ""

    def _blank(self) -> list[list[str]]:
        return [[" "] * self.columns for _ in range(self.rows)]

    @property
    def lines(self) -> list[str]:
        """The visible lines without trailing spaces."""
        return ["".join(line).rstrip() for line in self._cells]

    @property
    def text(self) -> str:
        """The visible lines as one text."""
        return "\n".join(self.lines)

    def feed(self, data: bytes) -> None:
        """Process output of the program, split at any position."""
        text, self._rest = self._rest + self._decoder.decode(data), ""
        at = 0
        while at < len(text):
            if text[at] == "\x1b":
                found = SEQUENCE.match(text, at)
                if found is None:
                    self._rest = text[at:]
                    return
                self._sequence(found)
                at = found.end()
            else:
                self._put(text[at])
                at += 1

    def _put(self, character: str) -> None:
        if character == "\r":
            self._column = 0
        elif character == "\n":
            self._line_feed()
        elif character == "\b":
            self._column = max(0, self._column - 1)
        elif character >= " ":
            if self._column >= self.columns:
                self._column = 0
                self._line_feed()
            self._cells[self._row][self._column] = character
            self._column += 1

    def _line_feed(self) -> None:
        self._row += 1
        if self._row >= self.rows:
            self._row = self.rows - 1
            del self._cells[0]
            self._cells.append([" "] * self.columns)

    def _sequence(self, found: re.Match[str]) -> None:
        final, private = found["final"], bool(found["private"])
        self.seen.append(final)
        numbers = [int(n or 0) for n in found["numbers"].split(";")]
        if private and final in "hl":
            self._mode(numbers[0], final == "h")
        elif final == "H":
            self._row, self._column = max(numbers[0], 1) - 1, max((*numbers, 1)[1], 1) - 1
        elif final == "C":
            self._column = min(self._column + max(numbers[0], 1), self.columns)
        elif final == "K" and numbers == [0]:
            self._cells[self._row][self._column :] = [" "] * (self.columns - self._column)
        elif final == "J" and numbers[0] in (0, 2):
            first = 0 if numbers[0] == 2 else self._row
            if numbers[0] == 0:
                self._cells[self._row][self._column :] = [" "] * (self.columns - self._column)
                first += 1
            for row in range(first, self.rows):
                self._cells[row] = [" "] * self.columns
        elif final != "m":
            self.unknown.append(found[0])

    def _mode(self, number: int, on: bool) -> None:
        if number == 25:
            self.cursor_visible = on
        elif number == 1049:
            self.alternate = on
            if on:
                self._kept, self._cells = self._cells, self._blank()
            else:
                self._cells = self._kept
        elif number != 2004:  # bracketed paste, which readline enables
            self.unknown.append(f"mode {number}")


class Terminal:
    """A command in a separate process on a pseudo-terminal. Use it in a `with` block.

    Args:
        arguments: Arguments of the command.
        columns, rows: Size of the terminal.
        module: woosh_pure or rosproto.
        launch: Python code that takes the controlling terminal and runs the module with its arguments.
        environment: Changed variables.

    Attributes:
        screen: The screen.
        process: The command.
    """

    def __init__(
        self,
        *arguments: str,
        columns: int = 100,
        rows: int = 30,
        module: str = "woosh_pure",
        launch: Sequence[str] = (sys.executable, "-c", LAUNCH),
        **environment: str,
    ) -> None:
        self.screen = Screen(columns, rows)
        self._master, self._slave = pty.openpty()
        fcntl.ioctl(self._slave, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
        self.before = termios.tcgetattr(self._slave)
        inherited = {k: v for k, v in os.environ.items() if k not in ("ROS_MASTER_URI", "COLUMNS", "LINES")}
        self.process = subprocess.Popen(
            [*launch, module, *arguments],
            stdin=self._slave,
            stdout=self._slave,
            stderr=self._slave,
            start_new_session=True,
            env={
                **inherited,
                "PYTHONPATH": str(ROOT),
                "PYTHONIOENCODING": "utf-8",
                "TERM": "xterm-256color",
                **environment,
            },
        )
        self._lock = threading.Lock()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._read, name="test:terminal", daemon=True)
        self._thread.start()

    def __enter__(self) -> Terminal:
        return self

    def __exit__(self, *_: object) -> None:
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGKILL)
        self.process.wait(10)
        if not self._over.is_set():
            self.hang_up()
        os.close(self._slave)

    def hang_up(self) -> None:
        """Close the terminal's window."""
        self._over.set()
        self._thread.join(5)
        os.close(self._master)

    def _read(self) -> None:
        while not self._over.is_set():
            if select.select([self._master], [], [], 0.05)[0]:
                data = os.read(self._master, 65536)
                with self._lock:
                    self.screen.feed(data)

    @property
    def text(self) -> str:
        """Current text of the screen."""
        with self._lock:
            return self.screen.text

    def send(self, keys: str) -> None:
        """Press keys."""
        os.write(self._master, keys.encode())

    def wait_for(self, words: str | Callable[[str], bool], timeout: float = 20.0) -> str:
        """Wait until the screen shows `words` or satisfies the predicate; return its text."""
        accept = words if callable(words) else lambda text: words in text
        end = time.monotonic() + timeout
        while not accept(text := self.text):
            assert time.monotonic() < end, f"{words!r} did not come; the screen:\n{text}"
            time.sleep(0.01)
        return text

    def exit_code(self, timeout: float = 20.0) -> int:
        """Wait for the end of the command; all its output is then on the screen."""
        code = self.process.wait(timeout)
        end = time.monotonic() + 2.0
        while select.select([self._master], [], [], 0.0)[0] and time.monotonic() < end:
            time.sleep(0.02)
        return code

    def suspend(self) -> None:
        """Stop the output, as Ctrl-S does."""
        termios.tcflow(self._slave, termios.TCOOFF)

    @property
    def restored(self) -> bool:
        """True if the terminal's modes (echo, lines, signals) are as before the command."""
        return termios.tcgetattr(self._slave) == self.before
