"""Events of links and of the registration at the master, for `Node(on_event=...)`.

The library logs exceptions of `on_event` and of the program's other callbacks, so that they do not end a
link. A KeyboardInterrupt in the main thread is raised instead, since it is meant for the program: some
callbacks run there, inside a call of the program (it closes a subscriber whose publisher is in the same
process).
"""

from __future__ import annotations

import enum
import threading
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import NamedTuple

from rosproto.logs import get_logger

_log = get_logger("rosproto.node")

MAX_KEPT_EVENTS = 64


class EventKind(enum.Enum):
    """Kind of an event."""

    CONNECTED = "connected"
    """A link to a publisher or subscriber carries messages now."""
    DISCONNECTED = "disconnected"
    """A link ended; a subscriber reconnects automatically."""
    REFUSED = "refused"
    """A handshake failed: most often another md5sum."""
    FAILED = "failed"
    """A publisher could not be reached; it is tried again."""
    MASTER_LOST = "master lost"
    """The master does not answer."""
    MASTER_BACK = "master back"
    """The master answers again, and everything is registered."""
    ADDRESS_CHANGED = "address changed"
    """This computer has another address towards the master; the node listens there now."""


NO_HEADER: Mapping[str, str] = MappingProxyType({})


class Event(NamedTuple):
    """One event.

    Attributes:
        kind: What happened.
        name: Topic; "" for the node as a whole.
        address: "host:port" or URI of the other side.
        error: The error, or None.
        peer: The other node's name; "" if unknown.
        direction: "in" from a publisher, "out" to a subscriber, "" otherwise.
        header: The connection header of a subscriber that was refused; empty otherwise.
    """

    kind: EventKind
    name: str = ""
    address: str = ""
    error: Exception | None = None
    peer: str = ""
    direction: str = ""
    header: Mapping[str, str] = NO_HEADER


class Events:
    """The latest events of one node; safe from any thread.

    Args:
        callback: Called with each event, in the thread where it happens.
    """

    def __init__(self, node_name: str, callback: Callable[[Event], object] | None) -> None:
        self._node_name = node_name
        self._callback = callback
        self._kept: deque[Event] = deque(maxlen=MAX_KEPT_EVENTS)

    def __iter__(self) -> Iterator[Event]:
        return iter(list(self._kept))

    def emit(self, event: Event) -> None:
        """Record an event and call the callback."""
        self._kept.append(event)
        if self._callback is not None:
            try:
                self._callback(event)
            except BaseException as error:  # as in incoming/subscriber_queue.py
                if is_interrupt(error):
                    raise
                _log.exception("! %s: on_event raised", self._node_name)

    def last_refusal(self, name: str) -> str:
        """Text about the last refused subscriber of a topic, for errors about missing subscribers."""
        refused = [event for event in self if event.kind is EventKind.REFUSED and event.name == name]
        return f" (refused: {refused[-1].error})" if refused else ""


def without_frames(error: Exception) -> Exception:
    """The error without its tracebacks and those of its causes.

    A traceback keeps the variables of its frames alive, such as a link's receive buffer of 256 KiB.
    """
    todo: list[BaseException | None] = [error]
    seen: set[int] = set()
    while todo:
        one = todo.pop()
        if one is not None and id(one) not in seen:
            seen.add(id(one))
            one.__traceback__ = None
            todo += (one.__cause__, one.__context__)
    return error


def is_interrupt(error: BaseException) -> bool:
    """True to raise the error again. Python raises it in the main thread only; elsewhere a callback does."""
    return isinstance(error, KeyboardInterrupt) and threading.current_thread() is threading.main_thread()
