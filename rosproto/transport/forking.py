"""What a fork leaves to its parent.

`os.fork` copies our sockets into the child, and none of the threads that use them. A message that the child
sent would land in the middle of one of its parent's, its `close` would end connections that its parent still
uses, and a connection whose parent is gone would stay open as long as the child lives. So in the child they
are closed before it gets a say; a descriptor that is closed there does nothing to the parent's.
"""

from __future__ import annotations

import os
import socket
from collections.abc import Callable
from weakref import WeakSet

_sockets: WeakSet[socket.socket] = WeakSet()
_in_child: list[Callable[[], object]] = []


def close_in_forked_children(sock: socket.socket) -> None:
    """Have a socket closed in every child that this process forks."""
    on_fork(_close_all)
    _sockets.add(sock)


def on_fork(action: Callable[[], object]) -> None:
    """Have `action` called once in each forked child, where only the forking thread lives.

    It must take no lock: one that another thread held will never be released there. Registered with the
    interpreter when it is first asked for, not at import; without effect where there is no fork.
    """
    if action in _in_child:
        return
    _in_child.append(action)
    if hasattr(os, "register_at_fork"):
        os.register_at_fork(after_in_child=action)


def is_forked_child(opened_by: int) -> bool:
    """Was this opened by another process, the parent of this one?"""
    return os.getpid() != opened_by


def _close_all() -> None:
    for sock in list(_sockets):
        sock.close()
    _sockets.clear()
