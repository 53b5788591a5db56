"""What a fleet manager sends: read, checked, and as values. Pure."""

from __future__ import annotations

from woosh_pure.fleet.messages.parsing import parse, read_instant_actions, read_order

__all__ = ["parse", "read_instant_actions", "read_order"]
