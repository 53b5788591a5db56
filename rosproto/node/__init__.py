"""Node, publisher, subscriber, service, parameters, rosout, clock: one participant of a ROS 1 graph.

Start with `Node`. Services, parameters and /rosout are imported with their first use.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosproto.node.clock import NodeClock, Rate, Timer, TimerEvent
from rosproto.node.events import Event, EventKind
from rosproto.node.master_client import MasterClient, SystemState
from rosproto.node.node import Node
from rosproto.node.publisher import Publisher
from rosproto.node.subscriber import Subscriber

if TYPE_CHECKING:
    from rosproto.node.parameters import Parameters, UnknownParameter
    from rosproto.node.service_client import ServiceClient
    from rosproto.node.service_server import ServiceServer
    from rosproto.node.slave_client import NodeClient
    from rosproto.node.stats import LinkStats, NodeStats

__all__ = [
    "Event",
    "EventKind",
    "LinkStats",
    "MasterClient",
    "Node",
    "NodeClient",
    "NodeClock",
    "NodeStats",
    "Parameters",
    "Publisher",
    "Rate",
    "ServiceClient",
    "ServiceServer",
    "Subscriber",
    "SystemState",
    "Timer",
    "TimerEvent",
    "UnknownParameter",
]

_LATE = {
    "LinkStats": "rosproto.node.stats",
    "NodeClient": "rosproto.node.slave_client",
    "NodeStats": "rosproto.node.stats",
    "Parameters": "rosproto.node.parameters",
    "ServiceClient": "rosproto.node.service_client",
    "ServiceServer": "rosproto.node.service_server",
    "UnknownParameter": "rosproto.node.parameters",
}


def __getattr__(name: str) -> object:
    """Import what is heavy or rarely used when it is first asked for (PEP 562)."""
    if name not in _LATE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    value: object = getattr(import_module(_LATE[name]), name)
    globals()[name] = value
    return value
