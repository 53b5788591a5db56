"""The parameter server, and what is kept of it here."""

from __future__ import annotations

__all__: list[str] = []
