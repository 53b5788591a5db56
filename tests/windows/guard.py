"""Runs one program under Wine and ends it when it cannot end itself: `guard.py SECONDS SERVER_LOG COMMAND...`

Wine's server can crash (README.md here). Its programs then wait for ever for an answer, a time limit of their own
never comes to pass, and the process is left as a zombie whose threads live on. Here the server is looked for while
the program runs. The output is copied from a pipe: Wine gives Python no usable handle for a plain file.

Exit codes: the program's; 75 the server died (again may help), 124 the time was up, 143 we were terminated.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from types import FrameType
from typing import BinaryIO, NoReturn

SERVER_DIED, TIME_IS_UP = 75, 124
PATIENCE = 3.0  # seconds without a server: it may be starting


def server_runs(prefix: str) -> bool:
    """Whether a server works for this prefix: its folder is named after the prefix's device and inode."""
    status = os.stat(prefix)
    folder = f"server-{status.st_dev:x}-{status.st_ino:x}"
    for process in Path("/proc").glob("[0-9]*"):
        try:
            name = (process / "comm").read_text()
            if name.startswith("wineserver") and Path(os.readlink(process / "cwd")).name == folder:
                return True
        except OSError:
            continue  # it has ended meanwhile, or is a zombie
    return False


def end_programs(prefix: str) -> None:
    """Kill the unreachable services that the dead server left."""
    mark = f"WINEPREFIX={prefix}".encode()
    for process in Path("/proc").glob("[0-9]*"):
        try:
            name = (process / "comm").read_text().strip()
            if name.endswith(".exe") and mark in (process / "environ").read_bytes().split(b"\0"):
                os.kill(int(process.name), signal.SIGKILL)
        except OSError:
            continue


def copy(source: BinaryIO) -> None:
    """Forward the program's output at once."""
    while data := os.read(source.fileno(), 65536):
        sys.stdout.buffer.write(data)
        sys.stdout.buffer.flush()


def kill(program: subprocess.Popen[bytes]) -> None:
    """End it and what it started; also when only threads are left of it."""
    try:
        os.killpg(program.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass
    try:
        program.wait(10)
    except subprocess.TimeoutExpired:
        print(f"tests/windows: process {program.pid} is left, it cannot be ended", flush=True)


def watch(program: subprocess.Popen[bytes], seconds: float, prefix: str) -> int:
    """Wait for its end, or for a failure that prevents it; the exit code."""
    end, seen = time.monotonic() + seconds, time.monotonic()
    while True:
        try:
            return program.wait(1.0)
        except subprocess.TimeoutExpired:
            now = time.monotonic()
        if server_runs(prefix):
            seen = now
        if now - seen > PATIENCE:
            return SERVER_DIED
        if now > end:
            return TIME_IS_UP


def main(seconds: float, log: Path, command: list[str]) -> int:
    """Run it; see the module."""
    prefix = os.environ["WINEPREFIX"]
    program = subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        start_new_session=True,
    )

    def terminated(number: int, frame: FrameType | None) -> NoReturn:
        kill(program)
        os._exit(128 + number)

    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        signal.signal(number, terminated)
    assert program.stdout is not None
    copier = threading.Thread(target=copy, args=(program.stdout,), daemon=True)
    copier.start()
    code = watch(program, seconds, prefix)
    if code in (SERVER_DIED, TIME_IS_UP) and program.poll() is None:
        kill(program)
    copier.join(5.0)  # a program that it started may hold the pipe
    if code == SERVER_DIED:
        end_programs(prefix)
        print(f"\ntests/windows: Wine's server ended while the program ran: {words(log)}", flush=True)
    elif code == TIME_IS_UP:
        print(f"\ntests/windows: not done after {seconds:g} s, ended; Wine's server was there", flush=True)
    return code if code >= 0 else 128 - code


def words(log: Path) -> str:
    """The last lines of the server's log."""
    try:
        return (log.read_text(errors="replace").strip().splitlines() or ["it said nothing"])[-1]
    except OSError as error:
        return str(error)


if __name__ == "__main__":
    sys.exit(main(float(sys.argv[1]), Path(sys.argv[2]), sys.argv[3:]))
