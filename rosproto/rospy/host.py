"""The one node of a program, and what stands in for it before there is one."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from rosproto.node import Event, EventKind, MasterClient, Node, closing
from rosproto.node.publication import Publication
from rosproto.node.revisions import Revisions
from rosproto.protocol.limits import Limits

__all__ = ["Caller", "ProgramNode"]


class ProgramNode(Node):
    """A `Node` whose clock and /rosout are the program's, and whose end is the program's to do.

    Args:
        on_shutdown_request: Called with the reason when the master or a tool ends this node, in a thread of
            its own.
    """

    def __init__(self, name: str, *, on_shutdown_request: Callable[[str], object], **options: Any) -> None:
        self._on_shutdown_request = on_shutdown_request
        self._left: dict[str, Callable[[], object]] = {}
        self._fields: dict[str, Callable[[], dict[str, str]]] = {}
        super().__init__(name, rosout=False, intraprocess=False, on_event=self._note, **options)
        # rospy ends it, after the program's own hooks, which still publish: not before them at exit.
        closing._open_nodes.pop(self, None)
        self._register = self._registrations.add
        self._registrations.add = self._add  # type: ignore[assignment, method-assign]

    def on_topic_left(self, topic: str, callback: Callable[[], object]) -> None:
        """Have `callback()` called when a subscriber of a topic is gone."""
        self._left[topic] = callback

    def add_header_fields(self, topic: str, fields: Callable[[], dict[str, str]]) -> None:
        """Have what `fields()` returns said to each subscriber of a topic; before it is published."""
        self._fields[topic] = fields

    def _add(self, entry: Any, timeout: float | None = None) -> None:
        """Register a topic; its header is completed before anybody can hear of it."""
        fields = self._fields.get(entry.name)
        if fields is not None and isinstance(entry, Publication):
            usual = entry.header
            entry.header = lambda output=None: {**usual(output), **fields()}  # type: ignore[method-assign]
        self._register(entry, timeout)

    def _note(self, event: Event) -> None:
        callback = self._left.get(event.name)
        if event.kind is EventKind.DISCONNECTED and event.direction == "out" and callback is not None:
            callback()

    def _start(self, rosout: bool) -> None:
        self._watchdog.start()

    def _shut_down_later(self, reason: str) -> None:
        threading.Thread(
            target=self._on_shutdown_request, args=(reason,), name="rosproto:shutdown request", daemon=True
        ).start()


class Caller:
    """Enough of a node to call services: rospy's ServiceProxy works before init_node."""

    def __init__(self, name: str, master_uri: str) -> None:
        self.name = name
        self.limits = Limits()
        self.master = MasterClient(master_uri, name, timeout=60.0)
        self.revisions = Revisions()
        self._services = self

    def forget_client(self, client: object) -> None:
        """Nobody keeps a list."""
