"""Gateways to a ROS graph for other programs: a rosbridge server and a Foxglove server on top of a node.

    with rosproto.gateway.Rosbridge(node, port=9090) as bridge:
        print(bridge.url)

Both share the robot's topics between clients (`SharedSubscriptions`), the access rules (`Access`) and the
limits for a client (`GatewayLimits`). Nothing is written to the graph unless `Access(write=...)` permits it.
A server of another protocol stands on `GatewayServer`, `GatewayState` and `WebSocketServer`.
"""

from __future__ import annotations

from rosproto.deprecation import former_names
from rosproto.gateway.access import Access, Refusal, Refused
from rosproto.gateway.client_channel import ClientChannel
from rosproto.gateway.client_limits import GatewayLimits
from rosproto.gateway.foxglove.server import Foxglove, FoxgloveStats
from rosproto.gateway.foxglove.server_state import ClientFacts
from rosproto.gateway.gateway_server import GatewayServer, GatewayState
from rosproto.gateway.handshake import HandshakeRules
from rosproto.gateway.local_topic import LocalTopic
from rosproto.gateway.message_event import MessageEvent, TopicDescription
from rosproto.gateway.outbox import Outbox
from rosproto.gateway.rosbridge.server import Rosbridge
from rosproto.gateway.shared_subscriptions import SharedSubscription, SharedSubscriptions
from rosproto.gateway.websocket_server import WebSocketServer

__all__ = [
    "Access",
    "ClientChannel",
    "ClientFacts",
    "Foxglove",
    "FoxgloveStats",
    "GatewayLimits",
    "GatewayServer",
    "GatewayState",
    "HandshakeRules",
    "LocalTopic",
    "MessageEvent",
    "Outbox",
    "Refusal",
    "Refused",
    "Rosbridge",
    "SharedSubscription",
    "SharedSubscriptions",
    "TopicDescription",
    "WebSocketServer",
]

__getattr__ = former_names(__name__, {"Tap": "SharedSubscription", "Taps": "SharedSubscriptions"})
