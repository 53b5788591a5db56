"""Node, publisher, subscriber, service, parameters, rosout, clock: one participant of a ROS 1 graph.

Start with `Node`.
"""

from __future__ import annotations

from rosproto.deprecation import former_names
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
from rosproto.node.stats import ConnectedLink, LinkStats, NodeStats

__all__ = [
    "Cancellation",
    "ConnectedLink",
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

__getattr__ = former_names(__name__, {"NoRevisions": "OwnDefinitionsOnly", "Unfit": "UnconvertibleMessage"})
