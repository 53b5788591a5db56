"""How a node ends: once, in a fixed order, each step bounded; and when the program ends and nobody closed it.

A program that simply ends would leave its nodes registered, and others would try for long to reach them;
rospy and roscpp take a node off the master then, and so is it here. The first node registers a function with
`atexit`, which closes what is still open in the process that opened it, within `EXIT_SECONDS` in all. A
process that is killed, or ends by `os._exit` (as children of multiprocessing do), leaves its nodes on the
master; `rosproto node cleanup` takes them off.

A node belongs to the process that opened it: in a fork of that process it is closed, and says why. None of
its threads lives there and its connections are its parent's (`rosproto.transport.forking`), so nothing of
it could work; and to close it as usual would take the parent's node off the master. A node that the child
opens itself is one like any other.
"""

from __future__ import annotations

import atexit
import os
import threading
import time
from collections.abc import Callable

from rosproto.logs import get_logger
from rosproto.node.context import Context
from rosproto.node.incoming import local_nodes
from rosproto.transport.deadline import Deadline
from rosproto.transport.forking import on_fork

_log = get_logger("rosproto.node")

CLOSE_SECONDS = 1.0  # for each step of closing that waits for somebody else
EXIT_SECONDS = 2.0
BEFORE_CLOSE_SECONDS = 10.0  # more, where there are `Node.before_close` callbacks

Close = Callable[[], None]

_open_nodes: dict[Context, tuple[int, Close]] = {}
"""Nodes to close at the end of the program, with the process that opened them, and how they are closed.

Not weak references: the threads of an open node keep it alive in any case.
"""
_registered = False


def close_at_exit(context: Context, close: Close) -> None:
    """Have a node closed at the end of this process, should it still be open."""
    global _registered
    _open_nodes[context] = (os.getpid(), close)
    if not _registered:
        _registered = True
        atexit.register(_at_exit)
        on_fork(_in_child)


def _in_child() -> None:
    """This process is a fork of another: its nodes are the other's.

    Takes no lock, as other threads may have held them when the process was copied.
    """
    nodes = {context: process for context, (process, _) in _open_nodes.items()}
    _open_nodes.clear()
    local_nodes.forget_all()
    for context, process in nodes.items():
        context.close_reason = (
            f"it was opened by another process, {process}, and this one is a fork of it: open nodes in the"
            " process that uses them"
        )
        context.closing = context.ended = _over()
        context.before_close = []
        context.master.abandon()
        context.clock.closing = context.closing
        for callback in context.fork_callbacks:
            callback()


def _over() -> threading.Event:
    """An event that is set, in place of one whose lock may be held for ever."""
    event = threading.Event()
    event.set()
    return event


def _at_exit() -> None:
    """Close what is open, in another thread: a master that hangs must not hold the program up."""
    mine = {context: close for context, (pid, close) in list(_open_nodes.items()) if pid == os.getpid()}
    if not mine:
        return
    closes = list(mine.values())
    try:
        thread = threading.Thread(target=_close_all, args=(closes,), name="rosproto:exit", daemon=True)
        thread.start()
    except RuntimeError:  # no new threads any more
        _close_all(closes)
    else:
        farewell = any(context.before_close for context in mine)
        end = time.monotonic() + EXIT_SECONDS + (BEFORE_CLOSE_SECONDS if farewell else 0.0)
        while thread.is_alive() and (left := end - time.monotonic()) > 0.0:
            try:
                thread.join(left)
            except KeyboardInterrupt:
                continue  # a second Ctrl-C would leave the node registered; it takes seconds at most


def _close_all(closes: list[Close]) -> None:
    for close in reversed(closes):  # the newest first, as with nested `with` blocks
        _guard(close)


def close(context: Context, reason: str, *steps: Close) -> None:
    """Close a node; a second caller waits for the first.

    Args:
        context: Of the node.
        reason: "" by the program, else who asked for it, and why.
        *steps: What ends the parts that live as long as the node, called one after the other at the end.
    """
    with context.close_lock:
        by, first = context.closer, context.closer is None and not context.closing.is_set()
        if first:
            context.closer = threading.get_ident()
            context.close_reason = reason
    if not first:
        if by != threading.get_ident():  # not from one of the callbacks below
            context.ended.wait(5 * CLOSE_SECONDS + (BEFORE_CLOSE_SECONDS if context.before_close else 0.0))
        return
    try:
        for callback in context.before_close:
            _guard(callback, reason)
        context.closing.set()
        for callback in context.shutdown_callbacks:
            _guard(callback, reason)
        for step in [*reversed(context.closers), *steps]:
            _guard(step)
    finally:
        _open_nodes.pop(context, None)
        context.closing.set()
        context.ended.set()


def give_up(context: Context) -> None:
    """The node could not even listen: nothing is registered, no other thread runs."""
    context.master.close()
    context.monitor.close()
    context.closing.set()
    context.ended.set()


def shut_down_later(
    name: str, close: Callable[[str], None], instead: Callable[[str], object] | None, reason: str
) -> None:
    """Obey a shutdown call: answer it first, then close, or leave that to the program (`instead`)."""
    if instead is None:
        _log.warning("= %s: %s", name, reason)
    threading.Thread(
        target=instead or close, args=(reason,), name=f"rosproto:shutdown {name}", daemon=True
    ).start()


def _guard(step: Callable[..., object], *arguments: object) -> None:
    """One step of closing; what it raises must not stop the others."""
    try:
        step(*arguments)
    except Exception:
        _log.exception("! closing: %r failed", step)


def leave_master(context: Context) -> None:
    """Take everything off the master, if it answers."""
    if not context.master_lost:
        # Its own client: a call that hangs in `context.master` must not use up the time.
        with context.master_client(CLOSE_SECONDS) as master:
            context.registrations.unregister_all(Deadline(CLOSE_SECONDS), master)


def close_servers(context: Context) -> None:
    """Listen no more, watch nobody any more, ask the master nothing any more."""
    context.endpoints.close(CLOSE_SECONDS)
    context.monitor.close(CLOSE_SECONDS)
    context.master.close()
