"""Node, publisher, subscriber, service, parameters, rosout, clock: one participant of a ROS 1 graph.

Start with `Node`.
"""

from __future__ import annotations

import warnings
from typing import Any

from rosproto.node.clock import NodeClock, Rate, Timer, TimerEvent
from rosproto.node.definitions.known_definitions import OwnDefinitionsOnly
from rosproto.node.definitions.md5sum_mismatch import UnconvertibleMessage, revised_type
from rosproto.node.definitions.topic_probe import probe_topic
from rosproto.node.definitions.topic_type import TopicType
from rosproto.node.events import Event, EventKind
from rosproto.node.graph.master_client import MasterClient, SystemState
from rosproto.node.graph.slave_client import NodeClient
from rosproto.node.incoming.fresh_messages import fresh_messages
from rosproto.node.incoming.local_nodes import LocalNodes
from rosproto.node.incoming.subscriber import Subscriber
from rosproto.node.node import Node
from rosproto.node.options import host_names
from rosproto.node.outgoing.publisher import Publisher
from rosproto.node.parameters import Parameters, UnknownParameter
from rosproto.node.services.client import ServiceClient
from rosproto.node.services.link import Cancellation, PreparedCall
from rosproto.node.services.probe import probe as probe_service
from rosproto.node.services.server import ServiceServer
from rosproto.node.stats import LinkStats, NodeStats

__all__ = [
    "Cancellation",
    "Event",
    "EventKind",
    "LinkStats",
    "LocalNodes",
    "MasterClient",
    "Node",
    "NodeClient",
    "NodeClock",
    "NodeStats",
    "OwnDefinitionsOnly",
    "Parameters",
    "PreparedCall",
    "Publisher",
    "Rate",
    "ServiceClient",
    "ServiceServer",
    "Subscriber",
    "SystemState",
    "Timer",
    "TimerEvent",
    "TopicType",
    "UnconvertibleMessage",
    "UnknownParameter",
    "fresh_messages",
    "host_names",
    "probe_service",
    "probe_topic",
    "revised_type",
]

_RENAMED: dict[str, Any] = {"NoRevisions": OwnDefinitionsOnly, "Unfit": UnconvertibleMessage}


def __getattr__(name: str) -> Any:
    """Old names, deprecated."""
    if name not in _RENAMED:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    new = _RENAMED[name]
    warnings.warn(f"{__name__}.{name} is {new.__name__} now", DeprecationWarning, stacklevel=2)
    return new
