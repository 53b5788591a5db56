"""The node in its graph: the master and other nodes, asked and answered; what is registered, and kept so."""

from __future__ import annotations

__all__: list[str] = []
