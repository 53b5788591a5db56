"""What the actions of an order do: those of the standard, the maps, and actions of the user's own."""

from __future__ import annotations

from rosproto.late import late_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from woosh_pure.fleet.actions.task import Task

__all__ = ["Task"]

__getattr__ = late_names(
    __name__,
    {
        "Task": "task",
    },
)


def __dir__() -> list[str]:
    return sorted(__all__)
