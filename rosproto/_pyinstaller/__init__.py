"""Hooks for PyInstaller, which finds this folder by the entry point `pyinstaller40: hook-dirs`.

Names load on first use here, and definitions are data files: PyInstaller sees neither by itself.
"""

from __future__ import annotations

from importlib.resources import files

__all__ = ["hook_directories"]


def hook_directories() -> list[str]:
    """Where the hooks are; called by PyInstaller."""
    return [str(files(__name__))]
