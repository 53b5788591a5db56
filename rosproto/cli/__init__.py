"""The `rosproto` command. `main` owns its process: it alone prints, and its result is the exit code."""

from __future__ import annotations

from .entry import main

__all__ = ["main"]
