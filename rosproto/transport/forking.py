"""Close sockets in forked child processes.

`os.fork` copies the sockets into the child, but not the threads that use them. A message sent by the child
would land inside one of the parent's, its `close` would end connections that the parent still uses, and a
connection would stay open after the parent has ended. So the child closes its copies at once, which does not
affect the parent.
"""

from __future__ import annotations

import os
import socket
from collections.abc import Callable
from weakref import WeakSet

_sockets: WeakSet[socket.socket] = WeakSet()
_in_child: list[Callable[[], object]] = []


def close_in_forked_children(sock: socket.socket) -> None:
    """Close a socket in every child that this process forks."""
    on_fork(_close_all)
    _sockets.add(sock)


def on_fork(action: Callable[[], object]) -> None:
    """Call `action` once in each forked child, where only the forking thread lives.

    It must take no lock: a lock held by another thread is never released there. It is registered with the
    interpreter on first use, not at import; without effect where there is no fork.
    """
    if action in _in_child:
        return
    _in_child.append(action)
    if hasattr(os, "register_at_fork"):
        os.register_at_fork(after_in_child=action)


def is_forked_child(opened_by: int) -> bool:
    """Whether this process is a fork of the process `opened_by`."""
    return os.getpid() != opened_by


def _close_all() -> None:
    for sock in list(_sockets):
        sock.close()
    _sockets.clear()
