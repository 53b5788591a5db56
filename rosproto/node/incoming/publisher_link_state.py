"""The states of a link to one publisher, as a table; all transitions are here.

A subscriber holds one link per publisher that the master names. The link asks the publisher where to connect
(`requestTopic`), connects, exchanges headers, and receives until something ends it. Then it waits a little
and begins again *with a fresh requestTopic*, because a restarted publisher listens on another port; rospy
never tries again, and roscpp tries the old port for ever (docs/wire.md, 58). It ends only when the master
no longer names the publisher, or the subscriber closes.

How long it waits (`RetryPauses`) depends on how the try ended. A publisher that cannot be reached is tried
again after 50 ms, doubling to 0.6 s, so that one that comes back is connected within a second. After a
refusal: 0.5 s, doubling to 5 s. Another definition is not cured by waiting at all, and each try is a
warning in the publisher's log: 30 s, doubling to 5 minutes. And one that agrees and breaks off at once, again
and again, is left alone for up to 5 s, whatever the reason: a session counts as a success when it has lasted
`STEADY`. The master's word about a publisher (a nudge) ends any of these waits, yet not the first `LEAST` of
them.
"""

from __future__ import annotations

import enum

from rosproto.transport.backoff import Backoff

STEADY = 5.0  # seconds
LEAST = 0.25  # seconds
MISMATCH = (30.0, 300.0)  # seconds: the first wait after another definition, and the longest


class LinkState(enum.Enum):
    """Where a link stands."""

    WAITING = "waiting"
    REQUESTING = "asking for the topic"
    CONNECTING = "connecting"
    RECEIVING = "receiving"
    REFUSED = "refused"
    CLOSED = "closed"

    @property
    def is_wait(self) -> bool:
        """True while nothing is under way: the next try is due later."""
        return self in (LinkState.WAITING, LinkState.REFUSED)


class LinkEvent(enum.Enum):
    """What happened to it."""

    DUE = "the wait is over"
    ADDRESS = "the publisher said where to connect"
    ACCEPTED = "headers are exchanged"
    FAILED = "the publisher could not be reached, or broke off"
    REFUSED = "the two sides do not fit"
    NUDGED = "the master named the publisher again"
    WITHDRAWN = "the publisher or the subscriber is gone"


_TABLE = {
    (LinkState.WAITING, LinkEvent.DUE): LinkState.REQUESTING,
    (LinkState.WAITING, LinkEvent.NUDGED): LinkState.REQUESTING,
    (LinkState.REFUSED, LinkEvent.DUE): LinkState.REQUESTING,
    (LinkState.REFUSED, LinkEvent.NUDGED): LinkState.REQUESTING,
    (LinkState.REQUESTING, LinkEvent.ADDRESS): LinkState.CONNECTING,
    (LinkState.REQUESTING, LinkEvent.FAILED): LinkState.WAITING,
    (LinkState.REQUESTING, LinkEvent.REFUSED): LinkState.REFUSED,
    (LinkState.CONNECTING, LinkEvent.ACCEPTED): LinkState.RECEIVING,
    (LinkState.CONNECTING, LinkEvent.FAILED): LinkState.WAITING,
    (LinkState.CONNECTING, LinkEvent.REFUSED): LinkState.REFUSED,
    (LinkState.RECEIVING, LinkEvent.FAILED): LinkState.WAITING,
    (LinkState.RECEIVING, LinkEvent.REFUSED): LinkState.REFUSED,
    # A nudge means nothing to a link at work; should the session fail, it ends the wait after it.
    (LinkState.REQUESTING, LinkEvent.NUDGED): LinkState.REQUESTING,
    (LinkState.CONNECTING, LinkEvent.NUDGED): LinkState.CONNECTING,
    (LinkState.RECEIVING, LinkEvent.NUDGED): LinkState.RECEIVING,
    # The subscriber closed, or the master names the publisher no more: from everywhere, and for good.
    **{(state, LinkEvent.WITHDRAWN): LinkState.CLOSED for state in LinkState},
    # Closing comes from another thread, so the link's own may still tell of what it was doing.
    **{(LinkState.CLOSED, event): LinkState.CLOSED for event in LinkEvent},
}


def next_state(state: LinkState, event: LinkEvent) -> LinkState:
    """The state after an event.

    Raises:
        AssertionError: The event cannot happen in this state: a bug here.
    """
    following = _TABLE.get((state, event))
    assert following is not None, f"{event} in {state}"
    return following


class RetryPauses:
    """How long one link waits before each try."""

    def __init__(self) -> None:
        self._retry = Backoff(first=0.05, factor=2.0, most=0.6, jitter=0.2)
        self._brief = Backoff(first=0.05, factor=2.0, most=5.0, jitter=0.2)
        self._refused = Backoff(first=0.5, factor=2.0, most=5.0, jitter=0.2)
        self._mismatch = Backoff(first=MISMATCH[0], factor=2.0, most=MISMATCH[1], jitter=0.2)

    def after(self, lasted: float | None, *, refused: bool = False, mismatch: bool = False) -> float:
        """Seconds to wait now.

        Args:
            lasted: Seconds that the session lasted; None: there was none.
            refused: The two sides do not fit.
            mismatch: Their definitions differ, and values cannot be carried over.
        """
        if lasted is not None:
            self._retry.reset()
            if lasted >= STEADY:
                for backoff in (self._brief, self._refused, self._mismatch):
                    backoff.reset()
        if mismatch:
            return self._mismatch.next()
        if refused:
            return self._refused.next()
        return (self._retry if lasted is None else self._brief).next()
