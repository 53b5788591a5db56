"""Closes a node once, in a fixed order, with bounded steps; closes open nodes when the program ends.

Nodes that stay registered after their program make other nodes try to reach them for long. As in rospy and
roscpp, an `atexit` function therefore closes the nodes that the process opened and did not close, within
`EXIT_SECONDS` in total. A process that is killed, or ends by `os._exit` (as children of multiprocessing do),
leaves its nodes registered; `rosproto node cleanup` unregisters them.

In a fork of the process that opened it, a node is closed, and its errors give this reason. Its threads do not
run there, and its connections are the parent's (`rosproto.transport.forking`). It is not closed as usual,
which would unregister the parent's node. The child can open nodes of its own.
"""

from __future__ import annotations

import atexit
import os
import threading
import time
from collections.abc import Callable

from rosproto.logs import get_logger
from rosproto.node.incoming.local_nodes import EVERYBODY
from rosproto.transport.forking import on_fork

_log = get_logger("rosproto.node")

CLOSE_SECONDS = 1.0  # for each step of closing that waits for a peer or a thread
EXIT_SECONDS = 2.0
BEFORE_CLOSE_SECONDS = 10.0  # in addition, with `Node.before_close` callbacks

Close = Callable[[], None]


class Lifecycle:
    """State of one node (open, closing or closed), and the callbacks for its changes.

    Attributes:
        closing: Set when closing begins; ends the long waits of all parts.
        ended: Set when closing is complete.
        close_reason: Why the node was closed; "" if the program closed it.
        closers: Called while closing, newest first, before the servers close. Each is bounded and idempotent.
        before_close, shutdown_callbacks: See `Node.before_close` and `Node.on_shutdown`.
        fork_callbacks: Called in a fork of this process, where the node does not work.
    """

    def __init__(self) -> None:
        self.closing = threading.Event()
        self.ended = threading.Event()
        self.close_reason = ""
        self.closers: list[Close] = []
        self.before_close: list[Callable[[str], object]] = []
        self.shutdown_callbacks: list[Callable[[str], object]] = []
        self.fork_callbacks: list[Close] = []
        self._lock = threading.Lock()
        self._closing_thread: int | None = None

    @property
    def closed(self) -> bool:
        """True once closing begins."""
        return self.closing.is_set()

    def close(self, reason: str, *steps: Close) -> None:
        """Close the node; a second caller waits for the first.

        Args:
            reason: "" if the program closes it, else the requester and its reason.
            *steps: Close the parts that live as long as the node; called in order, after `closers`.
        """
        with self._lock:
            by, first = self._closing_thread, self._closing_thread is None and not self.closing.is_set()
            if first:
                self._closing_thread = threading.get_ident()
                self.close_reason = reason
        if not first:
            if by != threading.get_ident():  # not from one of the callbacks below
                self.ended.wait(5 * CLOSE_SECONDS + (BEFORE_CLOSE_SECONDS if self.before_close else 0.0))
            return
        try:
            interrupts = [_guard(callback, reason) for callback in self.before_close]
            self.closing.set()
            interrupts += [_guard(callback, reason) for callback in self.shutdown_callbacks]
            interrupts += [_guard(step) for step in [*reversed(self.closers), *steps]]
        finally:
            _open_nodes.pop(self, None)
            self.end()
        for interrupt in filter(None, interrupts):
            raise interrupt

    def end(self) -> None:
        """Mark the node as closed."""
        self.closing.set()
        self.ended.set()

    def abandon(self, reason: str) -> None:
        """Mark the node as closed in a fork of its process.

        Takes no lock: another thread may have held it at the fork.
        """
        self.close_reason = reason
        self.closing = self.ended = threading.Event()
        self.closing.set()
        self.before_close = []
        for callback in self.fork_callbacks:
            callback()


_open_nodes: dict[Lifecycle, tuple[int, Close]] = {}
"""Nodes to close at the end of the program: the process that opened each, and its close function.

The references are not weak, since the threads of an open node keep it alive anyway.
"""
_registered = False


def close_at_exit(lifecycle: Lifecycle, close: Close) -> None:
    """Close a node at the end of this process, if it is still open."""
    global _registered
    _open_nodes[lifecycle] = (os.getpid(), close)
    if not _registered:
        _registered = True
        atexit.register(_at_exit)
        on_fork(_in_child)


def _in_child() -> None:
    """Mark the parent's nodes as closed in this fork."""
    nodes = {lifecycle: process for lifecycle, (process, _) in _open_nodes.items()}
    _open_nodes.clear()
    EVERYBODY.clear()  # other tables need no change: their nodes are closed below
    for lifecycle, process in nodes.items():
        lifecycle.abandon(
            f"it was opened by another process, {process}, and this one is a fork of it: open nodes in the"
            " process that uses them"
        )


def _at_exit() -> None:
    """Close the open nodes in another thread, so that a master that hangs does not block the exit."""
    mine = {lifecycle: close for lifecycle, (pid, close) in list(_open_nodes.items()) if pid == os.getpid()}
    if not mine:
        return
    closes = list(mine.values())
    try:
        thread = threading.Thread(target=_close_all, args=(closes,), name="rosproto:exit", daemon=True)
        thread.start()
    except RuntimeError:  # Python starts no more threads
        _close_all(closes)
    else:
        farewell = any(lifecycle.before_close for lifecycle in mine)
        end = time.monotonic() + EXIT_SECONDS + (BEFORE_CLOSE_SECONDS if farewell else 0.0)
        while thread.is_alive() and (left := end - time.monotonic()) > 0.0:
            try:
                thread.join(left)
            except KeyboardInterrupt:
                continue  # a second Ctrl-C would leave the node registered; the wait is bounded


def _close_all(closes: list[Close]) -> None:
    for close in reversed(closes):  # the newest first, as with nested `with` blocks
        _guard(close)


def shut_down_later(
    name: str, close: Callable[[str], None], instead: Callable[[str], object] | None, reason: str
) -> None:
    """Close in another thread, so that the shutdown call is answered first; or call `instead`."""
    if instead is None:
        _log.warning("= %s: %s", name, reason)
    threading.Thread(
        target=instead or close, args=(reason,), name=f"rosproto:shutdown {name}", daemon=True
    ).start()


def _guard(step: Callable[..., object], *arguments: object) -> BaseException | None:
    """Run one step of closing, and log its exceptions, so that the other steps run; return an interrupt."""
    try:
        step(*arguments)
    except Exception:
        _log.exception("! closing: %r failed", step)
    except BaseException as interrupt:
        return interrupt
    return None
