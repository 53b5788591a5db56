"""Runs the `woosh` command in a separate process, and checks its pictures."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

__all__ = ["has", "until_it_ends", "woosh_process"]

ROOT = Path(__file__).resolve().parents[2]


def has(pixels: np.ndarray, color: tuple[int, int, int]) -> bool:
    """True if a picture has a pixel of that colour."""
    return bool((pixels == color).all(axis=2).any())


def woosh_process(*words: str) -> subprocess.Popen[str]:
    """Start the command in a separate process."""
    return subprocess.Popen(
        [sys.executable, "-u", "-m", "woosh_pure", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
        env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "utf-8"},
    )


def until_it_ends(process: subprocess.Popen[str], happen: Callable[[int], object]) -> str:
    """Call `happen` repeatedly until the command has ended; return its stdout."""
    for turn in range(300):
        if process.poll() is not None:
            break
        happen(turn)
        time.sleep(0.1)
    return process.communicate(timeout=20)[0]
