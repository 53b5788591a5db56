"""Steps: which one a report is about, and what remains."""

from __future__ import annotations

import math

import pytest

from woosh_pure.enums import StepMode
from woosh_pure.motion.steps import MAX_ANGLE, Step, check_steps, locate_step, radians_of

S, R, L, D = StepMode.STRAIGHT, StepMode.ROTATE, StepMode.LATERAL, StepMode.DIAGONAL
SQUARE = [Step.straight(1.0), Step.turn(1.0), Step.straight(2.0), Step.lateral(0.5)]


@pytest.mark.parametrize(
    ("index", "percent", "mode", "reported", "expected"),
    [
        (0, 20.0, S, 30.0, (0, 30.0)),
        (0, 20.0, S, 18.0, (0, 18.0)),  # a little back is the same step
        (0, 90.0, R, 5.0, (1, 5.0)),
        (0, 90.0, S, 5.0, (2, 5.0)),  # the turn between was over before it was reported
        (1, 50.0, L, 10.0, (3, 10.0)),
        (2, 10.0, S, 100.0, (2, 100.0)),
        (3, 50.0, L, 10.0, (3, 10.0)),  # nothing of this kind is left: what it says
        (2, 50.0, R, 10.0, (2, 50.0)),  # an earlier kind, late: nothing changes
        (2, 50.0, D, 10.0, (2, 50.0)),
    ],
)
def test_a_report_is_of_the_step_under_way_or_of_the_next_of_its_kind(
    index, percent, mode, reported, expected
):
    assert locate_step(SQUARE, index, percent, mode, reported) == expected


def test_the_same_kind_twice_is_told_apart_by_beginning_anew():
    twice = [Step.straight(1.0), Step.straight(1.0)]
    assert locate_step(twice, 0, 95.0, S, 3.0) == (1, 3.0)


@pytest.mark.parametrize("step", [Step.straight(-2.0, 0.3), Step.diagonal(1.0, 0.5), Step.turn(-1.0)])
def test_what_remains_keeps_kind_direction_and_speed(step):
    rest = step.rest(75.0)
    assert rest.data == pytest.approx(step.data * 0.25)
    assert (rest.mode, rest.speed, rest.angle) == (step.mode, step.speed, step.angle)
    assert step.rest(120.0).data == 0.0


@pytest.mark.parametrize(
    ("step", "match"),
    [
        (Step.lateral(11.0), "10.0 m"),
        (Step.diagonal(1.0, math.nan), "finite"),
        (Step.turn(63.0), "62.8318"),
        (Step.straight(1.0, -0.1), "positive"),
        (Step(StepMode(9), 1.0), "not known"),
    ],
)
def test_what_the_interface_does_not_take_is_refused(step, match):
    with pytest.raises(ValueError, match=match):
        check_steps([Step.straight(0.1), step])


def test_a_step_of_nothing_is_a_step_beside_one_that_moves():
    """As in a way that is computed; alone it would only end the goal of somebody else."""
    check_steps([Step.straight(0.0), Step.turn(0.1)])
    with pytest.raises(ValueError, match="the way is 0"):
        check_steps([Step.straight(-0.0), Step.turn(0.0)])


@pytest.mark.parametrize(
    ("degrees", "radians"), [(-90, -math.pi / 2), (400, 6.98131701), (-3600, -MAX_ANGLE)]
)
def test_degrees_of_a_turn_may_be_ten_turns(degrees: float, radians: float) -> None:
    """Who says degrees means them, so `several_turns` is for radians alone, as with `woosh rotate 400`."""
    assert radians_of(degrees) == pytest.approx(radians)
    check_steps([Step.turn(radians_of(degrees))])
    for wrong, text in ((3601, "ten turns"), (math.inf, "ten turns"), (math.nan, "finite")):
        with pytest.raises(ValueError, match=text):
            check_steps([Step.turn(radians_of(wrong))])
