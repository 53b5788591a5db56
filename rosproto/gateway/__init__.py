"""Gateways to a ROS graph for other programs: a rosbridge server and a Foxglove server on top of a node.

    with rosproto.gateway.Rosbridge(node, port=9090) as bridge:
        print(bridge.url)

Both share the robot's topics between clients (`Taps`), the access rules (`Access`) and the limits for a
client (`GatewayLimits`). Nothing is written to the graph unless `Access(write=...)` permits it.
"""

from __future__ import annotations

from rosproto.gateway.access import Access, Refusal
from rosproto.gateway.client_limits import GatewayLimits
from rosproto.gateway.foxglove.server import ClientFacts, Foxglove, FoxgloveStats
from rosproto.gateway.local_topic import LocalTopic
from rosproto.gateway.message_event import MessageEvent, TopicDescription
from rosproto.gateway.outbox import Outbox
from rosproto.gateway.rosbridge.server import Rosbridge
from rosproto.gateway.shared_subscriptions import Tap, Taps

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
    "Tap",
    "Taps",
    "TopicDescription",
]
