"""Find the definition of a topic or service by class, name, or a peer's md5sum."""

from __future__ import annotations

__all__: list[str] = []
