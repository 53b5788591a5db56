"""What can go wrong with a chassis, as opposed to with ROS (those errors are in `rosproto.errors`).

Every error here says what happened, what was expected and what to do next, and carries the facts as
attributes.
"""

from __future__ import annotations

from rosproto.errors import ConnectionLost, RosError
from rosproto.sentence import both, shown
from woosh_pure.outcome import Outcome, OutcomeKind
from woosh_pure.reasons import Readiness, Reason, ReasonKey

__all__ = ["ChassisError", "FirmwareLimit", "GoalFailed", "MotionRefused", "StaleState"]


class ChassisError(RosError):
    """Base of the errors of the chassis API. Its text is one line, whatever a chassis said that it quotes."""

    def __str__(self) -> str:
        return shown(super().__str__())


class MotionRefused(ChassisError):
    """A motion was not started: the chassis would not, or must not, move now.

    Attributes:
        readiness: Everything that speaks against moving, as known at that moment; None when a
            value of the call itself was the reason.
        said: The chassis's own words, "" when it was not asked or gave none.
        reasons: Why, for programs: those of `readiness`, or one that says what was wrong with the call. Never
            empty.
    """

    exit_code = 3

    def __init__(self, message: str, *, readiness: Readiness | None = None, said: str = "") -> None:
        against = () if readiness is None else readiness.reasons
        key = ReasonKey.CALL if readiness is None else ReasonKey.REFUSED
        self.reasons: tuple[Reason, ...] = against or (Reason(key, message),)
        unsaid = (ReasonKey.UNKNOWN, ReasonKey.REFUSED)  # not known, or what `message` says itself
        super().__init__(both(message, *(reason.text for reason in against if reason.key not in unsaid)))
        self.readiness = readiness
        self.said = said


class FirmwareLimit(ChassisError):
    """The chassis's firmware has no way to be told what was asked for; nothing was sent.

    Attributes:
        name: Topic, service or action.
        fields: What its definition lacks: paths of fields, or names of constants.
        firmware: Which firmware the definition belongs to, as in `woosh sim --firmware`; "" when unknown.
        md5sum: Of the definition that the chassis has.
    """

    def __init__(self, message: str, *, name: str, fields: list[str], firmware: str, md5sum: str) -> None:
        super().__init__(message)
        self.name = name
        self.fields = fields
        self.firmware = firmware
        self.md5sum = md5sum


class StaleState(ChassisError):
    """A value is needed that the chassis has not sent, or not recently enough.

    Attributes:
        topic: Where the value should come from.
        age: Seconds since the last message by our clock, None when there was none.
    """

    def __init__(self, message: str, *, topic: str = "", age: float | None = None) -> None:
        super().__init__(message)
        self.topic = topic
        self.age = age


class GoalFailed(ChassisError):
    """A goal ended in something other than an arrival.

    Attributes:
        outcome: How it ended: kind, code, text, whether the robot is known to stand still.
    """

    def __init__(self, outcome: Outcome) -> None:
        super().__init__(outcome.sentence())
        self.outcome = outcome
        if outcome.kind is OutcomeKind.CONNECTION_LOST:
            self.exit_code = ConnectionLost.exit_code
