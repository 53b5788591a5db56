"""What a fleet manager sends, read and checked, and the header that every message begins with. Pure."""

from __future__ import annotations

from rosproto.late import late_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from woosh_pure.fleet.messages.header import Headers
    from woosh_pure.fleet.messages.parsing import (
        InstantActions,
        Invalid,
        Order,
        parse,
        read_instant_actions,
        read_order,
    )

__all__ = ["Headers", "InstantActions", "Invalid", "Order", "parse", "read_instant_actions", "read_order"]

__getattr__ = late_names(
    __name__,
    {
        "Headers": "header",
        "InstantActions": "parsing",
        "Invalid": "parsing",
        "Order": "parsing",
        "parse": "parsing",
        "read_instant_actions": "parsing",
        "read_order": "parsing",
    },
)


def __dir__() -> list[str]:
    return sorted(__all__)
