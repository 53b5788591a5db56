"""The time of a node: this computer's, or that of /clock."""

from __future__ import annotations

__all__: list[str] = []
