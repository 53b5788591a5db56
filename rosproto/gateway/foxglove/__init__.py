"""A Foxglove server over a node: the graph, live, in Foxglove and Lichtblick.

The protocol is spoken by `foxglove-sdk` (extra `foxglove`), one server of it for each client, on a port
that only this process reaches for; what stands in front of them (`door`) decides who comes in.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosproto.late import late_names

if TYPE_CHECKING:
    from rosproto.gateway.foxglove.local_topic import LocalTopic
    from rosproto.gateway.foxglove.server import Foxglove, FoxgloveStats

__all__ = ["Foxglove", "FoxgloveStats", "LocalTopic"]

__getattr__ = late_names(
    __name__, {"Foxglove": "server", "FoxgloveStats": "server", "LocalTopic": "local_topic"}
)
