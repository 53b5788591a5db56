"""The states of a link to one publisher, as a table; all transitions are here.

A subscriber has one link for each publisher that the master names. The link asks the publisher where to
connect (`requestTopic`), connects, exchanges headers, and receives until the session ends. Then it waits and
begins again with a new requestTopic, since a restarted publisher listens on another port; rospy never tries
again, and roscpp tries the old port for ever (docs/wire.md, 58). The link is closed only when the master no
longer names the publisher, or the subscriber closes.

The wait (`RetryPauses`) depends on the failure. An unreachable publisher is tried again after 50 ms, doubling
to 0.6 s, so that one behind a network failure is connected within a second. One that is gone (its computer
refuses the connection) registers again when it comes back, and the master then names it: this nudge ends any
wait, but not before `MIN_WAIT_SECONDS`. Only if the master cannot tell us (a firewall) does it have to be
found: each wait is a third of the time that it has been away, at most a minute. After a refusal: 0.5 s,
doubling to 5 s. If the definitions differ: 30 s, doubling to 5 minutes, since each try logs a warning at the
publisher. If sessions begin but end at once: up to 5 s; a session is a success after `STEADY_SECONDS`.
"""

from __future__ import annotations

import enum

from rosproto.transport.backoff import Backoff

STEADY_SECONDS = 5.0
MIN_WAIT_SECONDS = 0.25
GONE = (0.1, 60.0)  # seconds: the first and the longest wait for a publisher that has ended
MISMATCH = (30.0, 300.0)  # seconds: the first and the longest wait when definitions differ


class LinkState(enum.Enum):
    """State of a link."""

    WAITING = "waiting"
    REQUESTING = "asking for the topic"
    CONNECTING = "connecting"
    RECEIVING = "receiving"
    REFUSED = "refused"
    CLOSED = "closed"

    @property
    def is_wait(self) -> bool:
        """True while the link waits for its next try."""
        return self in (LinkState.WAITING, LinkState.REFUSED)


class LinkEvent(enum.Enum):
    """An event of a link."""

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
    # A nudge does not change an active link; if the session fails, it ends the next wait.
    (LinkState.REQUESTING, LinkEvent.NUDGED): LinkState.REQUESTING,
    (LinkState.CONNECTING, LinkEvent.NUDGED): LinkState.CONNECTING,
    (LinkState.RECEIVING, LinkEvent.NUDGED): LinkState.RECEIVING,
    # The subscriber closed, or the master no longer names the publisher: final, from every state.
    **{(state, LinkEvent.WITHDRAWN): LinkState.CLOSED for state in LinkState},
    # Another thread closes the link, so the link's own thread may still report an event.
    **{(LinkState.CLOSED, event): LinkState.CLOSED for event in LinkEvent},
}


def next_state(state: LinkState, event: LinkEvent) -> LinkState:
    """The state after an event.

    Raises:
        AssertionError: The event cannot happen in this state: a bug in this library.
    """
    following = _TABLE.get((state, event))
    assert following is not None, f"{event} in {state}"
    return following


class RetryPauses:
    """The waits of one link before each try."""

    def __init__(self) -> None:
        self._retry = Backoff(first=0.05, factor=2.0, maximum=0.6, jitter=0.2)
        self._gone = Backoff(first=GONE[0], factor=1.3, maximum=GONE[1], jitter=0.2)
        self._brief = Backoff(first=0.05, factor=2.0, maximum=5.0, jitter=0.2)
        self._refused = Backoff(first=0.5, factor=2.0, maximum=5.0, jitter=0.2)
        self._mismatch = Backoff(first=MISMATCH[0], factor=2.0, maximum=MISMATCH[1], jitter=0.2)

    def after(
        self, lasted: float | None, *, refused: bool = False, mismatch: bool = False, gone: bool = False
    ) -> float:
        """Seconds to wait before the next try.

        Args:
            lasted: Seconds that the session lasted; None if there was none.
            refused: The publisher or we refused the other side's header.
            mismatch: The definitions differ, and values cannot be converted.
            gone: The publisher has ended.
        """
        if lasted is not None or not gone:
            self._gone.reset()
        if lasted is not None:
            self._retry.reset()
            if lasted >= STEADY_SECONDS:
                for backoff in (self._brief, self._refused, self._mismatch):
                    backoff.reset()
        if mismatch:
            return self._mismatch.next()
        if refused:
            return self._refused.next()
        if gone and lasted is None:
            return self._gone.next()
        return (self._retry if lasted is None else self._brief).next()
