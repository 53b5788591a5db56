"""The states of a link to one publisher."""

from __future__ import annotations

import ast
import itertools
import queue
import threading
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import pytest

from rosproto.errors import ConnectionLost, Md5sumMismatch
from rosproto.logs import PeerLog
from rosproto.node.incoming import publisher_link
from rosproto.node.incoming.publisher_link import PublisherLink
from rosproto.node.incoming.publisher_link_state import LinkEvent, LinkState, RetryPauses, next_state

if TYPE_CHECKING:
    from rosproto.node.incoming.subscription import Subscription

WAITING, REQUESTING, CONNECTING, RECEIVING, REFUSED, CLOSED = LinkState
DUE, ADDRESS, ACCEPTED, FAILED, NOT_FITTING, NUDGED, WITHDRAWN = LinkEvent

TABLE: dict[LinkState, dict[LinkEvent, LinkState]] = {
    WAITING: {DUE: REQUESTING, NUDGED: REQUESTING, WITHDRAWN: CLOSED},
    REQUESTING: {
        ADDRESS: CONNECTING,
        FAILED: WAITING,
        NOT_FITTING: REFUSED,
        NUDGED: REQUESTING,
        WITHDRAWN: CLOSED,
    },
    CONNECTING: {
        ACCEPTED: RECEIVING,
        FAILED: WAITING,
        NOT_FITTING: REFUSED,
        NUDGED: CONNECTING,
        WITHDRAWN: CLOSED,
    },
    RECEIVING: {FAILED: WAITING, NOT_FITTING: REFUSED, NUDGED: RECEIVING, WITHDRAWN: CLOSED},
    REFUSED: {DUE: REQUESTING, NUDGED: REQUESTING, WITHDRAWN: CLOSED},
    CLOSED: dict.fromkeys(LinkEvent, CLOSED),
}
"""The whole table, written a second time."""


@pytest.mark.promise("A publisher that closes its connection and stays")
def test_the_way_to_a_connection_and_back() -> None:
    """A lost connection begins again with asking, not with connecting."""
    state = LinkState.WAITING
    for event, expected in (
        (LinkEvent.DUE, LinkState.REQUESTING),
        (LinkEvent.ADDRESS, LinkState.CONNECTING),
        (LinkEvent.ACCEPTED, LinkState.RECEIVING),
        (LinkEvent.FAILED, LinkState.WAITING),
        (LinkEvent.DUE, LinkState.REQUESTING),
        (LinkEvent.REFUSED, LinkState.REFUSED),
        (LinkEvent.NUDGED, LinkState.REQUESTING),
    ):
        state = next_state(state, event)
        assert state is expected


@pytest.mark.parametrize("state", list(LinkState))
def test_withdrawal_ends_every_state_for_good(state: LinkState) -> None:
    """And nothing revives a closed link."""
    assert next_state(state, LinkEvent.WITHDRAWN) is LinkState.CLOSED
    for event in LinkEvent:
        assert next_state(LinkState.CLOSED, event) is LinkState.CLOSED


def test_a_nudge_does_not_disturb_a_link_at_work() -> None:
    """The master's list may come at any time."""
    for state in (LinkState.REQUESTING, LinkState.CONNECTING, LinkState.RECEIVING):
        assert next_state(state, LinkEvent.NUDGED) is state


def test_an_event_that_cannot_happen_is_a_bug() -> None:
    """The table is complete: everything else is refused."""
    with pytest.raises(AssertionError):
        next_state(LinkState.WAITING, LinkEvent.ACCEPTED)


def test_waits_are_bounded() -> None:
    """A publisher that can be reached again is connected within a second; refusals are tried slowly."""
    pauses = RetryPauses()
    assert max(pauses.after(None) for _ in range(50)) < 0.8
    assert 4.0 <= [pauses.after(None, refused=True) for _ in range(10)][-1] <= 6.0


def test_a_publisher_that_is_gone_is_tried_ever_less() -> None:
    """It is found after a third of the time that it was away, at most a minute; after a short restart at once."""
    pauses, away = RetryPauses(), 0.0
    for _ in range(60):
        pause = pauses.after(None, gone=True)
        assert pause <= 0.45 * away + 0.12  # a third, with the random fifth of both
        away += pause
    assert 48.0 <= pause <= 72.0
    assert pauses.after(None) < 0.1  # another failure: it may be behind a network that fails
    assert pauses.after(None, gone=True) < 0.2


@pytest.mark.promise("retried every few seconds")
def test_sessions_that_end_at_once_are_no_success() -> None:
    """A publisher that agrees and breaks off is tried every few seconds at last; one that stayed, at once."""
    pauses = RetryPauses()
    assert pauses.after(0.0) < 0.1
    brief = [pauses.after(0.01) for _ in range(50)]
    assert 4.0 <= brief[-1] <= 6.0
    assert sum(brief[:12]) > 20  # it was 23 a second
    assert pauses.after(60.0) < 0.1


@pytest.mark.promise("every few minutes")
def test_another_definition_is_not_asked_again_and_again() -> None:
    """Each try is a warning in the publisher's log: one in the first 20 seconds, as with rospy."""
    pauses = RetryPauses()
    assert pauses.after(None, mismatch=True) > 20
    assert max(pauses.after(0.1, mismatch=True) for _ in range(20)) <= 360
    assert pauses.after(60.0, mismatch=True) < 40


@pytest.mark.parametrize("state", list(LinkState))
@pytest.mark.parametrize("event", list(LinkEvent))
def test_each_event_in_each_state(state: LinkState, event: LinkEvent) -> None:
    """Where the table has no row, the event is a bug of the link."""
    if event in TABLE[state]:
        assert next_state(state, event) is TABLE[state][event]
    else:
        with pytest.raises(AssertionError, match=state.name):
            next_state(state, event)


def test_no_state_is_set_around_the_table() -> None:
    """The state of a link is assigned where it is made, and where the table is asked."""
    found = set()
    for path in Path(publisher_link.__file__).parent.glob("*_link.py"):
        for function in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(function, ast.FunctionDef):
                found |= {
                    (path.name, function.name)
                    for node in ast.walk(function)
                    if isinstance(node, ast.Attribute)
                    and isinstance(node.ctx, ast.Store)
                    and node.attr in ("_state", "state")
                }
    assert found == {("publisher_link.py", "__init__"), ("publisher_link.py", "_step")}


class Owner:
    """A subscription and its context, as far as a link asks for them."""

    name = "/t"
    check_publishers = staticmethod(lambda subscription, at_once: None)
    emit = staticmethod(lambda event: None)
    next_link_id = staticmethod(itertools.count(1).__next__)

    def __init__(self) -> None:
        self.context: Any = self
        self.events = self
        self.peer_log = PeerLog("rosproto.test")
        self.closed = threading.Event()

    def report(self, error: Exception) -> None: ...

    def link_changed(self) -> None: ...

    def link_closed(self, link: PublisherLink) -> None:
        self.closed.set()


class Scripted(PublisherLink):
    """Opens and receives as the test says, and tells each step it took."""

    def __init__(self) -> None:
        self.owner = Owner()
        self.steps: queue.Queue[tuple[LinkEvent, LinkState]] = queue.Queue()
        self.tries: queue.Queue[Callable[[], object]] = queue.Queue()
        super().__init__(cast("Subscription", self.owner), "http://127.0.0.1:1/", 1)

    def _step(self, event: LinkEvent) -> LinkState:
        with self._condition:  # so that two threads tell in the order in which they stepped
            state = super()._step(event)
            self.steps.put((event, state))
            return state

    def _open(self) -> None:
        self.tries.get(timeout=5)()
        self._step(ADDRESS)
        self.tries.get(timeout=5)()

    def _receive(self) -> None:
        self.tries.get(timeout=5)()
        raise ConnectionLost("it broke off")

    def _interrupt(self) -> None:
        self.tries.put(raises(ConnectionLost("interrupted")))

    def took(self, *steps: tuple[LinkEvent, LinkState]) -> None:
        assert [self.steps.get(timeout=5) for _ in steps] == list(steps)


def mismatch() -> Exception:
    return Md5sumMismatch(
        "another one", name="/t", peer="/p", type_name="a/B", md5sum="1", remote_type="a/B", remote_md5sum="2"
    )


def raises(error: Exception) -> Callable[[], object]:
    def fail() -> None:
        raise error

    return fail


def works() -> None: ...


WAY = ((ADDRESS, CONNECTING), (ACCEPTED, RECEIVING))


def test_a_link_goes_by_its_table() -> None:
    """It fails and is refused in each state of work, and is nudged there, and closed."""
    link = Scripted()
    link.start()
    for reached in (0, 1, 2):
        for outcome in [works] * reached + [raises(ConnectionLost("gone"))]:
            link.tries.put(outcome)
        link.took((DUE, REQUESTING), *WAY[:reached], (FAILED, WAITING))
    begin = DUE
    for reached in (0, 1, 2):
        for outcome in [works] * reached + [raises(mismatch())]:
            link.tries.put(outcome)
        link.took((begin, REQUESTING), *WAY[:reached], (NOT_FITTING, REFUSED))
        link.nudge()  # the wait would be 30 s
        begin = NUDGED
    link.took((NUDGED, REQUESTING))
    for step in WAY:
        link.nudge()
        link.took((NUDGED, link.state))
        link.tries.put(works)
        link.took(step)
    link.nudge()
    link.took((NUDGED, RECEIVING))
    link.close()
    assert link.owner.closed.wait(5)
    link.took((WITHDRAWN, CLOSED), (FAILED, CLOSED))
    assert link.closed


def test_a_nudge_at_work_ends_the_wait_after_it() -> None:
    """The publisher may have been restarted since: the next try does not wait as long as it would."""
    link = Scripted()
    link.start()
    link.took((DUE, REQUESTING))
    link.nudge()
    link.tries.put(raises(mismatch()))
    link.took((NUDGED, REQUESTING), (NOT_FITTING, REFUSED), (NUDGED, REQUESTING))
    link.close()
    assert link.owner.closed.wait(5)
