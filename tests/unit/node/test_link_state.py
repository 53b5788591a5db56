"""The states of a link to one publisher."""

from __future__ import annotations

import pytest

from rosproto.node.link_state import LinkEvent, LinkState, next_state, refused_backoff, retry_backoff


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
    retry, refused = retry_backoff(), refused_backoff()
    assert max(retry.next() for _ in range(50)) < 0.8
    assert 4.0 <= [refused.next() for _ in range(10)][-1] <= 6.0
