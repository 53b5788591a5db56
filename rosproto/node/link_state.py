"""The states of a link to one publisher, as a table; all transitions are here.

A subscriber holds one link per publisher that the master names. The link asks the publisher where to connect
(`requestTopic`), connects, exchanges headers, and receives until something ends it. Then it waits a little
and begins again *with a fresh requestTopic*, because a restarted publisher listens on another port; rospy
never tries again, and roscpp tries the old port for ever (docs/wire.md, 58). It ends only when the master
no longer names the publisher, or the subscriber closes.

The wait is short and bounded: `RETRY` doubles from 50 ms to 0.6 s, so that a publisher that can be reached
again is connected within a second. A refusal (other md5sum) is not cured by haste: 0.5 s, doubling to 5 s.
"""

from __future__ import annotations

import enum

from rosproto.transport.backoff import Backoff

__all__ = ["LinkEvent", "LinkState", "next_state", "refused_backoff", "retry_backoff"]


class LinkState(enum.Enum):
    """Where a link stands."""

    WAITING = "waiting"
    REQUESTING = "asking for the topic"
    CONNECTING = "connecting"
    RECEIVING = "receiving"
    REFUSED = "refused"
    CLOSED = "closed"


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
}


def next_state(state: LinkState, event: LinkEvent) -> LinkState:
    """The state after an event. WITHDRAWN ends every state; a nudge means nothing to a link at work.

    Raises:
        AssertionError: The event cannot happen in this state: a bug here.
    """
    if event is LinkEvent.WITHDRAWN or state is LinkState.CLOSED:
        return LinkState.CLOSED
    following = _TABLE.get((state, event))
    if following is None:
        assert event is LinkEvent.NUDGED, f"{event} in {state}"
        return state
    return following


def retry_backoff() -> Backoff:
    """Waits between tries."""
    return Backoff(first=0.05, factor=2.0, most=0.6, jitter=0.2)


def refused_backoff() -> Backoff:
    """Waits after refusals: each is a warning in the publisher's log."""
    return Backoff(first=0.5, factor=2.0, most=5.0, jitter=0.2)
