"""The state machine of one motion, as this client knows it: states, events and a table. Pure.

    running     sent, or about to be sent; this client has not asked for its end
    asked       this client has asked for its end, which was not seen yet
    lost        the link is lost; this client has not asked for its end
    not known   the caller was told that the end is not confirmed; the cancel is still due
    ended       its end on the robot was seen, or it was never sent

The events: *ask* (this client asks for its end), *end* (the robot reports it, or the motion cannot be there),
*silent* (the link is lost), and *give up* (the time limit for the confirmation has passed).

The outcome is reported once, on entering one of the last three states. A motion that has not *ended* is under
way for `stop` and `close`. A cancel is due in *asked* and in *not known*: it is written again every second. A
motion that is only *lost* is not cancelled when the robot is heard again (a goal continues without us, as
documented) until this client asks.

Events of several threads are appended to a list in the order in which they came, and the state is computed
from it. Nothing is changed in place, so no lock is needed, and an interrupted frame loses no event.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum


class State(Enum):
    """The state of a motion."""

    RUNNING = "running"
    ASKED = "asked"
    LOST = "lost"
    NOT_KNOWN = "not known"
    ENDED = "ended"

    @property
    def may_go_on(self) -> bool:
        """Whether the outcome was reported although the robot may still be moving."""
        return self in (State.LOST, State.NOT_KNOWN)

    @property
    def end_due(self) -> bool:
        """Whether this client asked for its end and has not seen it."""
        return self in (State.ASKED, State.NOT_KNOWN)


class Event(Enum):
    """An event of a motion."""

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


def state_after(events: Iterable[Event]) -> State:
    """The state that events lead to, in the order in which they came."""
    state = State.RUNNING
    for event in events:
        state = _CELLS[state, event]
    return state
