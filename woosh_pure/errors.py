"""Errors of the chassis (those of ROS are in `rosproto.errors`).

The text of each gives the event, the expectation and the remedy; the facts are attributes.
"""

from __future__ import annotations

from rosproto.deprecation import former_attribute, former_parameters
from rosproto.errors import ConnectionLost, RosError
from rosproto.sentence import both, led, say, shown
from woosh_pure.language import Spoken
from woosh_pure.outcome import Outcome, OutcomeKind
from woosh_pure.reasons import Readiness, Reason, ReasonKey

__all__ = ["ApiRefused", "ChassisError", "FirmwareLimit", "GoalFailed", "MotionRefused", "StaleState"]


class ChassisError(RosError, Spoken):
    """Base of the errors of the chassis API. Its text is one line, also if it quotes the chassis."""

    def __str__(self) -> str:
        return shown(super().__str__())


class MotionRefused(ChassisError):
    """A motion was not started: the chassis would not, or must not, move now.

    Attributes:
        readiness: The readiness at that moment; None if an argument of the call was the reason.
        robot_text: The chassis's own text; "" if it was not asked or gave none.
        reasons: The reasons, for programs: those of `readiness`, or one about the call. Never empty.
    """

    exit_code = 3

    @former_parameters(said="robot_text")
    def __init__(self, message: str, *, readiness: Readiness | None = None, robot_text: str = "") -> None:
        against = () if readiness is None else readiness.reasons
        key = ReasonKey.CALL if readiness is None else ReasonKey.REFUSED
        self.reasons: tuple[Reason, ...] = against or (Reason(key, message),)
        unsaid = (ReasonKey.UNKNOWN, ReasonKey.REFUSED)  # not known, or already in `message`
        super().__init__(both(message, *(reason.text for reason in against if reason.key not in unsaid)))
        self.readiness = readiness
        self.robot_text = robot_text

    said = former_attribute("said", "robot_text")


class FirmwareLimit(ChassisError):
    """The firmware's definition cannot express a value of the call; nothing was sent.

    Attributes:
        name: Topic, service or action.
        fields: Missing parts of its definition: paths of fields, or names of constants.
        firmware: The firmware of the definition, as in `woosh sim --firmware`; "" if unknown.
        md5sum: Of the definition that the chassis has.
    """

    def __init__(self, message: str, *, name: str, fields: list[str], firmware: str, md5sum: str) -> None:
        super().__init__(message)
        self.name = name
        self.fields = fields
        self.firmware = firmware
        self.md5sum = md5sum


class StaleState(ChassisError):
    """The chassis has not sent a required value, or not recently enough.

    Attributes:
        topic: The topic of the value.
        age: Seconds since the last message by our clock, None if there was none.
    """

    def __init__(self, message: str, *, topic: str = "", age: float | None = None) -> None:
        super().__init__(message)
        self.topic = topic
        self.age = age


class GoalFailed(ChassisError):
    """A goal ended in something other than an arrival.

    Attributes:
        outcome: Kind, code, text, and whether the robot is known to stand still.
    """

    def __init__(self, outcome: Outcome) -> None:
        super().__init__(str(outcome))
        self.outcome = outcome
        if outcome.kind is OutcomeKind.CONNECTION_LOST:
            self.exit_code = ConnectionLost.exit_code


class ApiRefused(ChassisError):
    """The robot refused a request of its Robot API.

    Attributes:
        request: Its type.
        robot_text: The robot's own text; "" if it gave none.
        status: Of HTTP: 401 if the robot wants a name and a password.
    """

    exit_code = 3

    def __init__(self, request: str, robot_text: str, why: str = "", *, status: int = 200) -> None:
        why = why or robot_text or "the robot gave no reason"
        super().__init__(led(say("{request} was refused", request=request), why))
        self.request, self.robot_text, self.status = request, robot_text, status
