"""Receives topics: from a publisher's connection to the program's callback."""

from __future__ import annotations

__all__: list[str] = []
