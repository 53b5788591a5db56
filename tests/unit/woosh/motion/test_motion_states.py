"""The life of a motion: every cell of its table, and what holds for any order of events."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from woosh_pure.motion.motion import Event, State, state_after

CELLS = {
    State.RUNNING: (State.ASKED, State.ENDED, State.LOST, State.NOT_KNOWN),
    State.ASKED: (State.ASKED, State.ENDED, State.NOT_KNOWN, State.NOT_KNOWN),
    State.LOST: (State.NOT_KNOWN, State.ENDED, State.LOST, State.LOST),
    State.NOT_KNOWN: (State.NOT_KNOWN, State.ENDED, State.NOT_KNOWN, State.NOT_KNOWN),
    State.ENDED: (State.ENDED,) * 4,
}
"""After ask, end, silent, give up."""
WAYS = {
    State.RUNNING: [],
    State.ASKED: [Event.ASK],
    State.LOST: [Event.SILENT],
    State.NOT_KNOWN: [Event.GIVE_UP],
    State.ENDED: [Event.END],
}
"""Events that lead to each state."""
HISTORIES = st.lists(st.sampled_from(Event))


@pytest.mark.parametrize(
    ("state", "event", "after"),
    [
        (state, event, after)
        for state, row in CELLS.items()
        for event, after in zip((Event.ASK, Event.END, Event.SILENT, Event.GIVE_UP), row, strict=True)
    ],
)
def test_every_cell(state: State, event: Event, after: State) -> None:
    assert state_after([*WAYS[state], event]) is after


def test_every_state_is_in_the_table_once() -> None:
    assert set(CELLS) == set(State)


@given(HISTORIES)
def test_who_asked_is_not_forgotten_until_the_end_is_seen(events: list[Event]) -> None:
    state = state_after(events)
    assert (state is State.ENDED) == (Event.END in events)
    assert state.end_due == (
        Event.END not in events and (Event.ASK in events or Event.GIVE_UP in events) and not _lost(events)
    )


def _lost(events: list[Event]) -> bool:
    """Lost before anybody gave up, and never asked to end."""
    others = [event for event in events if event is not Event.END]
    return Event.ASK not in others and others[:1] == [Event.SILENT]


@given(HISTORIES, st.sampled_from(Event))
def test_what_was_told_stays_told(events: list[Event], event: Event) -> None:
    before, after = state_after(events), state_after([*events, event])
    told = (State.LOST, State.NOT_KNOWN, State.ENDED)
    assert after in told or before not in told
    assert before.may_go_on or before is State.ENDED or before not in told


@given(HISTORIES)
def test_a_motion_is_due_or_left_alone_or_over(events: list[Event]) -> None:
    state = state_after(events)
    assert state.end_due or state in (State.RUNNING, State.LOST, State.ENDED)
