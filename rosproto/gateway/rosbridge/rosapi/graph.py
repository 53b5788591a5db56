"""The graph for /rosapi: topics, nodes, services and action servers that `Access` does not hide."""

from __future__ import annotations

from collections.abc import Mapping
from urllib.parse import urlsplit

from rosproto.errors import MasterError, RosError
from rosproto.gateway.access import ACTION_PARTS, Access
from rosproto.gateway.topic_type import ServiceTypes
from rosproto.node import Node
from rosproto.node.graph.master_client import SystemState
from rosproto.transport.deadline import Deadline


class RosapiError(RosError):
    """A call of /rosapi is refused or failed; the text is a sentence for the client."""


class VisibleGraph:
    """The part of the master's graph that one gateway shows.

    Args:
        node: Calls the master.
        access: Which names may be shown.
        own: Types of the services that the gateway answers itself, by name; they are listed as this node's.
    """

    def __init__(self, node: Node, access: Access, own: Mapping[str, str]) -> None:
        self._node = node
        self._access = access
        self._own = own
        self._types = ServiceTypes(node)

    def topics(self, deadline: Deadline) -> dict[str, str]:
        """topic -> type of every topic that is published or subscribed; "" for an unknown type."""
        master = self._node.master
        types = master.get_topic_types(timeout=deadline.remaining())
        state = master.get_system_state(timeout=deadline.remaining())
        names = self._access.visible("topic", {*state.publishers, *state.subscribers})
        return {name: "" if types.get(name, "*") == "*" else types[name] for name in names}

    def topics_for_type(self, type_name: str, deadline: Deadline) -> list[str]:
        return [name for name, kind in self.topics(deadline).items() if kind == type_name]

    def publishers(self, topic: str, deadline: Deadline) -> list[str]:
        return self._nodes_of(topic, self._state(deadline).publishers)

    def subscribers(self, topic: str, deadline: Deadline) -> list[str]:
        return self._nodes_of(topic, self._state(deadline).subscribers)

    def _nodes_of(self, topic: str, table: dict[str, list[str]]) -> list[str]:
        if not self._access.shows("topic", topic):
            return []
        return [node for node in table.get(topic, []) if self._access.shows("node", node)]

    def nodes(self, deadline: Deadline) -> list[str]:
        return self._access.visible("node", self._state(deadline).nodes)

    def node_details(self, node: str, deadline: Deadline) -> tuple[list[str], list[str], list[str]]:
        """The topics a node subscribes to and publishes, and its services."""
        if not self._access.shows("node", node):
            return [], [], []
        state = self._state(deadline)
        subscribes, publishes, serves = (
            [name for name, nodes in table.items() if node in nodes]
            for table in (state.subscribers, state.publishers, state.services)
        )
        if node == self._node.name:
            serves += self._own
        visible = self._access.visible
        return visible("topic", subscribes), visible("topic", publishes), visible("service", serves)

    def services(self, deadline: Deadline) -> list[str]:
        return sorted({*self._own, *self._access.visible("service", self._state(deadline).services)})

    def service_type(self, service: str, deadline: Deadline) -> str:
        if service in self._own:
            return self._own[service]
        if not self._access.shows("service", service):
            return ""
        try:
            uri = self._node.master.lookup_service(service, timeout=deadline.remaining())
        except RosError:
            return ""
        return self._types.header(service, uri, deadline).get("type", "")

    def services_for_type(self, type_name: str, deadline: Deadline) -> list[str]:
        """The services of this type. Probes unknown providers, as many as the deadline allows."""
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
        return [node for node in dict.fromkeys(found) if self._access.shows("node", node)]

    def service_node(self, service: str, deadline: Deadline) -> str:
        """The node that provides a service, or ""."""
        if service in self._own:
            return self._node.name
        if not self._access.shows("service", service):
            return ""
        found = [n for n in self._state(deadline).services.get(service, []) if self._access.shows("node", n)]
        return found[0] if found else ""

    def service_host(self, service: str, deadline: Deadline) -> str:
        """The host of a service's provider, or ""."""
        if service in self._own:
            return self._node.tcpros_address[0]
        if not self._access.shows("service", service):
            return ""
        try:
            uri = self._node.master.lookup_service(service, timeout=deadline.remaining())
            return urlsplit(uri).hostname or ""
        except (MasterError, ValueError):
            return ""

    def action_servers(self, deadline: Deadline) -> list[str]:
        shown = action_servers(self.topics(deadline))
        return [name for name in shown if self._access.shows("action", name)]

    def _state(self, deadline: Deadline) -> SystemState:
        return self._node.master.get_system_state(timeout=deadline.remaining())


def action_servers(topics: Mapping[str, str] | list[str]) -> list[str]:
    """The names that have all five topics of an action, sorted."""
    parts: dict[str, set[str]] = {}
    for topic in topics:
        name, _, part = topic.rpartition("/")
        if name and part in ACTION_PARTS:
            parts.setdefault(name, set()).add(part)
    return sorted(name for name, found in parts.items() if found == ACTION_PARTS)
