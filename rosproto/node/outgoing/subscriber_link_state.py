"""The states of a link to one subscriber, as a table; all transitions are here.

A link is made when a subscriber's header is accepted. It joins the publication's links before the monitor
watches it, so that it gets everything published from then on. Until the monitor watches its socket
(`OPENING`, `OPENING_FULL`), only `publish()` sends. Over TCPROS our header goes first and is queued, so such
a link begins with `FULL`.

Then it alternates between two states. `SENDING`: the queue is empty; messages are sent at once in the
publisher's thread, or joined into a batch. `BLOCKED`: the socket is full; messages go to the queue, which
drops the oldest, and the monitor sends when the socket is writable.

`CLOSED` is final: a subscriber that connects again gets another link.
"""

from __future__ import annotations

import enum


class OutgoingState(enum.Enum):
    """State of a link; the value is the text in `stats()`."""

    OPENING = "opening"
    OPENING_FULL = "opening, blocked"
    SENDING = "connected"
    BLOCKED = "blocked"
    CLOSED = "closed"

    @property
    def waits(self) -> bool:
        """Whether data waits for the socket, so that new messages are queued behind it."""
        return self in (OutgoingState.OPENING_FULL, OutgoingState.BLOCKED)

    @property
    def watched(self) -> bool:
        """Whether the monitor watches the socket."""
        return self in (OutgoingState.SENDING, OutgoingState.BLOCKED)


class OutgoingEvent(enum.Enum):
    """Event of a link."""

    FULL = "something must wait: the socket took not all, or our header comes first"
    DRAINED = "everything that waited is sent"
    WATCHED = "the monitor watches the socket"
    ENDED = "one of the two sides ended it, or the network did"


_TABLE = {
    (OutgoingState.OPENING, OutgoingEvent.FULL): OutgoingState.OPENING_FULL,
    (OutgoingState.OPENING, OutgoingEvent.WATCHED): OutgoingState.SENDING,
    (OutgoingState.OPENING_FULL, OutgoingEvent.DRAINED): OutgoingState.OPENING,
    (OutgoingState.OPENING_FULL, OutgoingEvent.WATCHED): OutgoingState.BLOCKED,
    (OutgoingState.SENDING, OutgoingEvent.FULL): OutgoingState.BLOCKED,
    (OutgoingState.BLOCKED, OutgoingEvent.DRAINED): OutgoingState.SENDING,
}


def next_state(state: OutgoingState, event: OutgoingEvent) -> OutgoingState:
    """The state after an event. ENDED closes from every state; a closed link ignores all events.

    (A signal handler may close the link on which its own thread is sending: the socket event comes after the
    end.)

    Raises:
        AssertionError: The event cannot happen in this state: a bug here.
    """
    if event is OutgoingEvent.ENDED or state is OutgoingState.CLOSED:
        return OutgoingState.CLOSED
    following = _TABLE.get((state, event))
    assert following is not None, f"{event} in {state}"
    return following
