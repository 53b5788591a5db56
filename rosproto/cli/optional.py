"""Packages that a command needs and an installation may lack."""

from __future__ import annotations

from typing import Any

from .connection import CommandError

__all__ = ["need"]


def need(module: str, package: str, extra: str) -> Any:
    """Import an optional package.

    Raises:
        CommandError: It is not installed; names the extra.
    """
    import importlib

    try:
        return importlib.import_module(module)
    except ImportError as problem:
        raise CommandError(f'this needs the package {package}: pip install ".[{extra}]"') from problem
