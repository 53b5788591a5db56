"""ONE table of every topic, service and action of the chassis. Everything above and beside it reads these
rows.
"""

from __future__ import annotations

from woosh_pure.interface.schema import Flow, Row
from woosh_pure.interface.table import (
    PAGE_ALIASES,
    ROBOT_NODES,
    ROWS,
    actions,
    feeds,
    find,
    row,
    services,
    topics,
)

__all__ = [
    "PAGE_ALIASES",
    "ROBOT_NODES",
    "ROWS",
    "Flow",
    "Row",
    "actions",
    "feeds",
    "find",
    "row",
    "services",
    "topics",
]
