"""`ServedGraph`: publishers, subscribers, services and action servers for rows of the interface table."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from functools import partial
from typing import Any, Protocol

import rosproto
from rosproto.action import ServerGoal
from rosproto.codec import DynamicMessage, ServiceType
from woosh_pure import interface
from woosh_pure.interface.schema import Row
from woosh_pure.values.messages import message_type, service_type


class Handlers(Protocol):
    """What is done with what the graph is sent, by the name of the row.

    A service returns the fields of its response; an action ends the goal that it is given; its check says why
    a goal is rejected.
    """

    @property
    def topics(self) -> Mapping[str, Callable[[DynamicMessage], object]]: ...

    @property
    def services(self) -> Mapping[str, Callable[[DynamicMessage], dict[str, object]]]: ...

    @property
    def actions(self) -> Mapping[str, Callable[[Any], object]]: ...

    @property
    def checks(self) -> Mapping[str, Callable[[Any], str | None]]: ...


class ServedGraph:
    """The nodes of a chassis and what they have; a subclass may add to each row.

    Attributes:
        nodes: By name.
        publishers, subscribers: (node, topic) to publisher or subscriber.
    """

    def __init__(self, handlers: Handlers, new_node: Callable[[str], rosproto.Node]) -> None:
        self._handlers, self._new_node = handlers, new_node
        self.nodes: dict[str, rosproto.Node] = {}
        self.publishers: dict[tuple[str, str], rosproto.Publisher] = {}
        self.subscribers: dict[tuple[str, str], rosproto.Subscriber] = {}
        self._keep: list[object] = []
        self._building: ExitStack | None = None

    def node(self, name: str) -> rosproto.Node:
        """The node with a name, created on first use."""
        if name not in self.nodes:
            node = self._new_node(name)
            if self._building is not None:
                self._building.enter_context(node.batch())
            self.nodes[name] = node
        return self.nodes[name]

    def build(self, rows: Iterable[Row]) -> None:
        """Create all nodes and their parts."""
        builder = {"read": self.publish, "write": self.listen, "call": self._serve, "act": self._act}
        with ExitStack() as stack:
            stack.callback(setattr, self, "_building", None)
            self._building = stack  # each node registers what it has with one request, at the end
            for row in rows:
                builder[row.flow](row)
            self._add_more()

    def _add_more(self) -> None:
        """For subclasses: add what is not in the rows."""

    def _class_of(self, row: Row) -> type[DynamicMessage]:
        return message_type(row.type)

    def publish(self, row: Row) -> None:
        """Publish a topic by its first provider."""
        name, latch = row.providers[0], bool(row.latched)
        publisher = self.node(name).publisher(row.name, self._class_of(row), latch=latch, queue_size=10)
        self.publishers[name, row.name] = publisher

    def listen(self, row: Row) -> None:
        """Subscribe to a topic by its first provider, whose messages are obeyed."""
        self._subscribe(row, row.providers[0], self._handlers.topics.get(row.name, ignore))

    def _subscribe(self, row: Row, node: str, obey: Callable[[DynamicMessage], object]) -> None:
        receive, type_ = partial(self._receive, row, obey), self._class_of(row)
        made = self.node(node).subscriber(row.name, type_, callback=receive, queue_size=10)
        self.subscribers[node, row.name] = made
        self._keep.append(made)

    def _receive(self, row: Row, obey: Callable[[DynamicMessage], object], message: DynamicMessage) -> None:
        obey(message)

    def _service(self, row: Row) -> tuple[type[ServiceType], Callable[[DynamicMessage], DynamicMessage]]:
        handler, type_ = self._handlers.services[row.name], service_type(row.type)
        return type_, lambda request: type_._response_class(**handler(request))

    def _serve(self, row: Row) -> None:
        self._keep.append(self.node(row.providers[0]).service_server(row.name, *self._service(row)))

    def _action(self, row: Row) -> tuple[type[DynamicMessage], Callable[[ServerGoal], object]]:
        return message_type(f"{row.type}Action"), self._handlers.actions[row.name]

    def _act(self, row: Row) -> None:
        node, check = self.node(row.providers[0]), self._handlers.checks.get(row.name)
        self._keep.append(rosproto.ActionServer(node, row.name, *self._action(row), check=check))

    def first(self, topic: str) -> rosproto.Publisher | None:
        """The publisher of a topic's content (that of the first provider)."""
        return self.publishers.get((interface.row(topic).providers[0], topic))

    def is_heard(self, publisher: rosproto.Publisher) -> bool:
        """Whether anybody but these nodes, which ignore what is measured, is connected."""
        return any(name not in self.nodes for name in publisher.subscribers)

    def close(self) -> None:
        """Close all nodes."""
        for node in self.nodes.values():
            node.close()


def ignore(message: DynamicMessage) -> None:
    """Callback for topics without effect."""
