"""`Step`: one element of a /cmd_vel_control goal, checked against the limits of the interface. Pure."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from rosproto.codec import DynamicMessage
from rosproto.coercion import require_number
from rosproto.sentence import advice, both, say
from woosh_pure.enums import StepControlMode, StepMode
from woosh_pure.geometry import Velocity
from woosh_pure.values.messages import message_type

MAX_DISTANCE = 10.0
"""Longest straight, lateral or diagonal step, m (vendor's page)."""
MAX_ANGLE = 62.8318
"""Largest turn of one step, rad (vendor's page)."""
MAX_SPEED = 3.0
"""m/s. No such base drives this fast, so a larger number must be in another unit (our own bound)."""
MAX_TURN_RATE = 6.2832
"""rad/s; as `MAX_SPEED`."""
_NOISE = 5.0  # percent by which a step may seem to go back


@dataclass(frozen=True, slots=True)
class Step:
    """A straight, turning, lateral or diagonal move.

    Attributes:
        mode: Which of the four.
        data: m or rad; forward, left and counter-clockwise positive.
        speed: Highest speed, m/s or rad/s; 0 takes the chassis's default (0.2 m/s, 0.1 rad/s).
        angle: Direction of a diagonal move in rad, left of forward positive.
    """

    mode: StepMode
    data: float
    speed: float = 0.0
    angle: float = 0.0

    def __post_init__(self) -> None:
        way = "angle" if self.mode is StepMode.ROTATE else "distance"
        for name, called in (("data", way), ("speed", "speed"), ("angle", "angle")):
            object.__setattr__(self, name, require_number(getattr(self, name), called))

    @classmethod
    def straight(cls, distance: float, speed: float = 0.0) -> Step:
        """`distance` m forward (negative: backward)."""
        return cls(StepMode.STRAIGHT, distance, speed)

    @classmethod
    def turn(cls, angle: float, speed: float = 0.0) -> Step:
        """`angle` rad counter-clockwise."""
        return cls(StepMode.ROTATE, angle, speed)

    @classmethod
    def lateral(cls, distance: float, speed: float = 0.0) -> Step:
        """`distance` m to the left; a differential base refuses it."""
        return cls(StepMode.LATERAL, distance, speed)

    @classmethod
    def diagonal(cls, distance: float, angle: float, speed: float = 0.0) -> Step:
        """`distance` m in the direction `angle` rad left of forward; a differential base refuses it."""
        return cls(StepMode.DIAGONAL, distance, speed, angle)

    @property
    def highest_speed(self) -> float:
        """The given speed, or the chassis's default."""
        return abs(self.speed) or (0.1 if self.mode is StepMode.ROTATE else 0.2)

    @property
    def expected_seconds(self) -> float:
        """Approximate duration without obstacles, s."""
        return abs(self.data) / self.highest_speed + 2.0

    @property
    def in_range(self) -> bool:
        """Whether `data` is within the interface's limits."""
        return abs(self.data) <= (MAX_ANGLE if self.mode is StepMode.ROTATE else MAX_DISTANCE)

    def direction(self) -> Velocity:
        """Unit velocity of this step, signed."""
        sign = math.copysign(1.0, self.data)
        if self.mode is StepMode.ROTATE:
            return Velocity(0.0, 0.0, sign)
        angle = {StepMode.LATERAL: math.pi / 2, StepMode.DIAGONAL: self.angle}.get(self.mode, 0.0)
        return Velocity(sign * math.cos(angle), sign * math.sin(angle), 0.0)

    def rest(self, percent: float) -> Step:
        """The rest of the step after `percent` of it."""
        return Step(
            self.mode, self.data * (1.0 - min(max(percent, 0.0), 100.0) / 100.0), self.speed, self.angle
        )

    def __str__(self) -> str:
        if self.mode is StepMode.ROTATE:
            return say("turn {degrees:.1f}°", degrees=math.degrees(self.data))
        if self.mode is StepMode.DIAGONAL:
            toward = math.degrees(self.angle)
            return say("diagonal {metres:.3f} m at {degrees:.1f}°", metres=self.data, degrees=toward)
        if self.mode is StepMode.LATERAL:
            return say("lateral {metres:.3f} m", metres=self.data)
        return say("straight {metres:.3f} m", metres=self.data)


def radians_of(degrees: float) -> float:
    """A turn in rad.

    Raises:
        ValueError: It is more than one step may have.
    """
    given = require_number(degrees, "angle")
    if abs(given) > 3600.0:
        text = "{degrees:g}° is more than the 3600° (ten turns) that one step may have"
        raise ValueError(say(text, degrees=given))
    turn = math.radians(given)
    return math.copysign(MAX_ANGLE, given) if abs(turn) > MAX_ANGLE else turn  # it rounds ten turns down


def check_steps(steps: Iterable[Step]) -> tuple[Step, ...]:
    """The steps, checked against the interface's limits.

    Raises:
        ValueError: A number is not finite, out of range, or there are no steps, or none that moves.
    """
    checked = tuple(steps)
    for step in checked:
        if not isinstance(step, Step):
            raise TypeError(
                say("{step!r} is not a Step; use Step.straight(0.5), Step.turn(1.57) ...", step=step)
            )
    if not checked:
        raise ValueError("no steps given; a goal needs at least one")
    if not any(step.data for step in checked):
        raise ValueError("the way is 0: it would only end another program's goal; to end that, use stop")
    for step in checked:
        _check(step)
    return checked


def check_goal(goal: DynamicMessage) -> None:
    """Check the steps of a woosh_msgs/StepControlGoal, as `check_steps` does."""
    steps = goal.stepControl
    check_steps(Step(StepMode(s.executeMode), s.data, s.speed, getattr(s, "angle", 0.0)) for s in steps)


def locate_step(
    steps: Sequence[Step], index: int, percent: float, mode: StepMode, reported: float
) -> tuple[int, float]:
    """Find the step of a report, which names the kind of step but not its number.

    Steps are done in order. A report of the same kind belongs to the same step unless its percentage starts
    again. In that case, or if the kind differs, it belongs to the next step of that kind (a step in between
    may have been too short for a report).

    Args:
        steps: All steps of the goal.
        index: Index by the last report.
        percent: Percentage in the last report.
        mode: Kind of step in the new report.
        reported: Percentage in the new report.

    Returns:
        Index and percentage now; unchanged when the report fits no step.
    """
    if mode == steps[index].mode and reported >= percent - _NOISE:
        return index, reported
    for later in range(index + 1, len(steps)):
        if steps[later].mode == mode:
            return later, reported
    return (index, reported) if mode == steps[index].mode else (index, percent)


def step_goal(mode: StepControlMode, steps: Sequence[Step], avoid: bool) -> DynamicMessage:
    """woosh_msgs/StepControlGoal."""
    goal = message_type("woosh_msgs/StepControlGoal")()
    goal.mode, goal.useAvoid = int(mode), avoid
    step_class = message_type("woosh_msgs/StepControl")
    goal.stepControl = [
        step_class(executeMode=int(s.mode), data=s.data, speed=s.highest_speed, angle=s.angle) for s in steps
    ]
    return goal


def _check(step: Step) -> None:
    if not all(map(math.isfinite, (step.data, step.speed, step.angle))):
        raise ValueError(say("{step}: every number must be finite", step=step))
    rotating = step.mode is StepMode.ROTATE
    maximum, unit = (MAX_ANGLE, "rad") if rotating else (MAX_DISTANCE, "m")
    if not step.in_range:
        far = advice("use go_to for longer distances", key="far")
        hint = "for degrees, pass degrees=True" if rotating else far
        long = say(
            "{way} {unit} is more than the {maximum} {same} one step may have",
            way=step.data,
            unit=unit,
            maximum=maximum,
            same=unit,
        )
        raise ValueError(both(long, say(hint)))
    if step.mode is StepMode.DIAGONAL and abs(step.angle) > 2.0 * math.pi + 1e-6:
        raise ValueError(
            say("angle {angle:g} rad is more than one turn; for degrees, pass degrees=True", angle=step.angle)
        )
    fastest, per_second = (MAX_TURN_RATE, "rad/s") if rotating else (MAX_SPEED, "m/s")
    if step.speed > fastest:
        raise ValueError(
            say(
                "speed {speed:g} is more than {fastest:g} {unit}; is it in another unit?",
                speed=step.speed,
                fastest=fastest,
                unit=per_second,
            )
        )
    if step.speed < 0.0:
        raise ValueError(
            say(
                "speed {speed}: give a positive speed; the sign of the distance gives the direction",
                speed=step.speed,
            )
        )
    if not step.mode.known or step.mode not in tuple(StepMode):
        raise ValueError(say("step mode {mode} is not known; expected 1 to 4", mode=int(step.mode)))
