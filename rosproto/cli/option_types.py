"""Types of options for argparse: what is out of range is wrong use, told before anything is done."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

__all__ = ["count", "finite", "folder_exists", "natural", "port", "positive", "seconds"]


def finite(text: str) -> float:
    """A number that is not infinite and not NaN."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is not a finite number")
    return value


def positive(text: str) -> float:
    """A number above 0."""
    value = finite(text)
    if not value > 0.0:
        raise argparse.ArgumentTypeError(f"{text!r}: must be above 0")
    return value


def seconds(text: str) -> float:
    """A duration or a speed; 0 is one."""
    value = finite(text)
    if value < 0.0:
        raise argparse.ArgumentTypeError(f"{text!r}: must be 0 or more")
    return value


def natural(text: str) -> int:
    """A whole number, 0 or more."""
    return _whole(text, 0)


def count(text: str) -> int:
    """A whole number, 1 or more."""
    return _whole(text, 1)


def _whole(text: str, least: int) -> int:
    try:
        value = int(text)
    except ValueError:
        value = least - 1
    if value < least:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from {least}")
    return value


def port(text: str) -> int:
    """A TCP port; 0 lets the system choose."""
    if text.isascii() and text.isdigit() and int(text) <= 65535:
        return int(text)
    raise argparse.ArgumentTypeError(f"{text!r} is no port (0 to 65535)")


def folder_exists(text: str) -> Path:
    """A file to be written: told at once when its folder is missing, not after the work is done."""
    path = Path(text)
    if path.is_dir():
        raise argparse.ArgumentTypeError(f"{text} is a folder; give the name of a file")
    if not path.parent.is_dir():
        raise argparse.ArgumentTypeError(f"folder {path.parent} does not exist; make it first")
    return path
