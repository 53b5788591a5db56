"""The optional library, imported with its first use, and its errors."""

from __future__ import annotations

import importlib
import struct
from typing import Any

from rosproto.errors import BagError

__all__ = ["library", "misfits"]


def library(module: str) -> Any:
    """One of the library's modules: "writer", "reader", "stream_reader".

    Raises:
        BagError: It is not installed; names the extra.
    """
    try:
        return importlib.import_module(f"mcap.{module}")
    except ImportError as problem:
        raise BagError('MCAP needs the package mcap: pip install ".[mcap]"') from problem


def misfits() -> tuple[type[Exception], ...]:
    """The errors it raises for a file that is not sound MCAP."""
    error: type[Exception] = library("exceptions").McapError
    return error, ValueError, KeyError, OverflowError, EOFError, struct.error, RuntimeError
