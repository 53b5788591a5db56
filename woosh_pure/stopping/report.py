"""The result of a stop: `StopReport`, and its sentence."""

from __future__ import annotations

from dataclasses import dataclass, field

from rosproto.sentence import both, say, shown
from woosh_pure.hints import STOP, Hints
from woosh_pure.language import Spoken


@dataclass(slots=True)
class StopReport(Spoken, Hints):
    """The result of `stop`.

    Attributes:
        standing: True if the measured velocity is zero, False if the robot still moves, None if not known.
        cancelled: Descriptions of what was cancelled.
        problems: A sentence for each step that failed.
        looked: Whether goals and tasks of other clients were cancelled, too.
        pending: Motions whose end was requested and not seen yet; the request is repeated every second until
            the end is seen or this Chassis is closed.
    """

    _hints = STOP

    standing: bool | None = None
    cancelled: list[str] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)
    looked: bool = False
    pending: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        """Return the report as one sentence."""
        state = {
            True: "the robot stands still",
            False: "THE ROBOT IS STILL MOVING: use its emergency stop button",
            None: "whether the robot stands still is not known: watch it",
        }[self.standing]
        parts = [say(state)]
        if self.cancelled:
            parts.append(say("cancelled {what}", what=self.cancelled))
        elif not self.problems:
            parts.append(say("nothing was running" if self.looked else "nothing of this program was running"))
        if self.problems:
            parts.append(say("not done: {what}", what=both(*self.problems)))
        if self.pending:
            parts.append(say("asked again until its end is seen: {what}", what=self.pending))
        return shown(both(*parts))
