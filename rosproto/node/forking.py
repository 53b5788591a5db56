"""A node belongs to the process that opened it: in a fork of that process it is closed, and says why.

None of its threads lives there and its connections are its parent's (`rosproto.transport.forking`), so
nothing of it could work; and to close it as usual would take the parent's node off the master. A node that
the child opens itself is one like any other.
"""

from __future__ import annotations

import threading
from collections.abc import Mapping

from rosproto.node.context import Context
from rosproto.node.incoming import local_nodes


def leave_to_parent(nodes: Mapping[Context, int]) -> None:
    """Runs in the child; takes no lock, as other threads may have held them when the process was copied.

    Args:
        nodes: Open nodes, with the process that opened them.
    """
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
