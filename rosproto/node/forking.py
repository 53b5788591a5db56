"""A node belongs to the process that opened it: in a fork of that process it is closed, and says why.

None of its threads lives there and its connections are its parent's (`rosproto.transport.forking`), so
nothing of it could work; and to close it as usual would take the parent's node off the master. A node that
the child opens itself is one like any other.
"""

from __future__ import annotations

import threading
from collections.abc import Mapping
from typing import TYPE_CHECKING

from rosproto.node.incoming import local_link as intraprocess

if TYPE_CHECKING:
    from rosproto.node.node import Node

__all__ = ["leave_to_parent"]


def leave_to_parent(nodes: Mapping[Node, int]) -> None:
    """Runs in the child; takes no lock, as other threads may have held them when the process was copied.

    Args:
        nodes: Open nodes, with the process that opened them.
    """
    intraprocess._open_nodes.clear()  # a URI there means a node that speaks, and these are mute
    for node, process in nodes.items():
        node._close_reason = (
            f"it was opened by another process, {process}, and this one is a fork of it: open nodes in the"
            " process that uses them"
        )
        node._closing = node._closed = _over()
        node._before_close = []
        _leave_master(node)
        _leave_topics(node)
        _leave_services(node)


def _over() -> threading.Event:
    event = threading.Event()
    event.set()
    return event


def _leave_master(node: Node) -> None:
    client = node._master._client
    client._lock, client._closed = threading.Lock(), True
    client._idle, client._busy = [], set()


def _leave_topics(node: Node) -> None:
    for publication in node._topics._publications.values():
        for publisher in publication.handles:
            publisher._closed = True
    for subscription in node._topics._subscriptions.values():
        for subscriber in subscription.handles:
            inbox = subscriber._inbox
            inbox.lock = threading.Lock()
            inbox.condition = threading.Condition(inbox.lock)
            inbox.close()


def _leave_services(node: Node) -> None:
    services = node._services_made
    if services is None:
        return
    services._closed, services._servers = True, {}
    for client in services._clients:
        client._stop, client._kept, client._open = _over(), None, set()
        client._lock, client._turn = threading.Lock(), threading.Lock()
