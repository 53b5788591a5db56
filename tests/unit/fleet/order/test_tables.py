"""The tables of the order machine: each pair of a state and an event is looked at."""

from __future__ import annotations

from itertools import product

import pytest

from woosh_pure.fleet.order.tables import (
    PREVENTED_ACTIVITIES,
    ActionStatus,
    Activity,
    Hold,
    Motion,
    MotionEvent,
    OrderEvent,
    OrderPhase,
    may_become,
    next_motion,
    next_phase,
)


def followers(motion: Motion) -> set[Motion]:
    found = set()
    for event in MotionEvent:
        try:
            found.add(next_motion(motion, event))
        except AssertionError:
            pass
    return found


def test_a_stand_is_only_what_was_measured_with_nothing_under_way() -> None:
    """No end of a drive, and no stop, says that the vehicle stands."""
    for motion, event in product(Motion, MotionEvent):
        try:
            after = next_motion(motion, event)
        except AssertionError:
            continue
        if after is Motion.STANDING:
            assert event is MotionEvent.STOOD
            assert motion in (Motion.SETTLING, Motion.STANDING)


def test_from_an_end_that_is_not_known_only_an_answered_stop_leads_on() -> None:
    """Nothing is driven before."""
    assert followers(Motion.UNKNOWN) == {Motion.UNKNOWN, Motion.STOPPING}
    assert followers(Motion.STOPPING) == {Motion.STOPPING, Motion.UNKNOWN, Motion.SETTLING}
    assert next_motion(Motion.STOPPING, MotionEvent.STOPPED) is Motion.SETTLING


@pytest.mark.parametrize("motion", Motion)
def test_what_is_measured_and_an_end_that_is_not_known_may_come_at_any_time(motion: Motion) -> None:
    """They come from outside; they are never a bug of ours."""
    for event in (MotionEvent.MOVED, MotionEvent.STOOD, MotionEvent.NOT_KNOWN):
        assert next_motion(motion, event) in Motion


@pytest.mark.parametrize("motion", [each for each in Motion if each is not Motion.DRIVING])
def test_only_a_drive_under_way_is_halted(motion: Motion) -> None:
    """And a halt of anything else is a bug of ours."""
    with pytest.raises(AssertionError, match=motion.name):
        next_motion(motion, MotionEvent.HALT)


def test_an_order_that_ends_is_not_replaced() -> None:
    """A new one is taken when nothing of the old one is under way."""
    with pytest.raises(AssertionError):
        next_phase(OrderPhase.ENDING, OrderEvent.TAKEN)
    assert next_phase(OrderPhase.ENDING, OrderEvent.GIVEN_UP) is OrderPhase.ENDING
    assert next_phase(OrderPhase.ENDING, OrderEvent.OVER) is OrderPhase.CLOSED
    assert next_phase(OrderPhase.CLOSED, OrderEvent.TAKEN) is OrderPhase.OPEN


@pytest.mark.parametrize("status", ActionStatus)
def test_an_action_that_has_ended_stays_so_and_one_that_began_never_waits_again(status: ActionStatus) -> None:
    """So none begins twice."""
    assert not (status.final and any(may_become(status, each) for each in ActionStatus))
    assert not may_become(status, ActionStatus.WAITING)
    assert status.final or may_become(status, ActionStatus.FAILED)


def test_every_hold_keeps_the_vehicle_from_driving() -> None:
    """All holds halt a drive, except a failing disk and those that cannot occur during a drive."""
    assert set(PREVENTED_ACTIVITIES) == set(Hold)
    assert all(Activity.START_DRIVE in what for what in PREVENTED_ACTIVITIES.values())
    silent = {hold for hold in Hold if Activity.CONTINUE_DRIVE not in PREVENTED_ACTIVITIES[hold]}
    assert silent == {Hold.FAILED, Hold.UNKNOWN_MOTION, Hold.DISK}
    assert set(Activity) - {Activity.CONTINUE_DRIVE} == PREVENTED_ACTIVITIES[Hold.DISK]
