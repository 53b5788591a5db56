"""Tests of a part that needs an extra are skipped where it is not installed, with the command that installs it."""

from __future__ import annotations

import pytest

__all__ = ["needs"]

_MODULES = {
    "api": ("websockets",),
    "bridge": ("websockets", "cbor2"),
    "cli": ("PIL",),
    "fleet": ("paho.mqtt.client",),
    "foxglove": ("websockets",),
    "mcp": ("mcp", "PIL"),
    "web": ("fastapi", "uvicorn", "websockets"),
}


def needs(extra: str) -> None:
    """Skip the running test, or the module that is being collected, where a library of the extra is missing."""
    for module in _MODULES[extra]:
        pytest.importorskip(module, reason=f'{module} is not installed: pip install ".[{extra}]"')
