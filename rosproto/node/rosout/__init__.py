"""/rosout: log records of this node as messages, those of others as records, and the levels of loggers."""

from __future__ import annotations

__all__: list[str] = []
