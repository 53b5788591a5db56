"""Run a program that gets no more modules, files, connections or threads after a line "refuse" on standard input.

    python -m tests.support.refused_means -c PROGRAM ARGUMENTS
    python -m tests.support.refused_means -m MODULE ARGUMENTS

A line "tell" makes it print `REFUSED [[kind, what, thread], ...]`: the modules that were to be imported and the files
that were to be opened since. A server's own loop may take the connections of its clients.
"""

from __future__ import annotations

import errno
import json
import os
import runpy
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

__all__ = ["RefusedMeans"]

ROOT = Path(__file__).resolve().parents[2]
LIMIT = "REFUSED_MEANS_FILES"
"""Environment variable: the hard limit of open files; 0 leaves it."""
LOOPS = ("woosh:web server", "rosproto:rosbridge", "rosproto:foxglove")


class RefusedMeans:
    """The program in a process of its own, from the test's side; use it in a `with` block."""

    def __init__(self, *words: str, files: int = 0) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-u", "-m", "tests.support.refused_means", *words],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            cwd=ROOT,
            env={**os.environ, LIMIT: str(files)},
        )

    def __enter__(self) -> RefusedMeans:
        return self

    def __exit__(self, *_: object) -> None:
        self.process.kill()
        self.process.communicate()

    def say(self, line: str) -> None:
        """Send a line to the program."""
        assert self.process.stdin is not None
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def line(self, start: str) -> str:
        """The rest of the next line that starts so."""
        assert self.process.stdout is not None
        said = ""
        for line in self.process.stdout:
            if line.startswith(start):
                return line[len(start) :].strip()
            said += line
        raise AssertionError(f"it ended and said: {said}")

    def refuse(self) -> None:
        """From now on it gets nothing more."""
        self.say("refuse")
        self.line("REFUSING")

    @property
    def asked_for(self) -> list[list[str]]:
        """The modules and files that it has asked for since, with the thread."""
        self.say("tell")
        found: list[list[str]] = json.loads(self.line("REFUSED"))
        return found


def _main() -> None:
    asked: list[list[str]] = []
    on = threading.Event()

    def audit(event: str, arguments: tuple[Any, ...]) -> None:
        if not on.is_set():
            return
        thread = threading.current_thread().name
        if event == "import":
            asked.append([event, str(arguments[0]), thread])
            raise ImportError(f"{arguments[0]}: nothing is imported any more")
        if event == "open":
            asked.append([event, str(arguments[0]), thread])
            raise OSError(errno.EMFILE, "no file is opened any more")
        if event in ("socket.__new__", "socket.connect") and not thread.startswith(LOOPS):
            raise OSError(errno.EMFILE, "no connection is made any more")

    def refuse(self: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    def listen() -> None:
        for line in sys.stdin:
            if line == "refuse\n":
                threading.Thread.start = refuse  # type: ignore[method-assign]
                on.set()
                os.write(1, b"REFUSING\n")
            elif line == "tell\n":
                os.write(1, f"REFUSED {json.dumps(asked)}\n".encode())
            else:
                lines.append(line.strip())
                came.release()

    lines: list[str] = []
    came = threading.Semaphore(0)

    def next_line() -> str:
        """The program's `next_line()`: wait for another line."""
        came.acquire()
        return lines.pop(0)

    if files := int(os.environ.get(LIMIT, "0")):
        import resource

        resource.setrlimit(resource.RLIMIT_NOFILE, (files, files))
    sys.addaudithook(audit)
    threading.Thread(target=listen, name="test:lines", daemon=True).start()
    how, what, *sys.argv[1:] = sys.argv[1:]
    if how == "-m":
        runpy.run_module(what, run_name="__main__", alter_sys=True)
    else:
        exec(what, {"__name__": "__main__", "next_line": next_line})


if __name__ == "__main__":
    _main()
