"""What a vehicle does with orders, updates and actions: a machine without clock, threads or network."""

from __future__ import annotations

from rosproto.late import late_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from woosh_pure.fleet.order.machine import OrderMachine

__all__ = ["OrderMachine"]

__getattr__ = late_names(
    __name__,
    {
        "OrderMachine": "machine",
    },
)


def __dir__() -> list[str]:
    return sorted(__all__)
