"""The live connection of the page: what it shows, and driving with a dead-man switch."""

from __future__ import annotations

__all__: list[str] = []
