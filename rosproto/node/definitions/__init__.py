"""Which definition a topic or service has: by its class or name, or by a peer's md5sum."""

from __future__ import annotations

__all__: list[str] = []
