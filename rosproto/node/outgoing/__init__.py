"""Topics that are published: from the program's message to each subscriber's connection."""

from __future__ import annotations

__all__: list[str] = []
