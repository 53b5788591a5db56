"""The one place that imports `foxglove-sdk`: late, and with an error that names the extra."""

from __future__ import annotations

import importlib
from typing import Any

__all__ = ["sdk", "websocket"]

MISSING = 'a Foxglove server needs the package foxglove-sdk: pip install ".[foxglove]"'


def sdk() -> Any:
    """The module `foxglove`.

    Raises:
        ImportError: It is not installed, or too old.
    """
    try:
        module = importlib.import_module("foxglove")
    except ImportError as problem:
        raise ImportError(MISSING, name="foxglove") from problem
    if not hasattr(module, "SinkChannelFilter") or not hasattr(module, "Context"):
        raise ImportError(f"{MISSING} (what is installed is too old)", name="foxglove")
    return module


def websocket() -> Any:
    """The module `foxglove.websocket`."""
    sdk()
    return importlib.import_module("foxglove.websocket")
