"""What a fleet manager sends, read and checked, and the header that every message begins with. Pure."""

from __future__ import annotations

from woosh_pure.fleet.messages.elements import Action, Edge, InstantActions, Node, NodePosition, Order
from woosh_pure.fleet.messages.header import Headers, check_header, timestamp
from woosh_pure.fleet.messages.parsing import parse, read_edge, read_instant_actions, read_node, read_order
from woosh_pure.fleet.messages.schema import Invalid

__all__ = [
    "Action",
    "Edge",
    "Headers",
    "InstantActions",
    "Invalid",
    "Node",
    "NodePosition",
    "Order",
    "check_header",
    "parse",
    "read_edge",
    "read_instant_actions",
    "read_node",
    "read_order",
    "timestamp",
]
