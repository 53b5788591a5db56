"""Published topics: publishers, encoding, and the links to subscribers."""

from __future__ import annotations

__all__: list[str] = []
