"""Debian's mosquitto as the broker of a test, on a free port of 127.0.0.1."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.support.ports import unused_port

__all__ = ["Mosquitto", "mosquitto"]


class Mosquitto:
    """One broker; `kill` and `start` may be repeated, the port stays."""

    def __init__(self, program: str, folder: Path, options: str = "") -> None:
        self.program, self.port = program, unused_port()
        self.config = folder / "mosquitto.conf"
        user = (
            "user root\n" if os.name == "posix" and os.geteuid() == 0 else ""
        )  # else it cannot read our files
        listener = f"listener {self.port} 127.0.0.1\npersistence false\n"
        self.config.write_text(f"{user}{listener}{options or 'allow_anonymous true'}\n")
        self.process: subprocess.Popen[bytes] | None = None

    @property
    def url(self) -> str:
        return f"mqtt://127.0.0.1:{self.port}"

    def start(self) -> None:
        self.process = subprocess.Popen(
            [self.program, "-c", str(self.config)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        deadline = time.monotonic() + 10.0
        while True:
            try:
                socket.create_connection(("127.0.0.1", self.port), 0.5).close()
                return
            except OSError:
                assert time.monotonic() < deadline, "mosquitto does not listen"
                assert self.process.poll() is None, "mosquitto has ended"
                time.sleep(0.02)

    def kill(self) -> None:
        """Kill the broker with SIGKILL."""
        if self.process is not None:
            self.process.send_signal(signal.SIGKILL)
            self.process.wait(10.0)
            self.process = None


@contextmanager
def mosquitto(folder: Path, options: str = "") -> Iterator[Mosquitto]:
    """A running broker; the test is skipped where mosquitto is not installed (Debian's package `mosquitto`)."""
    program = shutil.which("mosquitto") or shutil.which("mosquitto", path="/usr/sbin:/usr/local/sbin")
    if program is None:
        pytest.skip("mosquitto is not installed (looked for it in $PATH and /usr/sbin)")
    broker = Mosquitto(program, folder, options)
    broker.start()
    try:
        yield broker
    finally:
        broker.kill()
