"""A Foxglove server over a node: the graph, live, in Foxglove and Lichtblick.

`foxglove-sdk` (extra `foxglove`) speaks the protocol: one of its servers for each client, on a port that only
this process connects to. A reverse proxy in front of them (`proxy`) decides who may connect.
"""

from __future__ import annotations

from rosproto.gateway.foxglove.local_topic import LocalTopic
from rosproto.gateway.foxglove.server import Foxglove, FoxgloveStats

__all__ = ["Foxglove", "FoxgloveStats", "LocalTopic"]
