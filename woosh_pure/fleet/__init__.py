"""A chassis as a vehicle of a fleet manager, by VDA 5050 over MQTT; `woosh vda5050` is its command.

Needs the extra `fleet`. Names load on first use.
"""

from __future__ import annotations

from rosproto.late import late_names

TYPE_CHECKING = False  # as in typing, which takes longer to load than all of this
if TYPE_CHECKING:
    from woosh_pure.fleet.actions.task import Task
    from woosh_pure.fleet.broker import Broker
    from woosh_pure.fleet.config import FleetConfig, VehicleConfig, load_config
    from woosh_pure.fleet.store import Store
    from woosh_pure.fleet.vehicle import Vehicle

__all__ = ["Broker", "FleetConfig", "Store", "Task", "Vehicle", "VehicleConfig", "load_config"]

__getattr__ = late_names(
    __name__,
    {
        "Broker": "broker",
        "FleetConfig": "config",
        "Store": "store",
        "Task": "actions.task",
        "Vehicle": "vehicle",
        "VehicleConfig": "config",
        "load_config": "config",
    },
)


def __dir__() -> list[str]:
    return sorted(__all__)
