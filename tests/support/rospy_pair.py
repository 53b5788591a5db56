"""Runs one program twice, by real rospy and by our layer, and compares the outcomes.

Each run has a new master and a new peer. The comparison covers the exit code, both streams and the peer's
log. Process ids, inner lines of tracebacks and addresses are replaced first.
"""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

from rosproto.master import Master
from tests.support import ros

__all__ = ["Outcome", "Peer", "normalised", "run_program"]

ROOT = Path(__file__).resolve().parents[2]
PROGRAMS = ROOT / "tests" / "interop" / "programs"
TIMEOUT = 60.0

Peer = Callable[[str, list[Any]], AbstractContextManager[Any]]
"""`peer(master_uri, log)`: runs beside the program and records its observations in `log`."""


@dataclass
class Outcome:
    """The outcome of a program.

    Attributes:
        code: Exit code; negative for a signal.
        out, err: Normalised lines of the two streams.
        noted: The peer's log.
        seconds: Time from the signal (or the start) to the end.
    """

    code: int
    out: list[str]
    err: list[str]
    noted: list[Any] = field(default_factory=list)
    seconds: float = 0.0

    def compared(self) -> tuple[Any, ...]:
        """The values that must be equal."""
        return self.code, self.out, self.err, self.noted


_IGNORED = (
    "[DEBUG] ",  # rospy's internal messages
    "[ERROR] Got a transition callback on a goal handle that we're not tracking",  # a race inside actionlib
)
_CHAINED = ("During handling of the above exception", "The above exception was the direct cause")


def normalised(text: str) -> list[str]:
    """Replace parts that differ between runs; keep only the last of chained tracebacks."""
    lines: list[str] = []
    in_trace = False
    for line in text.splitlines():
        if line.startswith("Traceback (most recent call last)"):
            in_trace = True
            lines.append("TRACEBACK")
            continue
        if line.startswith(_CHAINED):
            del lines[len(lines) - 1 - lines[::-1].index("TRACEBACK") :]
            in_trace = True
            continue
        if in_trace and (line.startswith(" ") or not line):
            continue
        in_trace = False
        line = re.sub(r"_\d+_\d{10,}", "_PID_MS", line)
        line = re.sub(r"0x[0-9a-f]{6,}", "0xADDRESS", line)
        line = re.sub(r"\[\d{9,}\.\d+(, \d+\.\d+)?\]", "[TIME]", line)
        line = re.sub(r"^\[['\"]Traceback \(most.*", "[TRACEBACK]", line)
        line = re.sub(r"http://[\w.]+:\d+/?", "http://URI", line)
        line = re.sub(r"\bThread-\d+", "Thread-N", line)
        line = re.sub(r"^(.*Could not process inbound connection: .*?)\{'.*", r"\1HEADER", line)
        if line.startswith(_IGNORED) and "debug 1" not in line:
            continue
        lines.append(line)
    return lines


class _Reader:
    def __init__(self, stream: IO[str]) -> None:
        self.lines: list[str] = []
        self.changed = threading.Condition()
        self._thread = threading.Thread(target=self._read, args=(stream,), daemon=True)
        self._thread.start()

    def _read(self, stream: IO[str]) -> None:
        for line in stream:
            with self.changed:
                self.lines.append(line)
                self.changed.notify_all()

    def wait_for(self, word: str, timeout: float) -> bool:
        with self.changed:
            return self.changed.wait_for(lambda: any(word in line for line in self.lines), timeout)

    def text(self) -> str:
        self._thread.join(5)
        return "".join(self.lines)


def run_program(
    program: str | Path,
    *arguments: str,
    real: bool,
    packages: Sequence[Path | str] = (),
    peer: Peer | None = None,
    interrupt: int | None = None,
    ready: str = "ready",
    env: Mapping[str, str] | None = None,
    master_uri: str | None = None,
    master_params: Mapping[str, Any] | None = None,
    options: Sequence[str] = (),
    command: str = "rosproto",
) -> Outcome:
    """Run a program once.

    Args:
        program: Name of a file in tests/interop/programs, or a path.
        real: Run by Debian's rospy; else by `rosproto run`.
        packages: Folders for PYTHONPATH: generated code for real rospy, or user packages.
        interrupt: Signal to send after the program printed `ready`.
        options: Options of `rosproto run`.
        command: Whose `run` it is: rosproto's or woosh_pure's.
    """
    path = PROGRAMS / program
    noted: list[Any] = []
    with ExitStack() as stack:
        if master_uri is None:
            master_uri = stack.enter_context(Master()).uri
        _set_params(master_uri, master_params or {})
        stack.enter_context(peer(master_uri, noted) if peer else nullcontext())
        folders = [str(folder) for folder in packages]
        if not real:
            folders.append(str(ROOT))
        environment = ros.environment(master_uri, packages=os.pathsep.join(folders), extra=env)
        start = [ros.PYTHON] if real else [sys.executable, "-m", command, "run", *options]
        process = subprocess.Popen(
            [*start, str(path), *arguments],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=environment,
            start_new_session=True,
        )
        try:
            return _finish(process, interrupt, ready, noted)
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait(10)


def _finish(process: subprocess.Popen[str], interrupt: int | None, ready: str, noted: list[Any]) -> Outcome:
    assert process.stdout is not None
    assert process.stderr is not None
    out, err = _Reader(process.stdout), _Reader(process.stderr)
    began = time.monotonic()
    try:
        if interrupt is not None:
            assert out.wait_for(ready, 30), f"the program never got ready:\n{out.text()}\n{err.text()}"
            _wait_until_it_waits(process.pid)
            began = time.monotonic()
            process.send_signal(interrupt)
        code = process.wait(TIMEOUT)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait(10)
        raise AssertionError(f"it did not end:\n{out.text()}\n{err.text()}") from None
    seconds = time.monotonic() - began
    return Outcome(code, normalised(out.text()), normalised(err.text()), noted, seconds)


def _wait_until_it_waits(pid: int, samples: int = 6) -> None:
    """Wait until the program waits after the print: its main thread sleeps in `samples` successive checks.

    A thread that is ready to run is not asleep, so a busy machine does not falsify the result.
    """
    asleep = 0
    end = time.monotonic() + 20
    while asleep < samples and time.monotonic() < end:
        time.sleep(0.05)
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
        if state == "Z":
            return  # it has ended: the comparison reports it
        asleep = asleep + 1 if state == "S" else 0


def _set_params(master_uri: str, params: Mapping[str, Any]) -> None:
    if params:
        from rosproto.node import MasterClient

        with MasterClient(master_uri, "/test") as master:
            for key, value in params.items():
                master.set_param(key, value)
