"""Gateways to a ROS graph for other programs: a rosbridge server and a Foxglove server on top of a node.

    with rosproto.gateway.Rosbridge(node, port=9090) as bridge:
        print(bridge.url)

Both share the robot's topics between clients (`SharedSubscriptions`), the access rules (`Access`) and the
limits for a client (`GatewayLimits`). Nothing is written to the graph unless `Access(write=...)` permits it.
"""

from __future__ import annotations

from rosproto.deprecation import former_names
from rosproto.gateway.access import Access, Refusal
from rosproto.gateway.client_limits import GatewayLimits
from rosproto.gateway.foxglove.server import Foxglove, FoxgloveStats
from rosproto.gateway.foxglove.server_state import ClientFacts
from rosproto.gateway.local_topic import LocalTopic
from rosproto.gateway.message_event import MessageEvent, TopicDescription
from rosproto.gateway.outbox import Outbox
from rosproto.gateway.rosbridge.server import Rosbridge
from rosproto.gateway.shared_subscriptions import SharedSubscription, SharedSubscriptions

__all__ = [
    "Access",
    "ClientFacts",
    "Foxglove",
    "FoxgloveStats",
    "GatewayLimits",
    "LocalTopic",
    "MessageEvent",
    "Outbox",
    "Refusal",
    "Rosbridge",
    "SharedSubscription",
    "SharedSubscriptions",
    "TopicDescription",
]

__getattr__ = former_names(__name__, {"Tap": "SharedSubscription", "Taps": "SharedSubscriptions"})
