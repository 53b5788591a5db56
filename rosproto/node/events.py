"""What happens to links and to the registration at the master, as values for `Node(on_event=...)`."""

from __future__ import annotations

import enum

from rosproto.records import NamedTuple

__all__ = ["Event", "EventKind", "without_frames"]


class EventKind(enum.Enum):
    """What happened."""

    CONNECTED = "connected"
    """A link to a publisher or subscriber carries messages now."""
    DISCONNECTED = "disconnected"
    """A link ended; a subscriber tries again by itself."""
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


class Event(NamedTuple):
    """One event.

    Attributes:
        kind: What happened.
        name: Topic; "" for the node as a whole.
        address: "host:port" or URI of the other side.
        error: What went wrong, None when nothing did.
        peer: The other node's name, "" when it is not known.
        direction: "in" from a publisher, "out" to a subscriber, "" otherwise.
    """

    kind: EventKind
    name: str = ""
    address: str = ""
    error: Exception | None = None
    peer: str = ""
    direction: str = ""


def without_frames(error: Exception) -> Exception:
    """The error, fit to be kept: without its tracebacks, and those of its causes.

    A traceback holds the frames it went through, and they their variables: a link's receive buffer of 256 KiB
    for every error that is remembered.
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
