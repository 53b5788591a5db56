"""How busy this computer is, for limits that mean a quiet one."""

from __future__ import annotations

import os

__all__ = ["crowd"]


def crowd() -> float:
    """How many processes each processor serves: by so much everything takes longer here than on a quiet computer."""
    try:
        return max(1.0, os.getloadavg()[0] / (os.cpu_count() or 1))
    except (AttributeError, OSError):  # Windows has no such figure
        return 1.0
