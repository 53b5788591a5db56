"""The life of one motion as this client knows it: states, events, and the table between them. Pure.

    running     sent, or about to be; nobody here has asked for its end
    asked       its end is wanted, and was not seen
    lost        nothing is heard of it any more; nobody asked for its end
    not known   the caller was told that the end is not confirmed; the cancel stays due
    ended       seen to have ended on the robot, or never sent

The events: *ask* (this client wants its end), *end* (the robot tells of it, or it cannot be there), *silent*
(its link is lost), and *give up* (the time to wait for the confirmation is over).

An outcome is told once, on the way into one of the last three states. Whoever has not *ended* is under way
for `stop` and `close`. A cancel is due in *asked* and in *not known*: it is written again every second. One
that is only *lost* is left alone when the robot is heard again (a goal goes on without us, as documented),
until somebody asks.

Events of several threads are kept in the order in which they came, and the state is what they lead to:
nothing is changed in place, so no lock is needed, and none of them is lost over an interrupted frame.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum


class State(Enum):
    """Where a motion is."""

    RUNNING = "running"
    ASKED = "asked"
    LOST = "lost"
    NOT_KNOWN = "not known"
    ENDED = "ended"

    @property
    def told(self) -> bool:
        """Whether its outcome has been told."""
        return self not in (State.RUNNING, State.ASKED)

    @property
    def may_go_on(self) -> bool:
        """Whether the outcome was told although the robot may still carry it out."""
        return self in (State.LOST, State.NOT_KNOWN)

    @property
    def end_due(self) -> bool:
        """Whether its end was asked for and has not been seen."""
        return self in (State.ASKED, State.NOT_KNOWN)


class Event(Enum):
    """What happens to it."""

    ASK = "ask"
    END = "end"
    SILENT = "silent"
    GIVE_UP = "give up"


_TABLE = """
           ask        end    silent     give up
running    asked      ended  lost       not_known
asked      .          ended  not_known  not_known
lost       not_known  ended  .          .
not_known  .          ended  .          .
ended      .          .      .          .
"""


def _read(table: str) -> dict[tuple[State, Event], State]:
    _, *rows = table.strip().splitlines()
    cells = {}
    for row in rows:
        state, *following = row.split()
        for event, cell in zip(Event, following, strict=True):
            cells[State[state.upper()], event] = State[(state if cell == "." else cell).upper()]
    return cells


_CELLS = _read(_TABLE)


def next_state(state: State, event: Event) -> State:
    """The state after an event."""
    return _CELLS[state, event]


def state_after(events: Iterable[Event]) -> State:
    """The state that events lead to, in the order in which they came."""
    state = State.RUNNING
    for event in events:
        state = _CELLS[state, event]
    return state
