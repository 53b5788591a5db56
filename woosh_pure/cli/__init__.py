"""The `woosh` command. `main` owns its process: it alone prints, minds signals and decides the exit code."""

from __future__ import annotations

from .entry import main

__all__ = ["main"]
