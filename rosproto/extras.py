"""Libraries of extras, imported when they are first used."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

__all__ = ["optional_module"]


def optional_module(name: str, missing: Exception) -> ModuleType:
    """Import a module of an optional library.

    Raises:
        missing: It cannot be imported; the text of this error says what to install.
    """
    try:
        return import_module(name)
    except ImportError as problem:
        raise missing from problem
