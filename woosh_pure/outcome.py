"""The outcome of a goal. Only ARRIVED is success."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from rosproto.sentence import advice, both, say, shown
from woosh_pure.faults import with_words
from woosh_pure.hints import OUTCOME, Hints
from woosh_pure.language import Spoken

__all__ = ["ENDED_EARLY", "NOT_CONFIRMED", "Outcome", "OutcomeKind", "end_is_known"]

ENDED_EARLY = "woosh_pure.ended_early"
"""The logger of goals that were cancelled because their Chassis or program ended."""
NOT_CONFIRMED = "cancelled, but the chassis has not confirmed it"
"""Text of an outcome: the robot may not have heard the cancel."""


class OutcomeKind(Enum):
    """The ways a goal can end."""

    ARRIVED = "arrived"
    FAILED = "failed"
    CANCELLED = "cancelled"
    REJECTED = "rejected"
    REPLACED = "replaced"
    TIMED_OUT = "timed out"
    CONNECTION_LOST = "connection lost"

    def __str__(self) -> str:
        """Its words."""
        return self.value


@dataclass(frozen=True, slots=True)
class Outcome(Spoken, Hints):
    """How a goal ended.

    Attributes:
        kind: The kind of end.
        description: The goal in words ("drive to A1", "straight 0.5 m").
        text: The chassis's own text, or ours if it gave none.
        code: Its number in the interface, None when there was none: `task_state` or `robot_state` of
            /robot_status, the `result` of steps, or the status of an action goal. It is not a status code.
        stopped: Whether the robot is known to stand still: True, False (it still moves), None (not known).
        seconds: From sending to the end, our clock.
        by_us: Why this program cancelled it ("cancel() was called", "its wait was interrupted" ...), or
            replaced it; "" when it did not.
    """

    _hints = OUTCOME

    kind: OutcomeKind
    description: str
    text: str = ""
    code: int | None = None
    stopped: bool | None = None
    seconds: float = 0.0
    by_us: str = ""

    @property
    def arrived(self) -> bool:
        """True only for success."""
        return self.kind is OutcomeKind.ARRIVED

    def __bool__(self) -> bool:
        """Same as `arrived`, so that `if handle.wait(raises=False):` cannot read a failure as success."""
        return self.arrived

    def __str__(self) -> str:
        """Return one sentence for people: the goal, its end, the reason and the next step."""
        how = "{goal}: {kind} after {seconds:.1f} s"
        parts: list[str] = [say(how, goal=self.description, kind=self.kind, seconds=self.seconds)]
        if self.text not in ("", self.kind.value):
            parts.append(with_words(self.text))
        if not self.arrived:
            if self.kind is not OutcomeKind.REPLACED or self.stopped:
                parts.append(say(_STOPPED[self.stopped]))
            ours = say("this program ended it: {why}", why=say(self.by_us))
            parts.append(ours if self.by_us else say(_NEXT[self.kind]))
        return shown(both(*parts))  # the chassis's text must not begin a line


_STOPPED = {
    True: "the robot stands still",
    False: "THE ROBOT IS STILL MOVING: use its emergency stop button",
    None: "whether it stands still is not known",
}

_NEXT = {
    OutcomeKind.FAILED: advice("see chassis.readiness() and chassis.faults", key="readiness-and-faults"),
    OutcomeKind.CANCELLED: "this program did not cancel it: the robot itself did, another client, or our "
    "watchdog while this program did not run",
    OutcomeKind.REJECTED: advice("see chassis.readiness() for what is in the way", key="readiness"),
    OutcomeKind.REPLACED: "another client commands this robot now, and may move it; only one should",
    OutcomeKind.TIMED_OUT: "it was cancelled; give a longer timeout if it was on its way",
    OutcomeKind.CONNECTION_LOST: "check the network; the robot may continue with its last command",
}


def end_is_known(outcome: Outcome) -> bool:
    """Whether a goal has ended for certain: False if the chassis may go on with it, because the link was lost
    or the cancel was not confirmed."""
    open_ended = (OutcomeKind.CONNECTION_LOST, OutcomeKind.TIMED_OUT)
    return outcome.kind not in open_ended and outcome.text != NOT_CONFIRMED
