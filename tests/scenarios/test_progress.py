"""`handle.progress`, the same for every verb: percent, metres left, seconds and pose; None for what is not known."""

from __future__ import annotations

import pytest

from woosh_pure import Chassis
from woosh_pure.motion import Progress
from woosh_pure.motion.steps import Step


@pytest.mark.parametrize("verb", ["go_to_mark", "go_to", "follow", "move", "steps"])
def test_metres_left_fall_to_nothing_and_percent_rises(sim, real_time, chassis, until, verb) -> None:
    place = sim.marks["A1"]
    begin = {
        "go_to_mark": lambda: chassis.go_to_mark("A1"),
        "go_to": lambda: chassis.go_to(place.x, place.y),
        "follow": lambda: chassis.follow([sim.pose, place]),
        "move": lambda: chassis.move(1.5),
        "steps": lambda: chassis.steps([Step.straight(0.7), Step.turn(0.5), Step.straight(0.8)]),
    }
    handle = begin[verb]()
    until(lambda: handle.progress.metres_left is not None and handle.progress.pose is not None)
    first = handle.progress
    assert isinstance(first, Progress)
    assert 0.0 <= first.percent < 40.0
    assert 1.2 < first.metres_left < 4.5
    until(lambda: handle.progress.metres_left < 0.6 * first.metres_left, 20.0)
    there = handle.progress
    assert there.percent > first.percent + 20.0
    assert there.seconds > first.seconds
    real_time()
    outcome = handle.wait(30.0)
    assert (handle.progress.percent, handle.progress.metres_left) == (100.0, 0.0)
    assert handle.progress.seconds == outcome.seconds


def test_the_rest_of_a_way_is_about_what_the_robot_still_drives(sim, real_time, chassis, until) -> None:
    """Around the pillars, not through them."""
    handle = chassis.go_to_mark("B1")
    until(lambda: sim.pose.x > 1.0 and handle.progress.metres_left)
    driven, left = sim.world.body.distance, handle.progress.metres_left
    real_time()
    handle.wait(40.0)
    assert sim.world.body.distance - driven == pytest.approx(left, rel=0.15)


def test_what_is_not_known_is_none(sim, real_time, chassis) -> None:
    """A turn has no metres; a goal that has failed did not come to its end."""
    turn = chassis.left(40)
    assert turn.progress.metres_left == 0.0
    chassis.stop()
    assert turn.progress.percent < 100.0


def test_progress_is_read_after_the_chassis_was_closed(sim) -> None:
    with Chassis(sim.master_uri) as chassis:
        handle = chassis.go_to_mark("B1")
    assert handle.progress.percent is None or handle.progress.percent < 100.0
    assert handle.progress.seconds == handle.outcome.seconds


def test_the_old_name_of_a_report_warns(sim, chassis) -> None:
    handle = chassis.move(0.1)
    handle.wait(20.0)
    with pytest.deprecated_call(match="latest_report"):
        assert handle.latest_progress is handle.latest_report


def test_a_drive_that_has_ended_does_not_listen_to_paths_any_more(sim, chassis) -> None:
    """A vehicle that makes thousands of drives would keep a callback of each."""
    heard = chassis._components.feeds.get("plan")._callbacks
    for _ in range(3):
        handle = chassis.go_to_mark("A1")
        assert len(heard) == 1
        handle.cancel()
        assert not heard
