"""The table of the states of a link to a subscriber, whole; and that a real link walks it."""

from __future__ import annotations

import itertools

import pytest

from rosproto.node.outgoing.subscriber_link_state import OutgoingEvent as Event
from rosproto.node.outgoing.subscriber_link_state import OutgoingState as State
from rosproto.node.outgoing.subscriber_link_state import next_state

ALLOWED = {
    (State.OPENING, Event.FULL): State.OPENING_FULL,
    (State.OPENING, Event.WATCHED): State.SENDING,
    (State.OPENING_FULL, Event.DRAINED): State.OPENING,
    (State.OPENING_FULL, Event.WATCHED): State.BLOCKED,
    (State.SENDING, Event.FULL): State.BLOCKED,
    (State.BLOCKED, Event.DRAINED): State.SENDING,
}


def test_the_way_of_a_link_that_lives() -> None:
    """The header waits, the monitor comes, all is sent; later the socket is full for a while; then the end."""
    state, seen = State.OPENING, []
    for event in (Event.FULL, Event.WATCHED, Event.DRAINED, Event.FULL, Event.DRAINED, Event.ENDED):
        state = next_state(state, event)
        seen.append(state.value)
    assert seen == ["opening, blocked", "blocked", "connected", "blocked", "connected", "closed"]


@pytest.mark.parametrize(("state", "event"), list(itertools.product(State, Event)))
def test_every_pair(state: State, event: Event) -> None:
    """ENDED ends every state, nothing leaves CLOSED, and what is not in the table is a bug."""
    if event is Event.ENDED or state is State.CLOSED:
        assert next_state(state, event) is State.CLOSED
    elif (state, event) in ALLOWED:
        assert next_state(state, event) is ALLOWED[state, event]
    else:
        with pytest.raises(AssertionError):
            next_state(state, event)


def test_who_waits_and_who_is_watched() -> None:
    assert [state for state in State if state.waits] == [State.OPENING_FULL, State.BLOCKED]
    assert [state for state in State if state.watched] == [State.SENDING, State.BLOCKED]
