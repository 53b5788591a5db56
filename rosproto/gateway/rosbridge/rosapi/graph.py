"""The graph for web clients: topics, nodes, services and action servers that are not hidden."""

from __future__ import annotations

from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from rosproto.errors import MasterError
from rosproto.gateway.rosbridge.rosapi.service_types import ServiceTypes
from rosproto.transport.deadline import Deadline

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosproto.gateway.rosbridge.rosapi.visible import Visible
    from rosproto.node import Node
    from rosproto.node.graph.master_client import SystemState

__all__ = ["ACTION_PARTS", "VisibleGraph", "action_servers"]

ACTION_PARTS = frozenset(("cancel", "feedback", "goal", "result", "status"))


class VisibleGraph:
    """The master's graph, as far as one gateway shows it.

    Args:
        node: Asks the master.
        visible: Which names may be shown.
        own: Services that the gateway answers itself, with their types; they are listed as this node's.
    """

    def __init__(self, node: Node, visible: Visible, own: Mapping[str, str]) -> None:
        self._node = node
        self._visible = visible
        self._own = own
        self._types = ServiceTypes(node)

    def topics(self, deadline: Deadline) -> dict[str, str]:
        """topic -> type of every topic that is published or subscribed; "" for an unknown type."""
        master = self._node.master
        types = master.get_topic_types(timeout=deadline.remaining())
        state = master.get_system_state(timeout=deadline.remaining())
        names = self._visible.only("topic", {*state.publishers, *state.subscribers})
        return {name: "" if types.get(name, "*") == "*" else types[name] for name in names}

    def topics_for_type(self, type_name: str, deadline: Deadline) -> list[str]:
        return [name for name, kind in self.topics(deadline).items() if kind == type_name]

    def publishers(self, topic: str, deadline: Deadline) -> list[str]:
        return self._nodes_of(topic, self._state(deadline).publishers)

    def subscribers(self, topic: str, deadline: Deadline) -> list[str]:
        return self._nodes_of(topic, self._state(deadline).subscribers)

    def _nodes_of(self, topic: str, table: dict[str, list[str]]) -> list[str]:
        if not self._visible.shows("topic", topic):
            return []
        return [node for node in table.get(topic, []) if self._visible.shows("node", node)]

    def nodes(self, deadline: Deadline) -> list[str]:
        return self._visible.only("node", self._state(deadline).nodes)

    def node_details(self, node: str, deadline: Deadline) -> tuple[list[str], list[str], list[str]]:
        """The topics a node subscribes to and publishes, and its services."""
        if not self._visible.shows("node", node):
            return [], [], []
        state = self._state(deadline)
        subscribes, publishes, serves = (
            [name for name, nodes in table.items() if node in nodes]
            for table in (state.subscribers, state.publishers, state.services)
        )
        if node == self._node.name:
            serves += self._own
        only = self._visible.only
        return only("topic", subscribes), only("topic", publishes), only("service", serves)

    def services(self, deadline: Deadline) -> list[str]:
        return sorted({*self._own, *self._visible.only("service", self._state(deadline).services)})

    def service_type(self, service: str, deadline: Deadline) -> str:
        if service in self._own:
            return self._own[service]
        return self._types.of(service, deadline) if self._visible.shows("service", service) else ""

    def services_for_type(self, type_name: str, deadline: Deadline) -> list[str]:
        """The services of this type. Asks every provider not known yet, as many as there is time for."""
        return [
            name
            for name in self.services(deadline)
            if not deadline.expired and self.service_type(name, deadline) == type_name
        ]

    def service_providers(self, type_name: str, deadline: Deadline) -> list[str]:
        """Nodes that provide a service of this type."""
        table = self._state(deadline).services
        found = [
            node
            for service in self.services_for_type(type_name, deadline)
            for node in ([self._node.name] if service in self._own else table.get(service, []))
        ]
        return [node for node in dict.fromkeys(found) if self._visible.shows("node", node)]

    def service_node(self, service: str, deadline: Deadline) -> str:
        """The node that provides a service; "" when there is none."""
        if service in self._own:
            return self._node.name
        if not self._visible.shows("service", service):
            return ""
        found = [n for n in self._state(deadline).services.get(service, []) if self._visible.shows("node", n)]
        return found[0] if found else ""

    def service_host(self, service: str, deadline: Deadline) -> str:
        """The host of a service; "" when nobody provides it."""
        if service in self._own:
            return self._node.tcpros_address[0]
        if not self._visible.shows("service", service):
            return ""
        try:
            uri = self._node.master.lookup_service(service, timeout=deadline.remaining())
        except MasterError:
            return ""
        try:
            return urlsplit(uri).hostname or ""
        except ValueError:
            return ""

    def action_servers(self, deadline: Deadline) -> list[str]:
        shown = action_servers(self.topics(deadline))
        return [name for name in shown if self._visible.shows("action", name)]

    def _state(self, deadline: Deadline) -> SystemState:
        return self._node.master.get_system_state(timeout=deadline.remaining())


def action_servers(topics: Mapping[str, str] | list[str]) -> list[str]:
    """The names that have all five topics of an action below them, sorted."""
    parts: dict[str, set[str]] = {}
    for topic in topics:
        name, _, part = topic.rpartition("/")
        if name and part in ACTION_PARTS:
            parts.setdefault(name, set()).add(part)
    return sorted(name for name, found in parts.items() if found == ACTION_PARTS)
