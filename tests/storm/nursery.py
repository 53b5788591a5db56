"""A process that forks programs: starting Python and importing everything takes longer than a whole trial.

It is forked before any thread is there, has everything imported, and forks one child for each program. The child
returns from `Nursery.begin` with the code to run, and ends as any program does: its interrupt unwinds to the top of
the interpreter, and what is registered with atexit runs.
"""

from __future__ import annotations

import json
import os
import signal
import sys
from pathlib import Path
from typing import IO

__all__ = ["Child", "Nursery"]


class Child:
    """A program under way. Reaped by `wait` only, so that its id is nobody else's until then."""

    def __init__(self, nursery: Nursery, pid: int) -> None:
        self._nursery = nursery
        self.pid = pid

    def interrupt(self, number: int = signal.SIGINT) -> None:
        """Send a signal; to one that has ended it does nothing."""
        os.kill(self.pid, number)

    def ended(self) -> bool:
        """Whether it has ended; it is not reaped."""
        status = Path(f"/proc/{self.pid}/stat")
        try:
            return status.read_text().rpartition(")")[2].split()[0] == "Z"
        except OSError:
            return True

    def reap(self) -> int:
        """Its exit status, after it has ended."""
        return int(self._nursery.ask({"reap": self.pid})["status"])


class Nursery:
    """Forks programs. To be made before the first thread; in the child of each program `program` is its code."""

    def __init__(self) -> None:
        theirs, self._out = os.pipe()
        self._in, answers = os.pipe()
        if os.fork() == 0:
            os.close(self._out)
            os.close(self._in)
            code = _serve(os.fdopen(theirs, "r"), os.fdopen(answers, "w"))
            if code is None:
                os._exit(0)
            raise Born(code)
        os.close(theirs)
        os.close(answers)
        self._to, self._from = os.fdopen(self._out, "w"), os.fdopen(self._in, "r")

    def ask(self, request: dict[str, object]) -> dict[str, object]:
        """One question and its answer."""
        self._to.write(json.dumps(request) + "\n")
        self._to.flush()
        answer: dict[str, object] = json.loads(self._from.readline())
        return answer

    def start(self, code: str, uri: str, output: str, terminal: str = "") -> Child:
        """Run a program.

        Args:
            code: Its text.
            uri: Its only argument.
            output: File for what it says.
            terminal: Name of a terminal for its stdin and stdout.
        """
        answer = self.ask({"code": code, "uri": uri, "output": output, "terminal": terminal})
        return Child(self, int(str(answer["pid"])))

    def close(self) -> None:
        """End it; its programs have ended."""
        self._to.close()
        self._from.close()
        os.wait()


class Born(Exception):
    """Raised in a new program, up to the top of the process, where its code is run."""

    def __init__(self, code: str) -> None:
        super().__init__("a new program")
        self.code = code


def _serve(requests: IO[str], answers: IO[str]) -> str | None:
    import woosh_pure.chassis  # imported once for all
    import woosh_pure.cli.entry  # noqa: F401

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for line in requests:
        request = json.loads(line)
        if "reap" in request:
            answer = {"status": os.waitstatus_to_exitcode(os.waitpid(request["reap"], 0)[1])}
        else:
            pid = os.fork()
            if pid == 0:
                requests.close()
                answers.close()
                _be(request)
                return str(request["code"])
            answer = {"pid": pid}
        answers.write(json.dumps(answer) + "\n")
        answers.flush()
    return None


def _be(request: dict[str, str]) -> None:
    signal.signal(signal.SIGINT, signal.default_int_handler)
    os.setsid()
    output = os.open(request["output"], os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(output, 2)
    if request["terminal"]:
        terminal = os.open(request["terminal"], os.O_RDWR)
        os.dup2(terminal, 0)
        os.dup2(terminal, 1)
    else:
        os.dup2(output, 1)
    sys.argv = ["program", request["uri"]]
