"""A second motion of one's own: refused with a sentence, or meant."""

from __future__ import annotations

import pytest

from rosproto.errors import ConnectionLost, RosError
from woosh_pure import Chassis, GoalFailed, MotionRefused, OutcomeKind, Pose2D
from woosh_pure.enums import TaskState
from woosh_pure.motion.action_goal import ActionMotion

FIRST = {
    "task": lambda c, **o: c.go_to_mark("B1", **o),
    "navigation": lambda c, **o: c.go_to(2.5, 0.0, **o),
    "steps": lambda c, **o: c.move(2.0, **o),
}
SECOND = {
    **FIRST,
    "park": lambda c, **o: c.park("B1", **o),
    "follow": lambda c, **o: c.follow([Pose2D(0.5, 0.0), Pose2D(1.0, 0.0)], **o),
    "rotate": lambda c, **o: c.rotate(0.5, speed=0.8, **o),
}


@pytest.mark.promise("a second motion while one of ours is under way")
@pytest.mark.parametrize("second", SECOND)
@pytest.mark.parametrize("first", FIRST)
def test_a_second_motion_is_refused_and_the_first_goes_on(sim, real_time, chassis, first, second):
    handle = FIRST[first](chassis)
    with pytest.raises(MotionRefused, match=r"nothing was sent.* is under way.*replace=True") as caught:
        SECOND[second](chassis)
    assert handle.description in str(caught.value)
    assert not handle.done
    assert chassis._components.motions.goals == [handle._motion]


@pytest.mark.promise("a second motion while one of ours is under way")
@pytest.mark.parametrize("second", SECOND)
@pytest.mark.parametrize("first", FIRST)
def test_one_that_is_meant_replaces_it(sim, real_time, chassis, until, first, second):
    handle = FIRST[first](chassis)
    until(lambda: not sim.world.body.velocity.is_standing())
    after = SECOND[second](chassis, replace=True)
    with pytest.raises(GoalFailed, match="this program ended it: replaced by") as caught:
        handle.wait(20.0)
    assert caught.value.outcome.kind is OutcomeKind.REPLACED
    assert after.description in caught.value.outcome.by_us
    if second == "rotate":
        real_time()
        assert after.wait(60.0)
    else:
        until(lambda: not sim.world.body.velocity.is_standing())
        assert after.cancel().kind is OutcomeKind.CANCELLED


def test_a_goal_that_replaces_and_is_not_sent_replaces_nothing(sim, real_time, chassis, monkeypatch):
    handle = chassis.go_to(2.5, 0.0)

    def lost(*_: object) -> None:
        raise ConnectionLost("the network is away")

    with monkeypatch.context() as patch:
        patch.setattr(ActionMotion, "_send_to", lost)
        with pytest.raises(ConnectionLost):
            chassis.go_to(1.0, 0.0, replace=True)
    assert handle.cancel().kind is OutcomeKind.CANCELLED


def test_what_cannot_be_ended_is_not_replaced(sim, real_time, chassis, monkeypatch):
    handle = chassis.go_to_mark("B1")

    def lost(*_: object) -> None:
        raise ConnectionLost("the network is away")

    with monkeypatch.context() as patch:
        patch.setattr(type(handle._motion), "request_cancel", lost)
        with pytest.raises(MotionRefused, match="could not be ended"):
            chassis.move(0.5, replace=True)
    assert not handle.done


def test_what_is_held_moves_nothing_and_does_not_go_on_beside_another(sim, real_time, chassis, until):
    task = chassis.go_to_mark("B1")
    until(lambda: not sim.world.body.velocity.is_standing())
    task.pause()
    chassis.wait_until(lambda status: status.task_state is TaskState.PAUSED, 10.0)
    until(lambda: sim.world.body.velocity.is_standing())
    move = chassis.move(1.0)
    with pytest.raises(MotionRefused, match="is under way"):
        task.resume()
    move.cancel()
    task.resume()
    task.cancel()


def test_two_threads_do_not_both_begin(sim, real_time, chassis):
    from tests.support.doors import in_thread

    chassis.readiness()
    threads = [in_thread(lambda: chassis.go_to(2.5, 0.0)) for _ in range(4)]
    for thread, _ in threads:
        thread.join(20.0)
    refused = [error for _, errors in threads for error in errors]
    assert len(refused) == 3
    assert all(isinstance(error, MotionRefused) for error in refused)


def test_another_program_still_commands_and_the_first_is_told(sim, real_time, chassis):
    handle = chassis.go_to(2.5, 0.0)
    with Chassis(chassis.node.master_uri, name="other") as other:
        other.go_to(1.0, 0.0, check=False)
        with pytest.raises(RosError, match="another client"):
            handle.wait(20.0)
