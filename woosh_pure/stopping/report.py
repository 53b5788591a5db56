"""What a stop has done, in words and as facts."""

from __future__ import annotations

from dataclasses import dataclass, field

from rosproto.sentence import both, say, shown


@dataclass(slots=True)
class StopReport:
    """What `stop` did.

    Attributes:
        standing: True when the measured velocity is zero, False when the robot still moves, None when not
            known.
        cancelled: What was cancelled, in words.
        problems: What could not be done, in words.
        looked: Whether goals and tasks of others were looked for, too.
        pending: What was asked to end and has not been seen to: it is asked again every second, until it is,
            or until this Chassis is closed.
    """

    standing: bool | None = None
    cancelled: list[str] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)
    looked: bool = False
    pending: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        """`sentence()`."""
        return self.sentence()

    def sentence(self) -> str:
        """One sentence for people."""
        state = {
            True: "the robot stands still",
            False: "THE ROBOT STILL MOVES: use its emergency stop button",
            None: "whether the robot stands still is not known: watch it",
        }[self.standing]
        parts = [say(state)]
        if self.cancelled:
            parts.append(say("cancelled {what}", what=self.cancelled))
        elif not self.problems:
            parts.append(say("nothing was running" if self.looked else "nothing of ours was running"))
        if self.problems:
            parts.append(say("not done: {what}", what=both(*self.problems)))
        if self.pending:
            parts.append(say("asked again until it is seen to end: {what}", what=self.pending))
        return shown(both(*parts))
