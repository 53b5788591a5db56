"""The connections to the broker: one thread for all vehicles of a process, on paho-mqtt."""

from __future__ import annotations

from rosproto.late import late_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from woosh_pure.fleet.mqtt.broker import Broker
    from woosh_pure.fleet.mqtt.connection import BrokerConnection

__all__ = ["Broker", "BrokerConnection"]

__getattr__ = late_names(__name__, {"Broker": "broker", "BrokerConnection": "connection"})


def __dir__() -> list[str]:
    return sorted(__all__)
