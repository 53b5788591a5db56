"""How a node ends: once, in a fixed order, each step bounded; and when the program ends and nobody closed it.

A program that simply ends would leave its nodes registered, and others would try for long to reach them;
rospy and roscpp take a node off the master then, and so is it here. The first node registers a function with
`atexit`, which closes what is still open in the process that opened it, within `EXIT_SECONDS` in all. A
process that is killed, or ends by `os._exit` (as children of multiprocessing do), leaves its nodes on the
master; `rosproto node cleanup` takes them off.
"""

from __future__ import annotations

import atexit
import os
import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from rosproto.logs import get_logger
from rosproto.node import forking
from rosproto.node.graph.master_client import MasterClient
from rosproto.node.incoming import local_link as intraprocess
from rosproto.transport.deadline import Deadline
from rosproto.transport.forking import on_fork

if TYPE_CHECKING:
    from rosproto.node.node import Node

__all__ = ["CLOSE_SECONDS", "close", "close_at_exit", "give_up", "shut_down_later"]

_log = get_logger("rosproto.node")

CLOSE_SECONDS = 1.0  # for each step of closing that waits for somebody else
EXIT_SECONDS = 2.0
BEFORE_CLOSE_SECONDS = 10.0  # more, where there are `Node.before_close` callbacks

_open_nodes: dict[Node, int] = {}
"""Nodes to close at the end of the program, with the process that opened them.

Not weak references: the threads of an open node keep it alive in any case.
"""
_registered = False


def close_at_exit(node: Node) -> None:
    """Have a node closed at the end of this process, should it still be open."""
    global _registered
    _open_nodes[node] = os.getpid()
    if not _registered:
        _registered = True
        atexit.register(_at_exit)
        on_fork(_in_child)


def _in_child() -> None:
    """This process is a fork of another: its nodes are the other's."""
    nodes = dict(_open_nodes)
    _open_nodes.clear()
    forking.leave_to_parent(nodes)


def _at_exit() -> None:
    """Close what is open, in another thread: a master that hangs must not hold the program up."""
    mine = [node for node, pid in list(_open_nodes.items()) if pid == os.getpid()]
    if not mine:
        return
    try:
        thread = threading.Thread(target=_close_all, args=(mine,), name="rosproto:exit", daemon=True)
        thread.start()
    except RuntimeError:  # no new threads any more
        _close_all(mine)
    else:
        farewell = any(node._before_close for node in mine)
        end = time.monotonic() + EXIT_SECONDS + (BEFORE_CLOSE_SECONDS if farewell else 0.0)
        while thread.is_alive() and (left := end - time.monotonic()) > 0.0:
            try:
                thread.join(left)
            except KeyboardInterrupt:
                continue  # a second Ctrl-C would leave the node registered; it takes seconds at most


def _close_all(nodes: list[Node]) -> None:
    for node in reversed(nodes):  # the newest first, as with nested `with` blocks
        _guard(node.close)


def close(node: Node, reason: str) -> None:
    """Close a node; a second caller waits for the first."""
    with node._close_lock:
        by, first = node._closer, node._closer is None and not node._closing.is_set()
        if first:
            node._closer = threading.get_ident()
            node._close_reason = reason
    if not first:
        if by != threading.get_ident():  # not from one of the callbacks below
            node._closed.wait(5 * CLOSE_SECONDS + (BEFORE_CLOSE_SECONDS if node._before_close else 0.0))
        return
    try:
        for callback in node._before_close:
            _guard(callback, reason)
        node._closing.set()
        for callback in node._shutdown_callbacks:
            _guard(callback, reason)
        for closer in reversed(node._closers):
            _guard(closer)
        _guard(_leave_master, node)
        _guard(node._topics.close)
        _guard(_close_servers, node)
    finally:
        _open_nodes.pop(node, None)
        node._closing.set()
        node._closed.set()


def give_up(node: Node) -> None:
    """The node could not even listen: nothing is registered, no other thread runs."""
    node._master.close()
    node._monitor.close()
    node._closing.set()
    node._closed.set()


def shut_down_later(node: Node, reason: str) -> None:
    """Obey a shutdown call: answer it first, then close."""
    _log.warning("= %s: %s", node.name, reason)
    threading.Thread(
        target=node._close, args=(reason,), name=f"rosproto:shutdown {node.name}", daemon=True
    ).start()


def _guard(step: Callable[..., object], *arguments: object) -> None:
    """One step of closing; what it raises must not stop the others."""
    try:
        step(*arguments)
    except Exception:
        _log.exception("! closing: %r failed", step)


def _leave_master(node: Node) -> None:
    if node._intraprocess:
        intraprocess.forget_node(node.uri, node)
    if not node._watchdog.master_lost:
        # Its own client: a call that hangs in `_master` must not use up the time.
        with MasterClient(node.master_uri, node.name, timeout=CLOSE_SECONDS) as master:
            node._registrations.unregister_all(Deadline(CLOSE_SECONDS), master)
    node._watchdog.close(CLOSE_SECONDS)


def _close_servers(node: Node) -> None:
    node._endpoints.close(CLOSE_SECONDS)
    node._monitor.close(CLOSE_SECONDS)
    node._master.close()
    node._watchdog.close(CLOSE_SECONDS)
