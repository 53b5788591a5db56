"""Hooks for PyInstaller, which finds this folder by the entry point `pyinstaller40: hook-dirs`.

PyInstaller cannot see imports made on first use, nor the definitions, which are data files.
"""

from __future__ import annotations

from importlib.resources import files

__all__ = ["hook_directories"]


def hook_directories() -> list[str]:
    """The folder of the hooks; called by PyInstaller."""
    return [str(files(__name__))]
