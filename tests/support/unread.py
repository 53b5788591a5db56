"""Unread outputs: a full pipe, a terminal stopped by Ctrl-S."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

__all__ = ["full_pipe", "unread_command"]

ROOT = Path(__file__).resolve().parents[2]


@contextmanager
def full_pipe() -> Iterator[int]:
    """Yield the write descriptor of a full pipe."""
    read, write = os.pipe()
    try:
        os.set_blocking(write, False)
        try:
            while os.write(write, b"x" * 65536):
                pass
        except BlockingIOError:
            pass
        try:
            while os.write(write, b"x"):
                pass
        except BlockingIOError:
            pass
        os.set_blocking(write, True)
        yield write
    finally:
        os.close(read)
        os.close(write)


@contextmanager
def unread_command(*words: str, full: str = "stdout stderr") -> Iterator[subprocess.Popen[bytes]]:
    """Run `woosh ...` or `rosproto ...` with unread outputs, both or the one in `full`."""
    module = {"woosh": "woosh_pure", "rosproto": "rosproto"}[words[0]]
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("ROS_", "LC_", "PYTHONUNBUF"))}
    with full_pipe() as pipe:
        process = subprocess.Popen(
            [sys.executable, "-m", module, *words[1:]],
            stdin=subprocess.DEVNULL,
            stdout=pipe if "stdout" in full else subprocess.DEVNULL,
            stderr=pipe if "stderr" in full else subprocess.DEVNULL,
            env={**environment, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "utf-8"},
        )
        try:
            yield process
        finally:
            process.kill()
            process.wait(10)
