"""The states of a link to one publisher."""

from __future__ import annotations

import pytest

from rosproto.node.incoming.link_state import LinkEvent, LinkState, Pauses, next_state


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
    pauses = Pauses()
    assert max(pauses.after(None) for _ in range(50)) < 0.8
    assert 4.0 <= [pauses.after(None, refused=True) for _ in range(10)][-1] <= 6.0


def test_sessions_that_end_at_once_are_no_success() -> None:
    """A publisher that agrees and breaks off is tried every few seconds at last; one that stayed, at once."""
    pauses = Pauses()
    assert pauses.after(0.0) < 0.1
    brief = [pauses.after(0.01) for _ in range(50)]
    assert 4.0 <= brief[-1] <= 6.0
    assert sum(brief[:12]) > 20  # it was 23 a second
    assert pauses.after(60.0) < 0.1


def test_another_definition_is_not_asked_again_and_again() -> None:
    """Each try is a warning in the publisher's log: one in the first 20 seconds, as with rospy."""
    pauses = Pauses()
    assert pauses.after(None, mismatch=True) > 20
    assert max(pauses.after(0.1, mismatch=True) for _ in range(20)) <= 360
    assert pauses.after(60.0, mismatch=True) < 40
