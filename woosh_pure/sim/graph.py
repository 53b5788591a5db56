"""The ROS graph of the simulated chassis: nodes with the real names, and every row of the table on them."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import rosproto
from rosproto.node.revisions import NoRevisions

from .. import interface
from ..firmware import Firmware
from ..interface import Row
from .revised import revised_action, revised_listener, revised_service

if TYPE_CHECKING:
    from .serve import Server

__all__ = ["UNKNOWN_TYPES", "Graph"]

UNKNOWN_TYPES = frozenset({"woosh_msgs/VolumeCtl"})
"""Types whose definition is not published: their rows cannot be simulated."""

_RI = "/ros_interface"


class Graph:
    """Nodes, publishers, subscribers, services and action servers, by name.

    Attributes:
        nodes: By name.
        publishers: (node, topic) to publisher.
        lights: Last LED message of each strip, by topic.
        heard: Last message on each written topic.
    """

    def __init__(
        self,
        master_uri: str,
        server: Server,
        *,
        host: str | None,
        full: bool,
        latch_status: bool,
        firmware: Firmware,
    ) -> None:
        self._uri, self._host, self._full = master_uri, host, full
        self._firmware = firmware
        self._latch_status = latch_status
        self._server = server
        self.nodes: dict[str, rosproto.Node] = {}
        self.publishers: dict[tuple[str, str], rosproto.Publisher] = {}
        self.heard: dict[str, Any] = {}
        self._keep: list[Any] = []
        self.internal_clients: dict[str, rosproto.ActionClient] = {}

    def node(self, name: str) -> rosproto.Node:
        """The node of that name, made on first use.

        Its links are real sockets also within this process, and it refuses every definition that is not its
        own, as the real one does: to agree is the client's part.
        """
        if name not in self.nodes:
            node = rosproto.Node(name, master_uri=self._uri, host=self._host, intraprocess=False)
            node.revisions = NoRevisions()
            self.nodes[name] = node
        return self.nodes[name]

    def build(self) -> None:
        """Bring everything up."""
        for row in interface.ROWS:
            if row.type in UNKNOWN_TYPES:
                continue
            builder = {"read": self._publish, "write": self._listen, "call": self._serve, "act": self._act}
            builder[row.flow](row)

    def _publish(self, row: Row) -> None:
        latch = bool(row.latched) or (row.name == "/robot_status" and self._latch_status)
        providers = row.providers if self._full else row.providers[:1]
        type_ = self._firmware.message_class(row.type)
        for name in providers:
            publisher = self.node(name).publisher(row.name, type_, latch=latch, queue_size=10)
            self.publishers[name, row.name] = publisher
        if self._full:
            for name in row.listeners:
                self._keep.append(self.node(name).subscriber(row.name, type_, callback=_ignore, queue_size=1))

    def _listen(self, row: Row) -> None:
        providers = row.providers if self._full else row.providers[-1:]
        for index, name in enumerate(providers):
            obey = self._server.topics.get(row.name, _ignore) if index == 0 else _ignore
            callback = revised_listener(self._firmware, row.type, partial(self._hear, row.name, obey))
            type_ = self._firmware.message_class(row.type)
            self._keep.append(self.node(name).subscriber(row.name, type_, callback=callback, queue_size=10))

    def _hear(self, topic: str, obey: Callable[[Any], object], message: Any) -> None:
        self.heard[topic] = message
        obey(message)

    def _serve(self, row: Row) -> None:
        node = self.node(row.providers[0])
        handler = revised_service(self._firmware, row.type, self._server.services[row.name])
        self._keep.append(node.service_server(row.name, self._firmware.service_class(row.type), handler))

    def _act(self, row: Row) -> None:
        handler = self._server.actions.get(row.name) or partial(self._server.accessory, row.type)
        node = self.node(row.providers[0])
        type_ = self._firmware.message_class(f"{row.type}Action")
        revised = revised_action(self._firmware, row.type, handler)
        self._keep.append(rosproto.ActionServer(node, row.name, type_, revised))
        if self._full:
            self.client(row.name)

    def client(self, name: str) -> rosproto.ActionClient:
        """The client /ros_interface keeps on an action server: the robot itself competes with us."""
        if name not in self.internal_clients:
            row = interface.row(name)
            type_ = self._firmware.message_class(f"{row.type}Action")
            self.internal_clients[name] = rosproto.ActionClient(self.node(_RI), name, type_)
        return self.internal_clients[name]

    def first(self, topic: str) -> rosproto.Publisher | None:
        """The publisher that carries a topic's content (the first provider's)."""
        row = interface.row(topic)
        return self.publishers.get((row.providers[0], topic))

    def close(self) -> None:
        """Close all nodes."""
        for node in self.nodes.values():
            node.close()


def _ignore(message: Any) -> None:
    """Subscribed because the real node is; nothing depends on it."""
