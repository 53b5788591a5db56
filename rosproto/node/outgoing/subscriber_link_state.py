"""The states of a link to one subscriber, as a table; all transitions are here.

A link is made when a subscriber's header fits, and stands among the publication's links before it is
watched: what is published from that moment on is meant for it. Until the monitor watches its socket
(`OPENING`, `OPENING_FULL`) nobody but `publish()` sends. Over TCPROS our header goes first, and waits as what
a socket did not take does, so such a link begins with `FULL`.

From then on it goes back and forth between two states. `SENDING`: nothing waits; what is published is sent
at once in the publisher's thread, or joined with others for a moment. `BLOCKED`: the socket took no more;
what is published goes to the queue, which drops the oldest, and the monitor sends when the socket takes
more.

It never comes back from `CLOSED`: a subscriber that connects again gets another link.
"""

from __future__ import annotations

import enum


class OutgoingState(enum.Enum):
    """Where a link stands; the text is what `stats()` says."""

    OPENING = "opening"
    OPENING_FULL = "opening, blocked"
    SENDING = "connected"
    BLOCKED = "blocked"
    CLOSED = "closed"

    @property
    def waits(self) -> bool:
        """Something waits for the socket: what is published now goes behind it."""
        return self in (OutgoingState.OPENING_FULL, OutgoingState.BLOCKED)

    @property
    def watched(self) -> bool:
        """The monitor looks at the socket."""
        return self in (OutgoingState.SENDING, OutgoingState.BLOCKED)


class OutgoingEvent(enum.Enum):
    """What happened to it."""

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
    """The state after an event. ENDED ends every state; nothing happens any more to a link that is closed.

    (A signal handler may close the link on which its own thread is sending: what the socket says then comes
    after the end.)

    Raises:
        AssertionError: The event cannot happen in this state: a bug here.
    """
    if event is OutgoingEvent.ENDED or state is OutgoingState.CLOSED:
        return OutgoingState.CLOSED
    following = _TABLE.get((state, event))
    assert following is not None, f"{event} in {state}"
    return following
