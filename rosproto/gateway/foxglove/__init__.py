"""A server for Foxglove and Lichtblick over a node.

It speaks the published WebSocket protocol (`messages`) over the gateways' own server (`websocket_server`).
"""

from __future__ import annotations

from rosproto.gateway.foxglove.server import Foxglove, FoxgloveStats
from rosproto.gateway.local_topic import LocalTopic

__all__ = ["Foxglove", "FoxgloveStats", "LocalTopic"]
