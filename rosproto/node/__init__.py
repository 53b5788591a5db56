"""Node, publisher, subscriber, service, parameters, rosout, clock: one participant of a ROS 1 graph.

Start with `Node`. Services, parameters and /rosout are imported with their first use.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosproto.node.events import Event, EventKind
from rosproto.node.graph.master_client import MasterClient, SystemState
from rosproto.node.incoming.subscriber import Subscriber
from rosproto.node.node import Node
from rosproto.node.outgoing.publisher import Publisher
from rosproto.node.time.clock import NodeClock, Rate, Timer, TimerEvent

if TYPE_CHECKING:
    from rosproto.node.graph.slave_client import NodeClient
    from rosproto.node.params.parameters import Parameters, UnknownParameter
    from rosproto.node.services.client import ServiceClient
    from rosproto.node.services.server import ServiceServer
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
    "NodeClient": "rosproto.node.graph.slave_client",
    "NodeStats": "rosproto.node.stats",
    "Parameters": "rosproto.node.params.parameters",
    "ServiceClient": "rosproto.node.services.client",
    "ServiceServer": "rosproto.node.services.server",
    "UnknownParameter": "rosproto.node.params.parameters",
}


def __getattr__(name: str) -> object:
    """Import what is heavy or rarely used when it is first asked for (PEP 562)."""
    if name not in _LATE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    value: object = getattr(import_module(_LATE[name]), name)
    globals()[name] = value
    return value
