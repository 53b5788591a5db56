"""One table of every topic, service and action of the chassis, which everything else reads."""

from __future__ import annotations

from woosh_pure.interface.listed import LISTED, ListedName
from woosh_pure.interface.rows import ROWS
from woosh_pure.interface.schema import Flow, Row
from woosh_pure.interface.table import (
    PAGE_ALIASES,
    ROBOT_NODES,
    actions,
    feeds,
    find,
    row,
    services,
    topics,
)

__all__ = [
    "LISTED",
    "PAGE_ALIASES",
    "ROBOT_NODES",
    "ROWS",
    "Flow",
    "ListedName",
    "Row",
    "actions",
    "feeds",
    "find",
    "row",
    "services",
    "topics",
]
