"""Services, provided and called."""

from __future__ import annotations

__all__: list[str] = []
