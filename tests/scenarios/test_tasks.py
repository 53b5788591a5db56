"""Tasks: the mistakes real programs make, each with the safe outcome."""

from __future__ import annotations

import threading
import time

import pytest

from rosproto.errors import RosTimeout
from woosh_pure import Chassis, GoalFailed, MotionRefused, OutcomeKind, Pose2D, SimulatedChassis, StaleState
from woosh_pure.enums import Direction, RobotMode, RobotState, TaskState, TaskType
from woosh_pure.motion.task import TaskTracker, new_task_id
from woosh_pure.values.state import RobotStatus


def test_going_to_a_mark_ends_there(sim, chassis):
    outcome = chassis.go_to_mark("A1").wait(20.0)
    assert outcome.kind is OutcomeKind.ARRIVED
    assert sim.pose.distance_to(sim.world.site.marks["A1"].pose) < 0.03


@pytest.mark.parametrize("latch", [False, True])
def test_a_stale_completion_of_the_previous_task_is_no_arrival(latch, until):
    with SimulatedChassis(speed=8, full_graph=False, latch_status=latch) as sim:
        with Chassis(sim.master_uri) as first:
            first.go_to_mark("P1").wait(20.0)
        with Chassis(sim.master_uri) as second:
            if latch:
                until(lambda: second.status.heard)
                assert second.status.latest.task_state is TaskState.COMPLETED
            sim.speed = 1.0  # it does not arrive meanwhile
            handle = second.go_to_mark("B1")
            time.sleep(0.2)
            assert not handle.done
            sim.speed = 8.0
            handle.wait(20.0)
            assert sim.pose.distance_to(sim.world.site.marks["B1"].pose) < 0.03


def test_a_completion_that_comes_before_the_reply_is_not_lost():
    with (
        SimulatedChassis(speed=20, full_graph=False, reply_delay=3.0) as sim,
        Chassis(sim.master_uri) as chassis,
    ):
        handle = chassis.go_to_mark("P1")
        assert sim.world.tasks.state is TaskState.COMPLETED
        handle.wait(10.0)


def test_a_failing_task_is_an_error_with_the_chassis_words(sim, chassis):
    sim.fail_task("wheel slips")
    with pytest.raises(GoalFailed, match="wheel slips") as caught:
        chassis.go_to_mark("A1").wait(20.0)
    assert caught.value.outcome.kind is OutcomeKind.FAILED
    assert caught.value.outcome.stopped is True


def test_an_outcome_that_is_no_arrival_is_false_even_when_it_is_not_raised(sim, chassis):
    sim.fail_task()
    outcome = chassis.go_to_mark("A1").wait(20.0, raises=False)
    assert not outcome


def test_a_timeout_cancels_the_task_and_confirms_that_the_robot_stands(sim, real_time, chassis):
    with pytest.raises(GoalFailed) as caught:
        chassis.go_to_mark("B1").wait(0.5)
    assert caught.value.outcome.kind is OutcomeKind.TIMED_OUT
    assert caught.value.outcome.stopped is True
    with sim.lock:
        assert sim.world.tasks.state is TaskState.CANCELLED
        assert sim.world.body.velocity.is_standing()


def test_cancelling_ends_the_task(sim, real_time, chassis):
    handle = chassis.go_to_mark("B1")
    outcome = handle.cancel()
    assert outcome.kind is OutcomeKind.CANCELLED
    assert sim.world.tasks.state is TaskState.CANCELLED


def test_leaving_the_with_block_cancels_what_is_running(sim, real_time, until):
    with Chassis(sim.master_uri) as chassis:
        chassis.go_to_mark("B1")
    until(lambda: sim.world.tasks.state is TaskState.CANCELLED)


def test_leave_running_lets_it_run(sim, real_time):
    with Chassis(sim.master_uri, leave_running=True) as chassis:
        chassis.go_to_mark("B1")
    assert sim.world.tasks.busy


def test_ctrl_c_in_a_wait_stops_the_robot(sim, until):
    with pytest.raises(KeyboardInterrupt), Chassis(sim.master_uri) as chassis:  # noqa: PT012  (out of the block)
        chassis.go_to_mark("B1")
        raise KeyboardInterrupt
    until(lambda: sim.world.body.velocity.is_standing() and not sim.world.tasks.busy)


def test_ctrl_c_while_the_request_is_on_its_way_cancels_the_task_too(until, monkeypatch):
    """The chassis has taken the task, its reply has not come: the interrupted program must still end it."""
    real_join = threading.Thread.join

    def interrupted_join(thread, timeout=None):
        real_join(thread, timeout)
        if (
            thread.name == "woosh:send"
            and threading.current_thread() is threading.main_thread()
            and thread.is_alive()
        ):
            monkeypatch.undo()
            raise KeyboardInterrupt

    with SimulatedChassis(speed=2, full_graph=False, reply_delay=0.5) as sim:
        with pytest.raises(KeyboardInterrupt), Chassis(sim.master_uri) as chassis:  # noqa: PT012
            monkeypatch.setattr(threading.Thread, "join", interrupted_join)
            chassis.go_to_mark("B1")
        until(lambda: sim.world.tasks.state is TaskState.CANCELLED)
        until(lambda: sim.world.body.velocity.is_standing())


@pytest.mark.parametrize(
    ("spoil", "key"),
    [
        (lambda sim: sim.press_emergency_stop(), "emergency_stop"),
        (lambda sim: sim.set_mode(RobotMode.MANUAL), "manual_mode"),
    ],
)
def test_a_refused_task_says_why(sim, chassis, until, spoil, key):
    chassis.status.open()
    chassis.faults  # noqa: B018  (begins to listen)
    until(lambda: chassis.status.publishers and chassis.status_code.publishers)
    spoil(sim)
    until(lambda: any(reason.key == key for reason in chassis.readiness().reasons))
    with pytest.raises(MotionRefused) as caught:
        chassis.go_to_mark("A1")
    assert any(reason.key == key for reason in caught.value.readiness.reasons)
    assert not sim.world.tasks.busy


def test_a_refusal_of_the_chassis_is_an_error_too(sim, chassis):
    with pytest.raises(MotionRefused, match="not known"):
        chassis.go_to_mark("nowhere")
    assert chassis._components.motions.goals == []


def test_an_emergency_stop_ends_the_running_task_as_failed(sim, real_time, chassis, until):
    handle = chassis.go_to_mark("B1")
    until(lambda: not sim.world.body.velocity.is_standing())
    sim.press_emergency_stop()
    with pytest.raises(GoalFailed) as caught:
        handle.wait(10.0)
    assert caught.value.outcome.kind is OutcomeKind.FAILED
    assert caught.value.outcome.stopped is True


def test_a_task_without_a_visible_end_is_not_started():
    with SimulatedChassis(speed=8, full_graph=False) as sim:
        sim.graph.publishers["/ros_interface", "/robot_status"].close()
        with Chassis(sim.master_uri, timeout=3.0) as chassis, pytest.raises(StaleState, match="robot_status"):
            chassis.go_to_mark("A1")
        assert not sim.world.tasks.busy


def test_pause_resume_and_progress(sim, real_time, chassis, until):
    handle = chassis.go_to_mark("B2")
    seen: list[TaskState] = []
    handle.on_progress(lambda _: seen.append(handle.latest_report.task_state))
    handle.pause()
    until(lambda: TaskState.PAUSED in seen)
    handle.resume()
    real_time()
    handle.wait(20.0)
    assert seen[-1] is TaskState.COMPLETED


def test_a_wait_is_interrupted(sim, chassis):
    handle = chassis.go_to_mark("W1")
    chassis.wait_until(lambda s: s.task_state is TaskState.WAITING_FOR_ACTION, timeout=20.0)
    handle.interrupt_wait()
    assert handle.wait(5.0)


def test_charging_carrying_and_parking(sim, chassis):
    chassis.carry("A1", Direction.LOAD).wait(20.0)
    chassis.charge("C1").wait(20.0)
    chassis.wait_until(lambda s: s.robot_state is RobotState.CHARGING, timeout=5.0)
    chassis.battery.wait_for(lambda b: b.charging, timeout=5.0)
    chassis.park("P1").wait(20.0)
    assert chassis.status.latest.task_type is TaskType.PARK


def test_a_task_over_poses_without_a_mark(sim, chassis):
    chassis.task(TaskType.PICK, poses=[Pose2D(1.0, 0.5), Pose2D(2.0, 0.5, 1.0)]).wait(20.0)
    assert sim.pose.distance_to(Pose2D(2.0, 0.5)) < 0.03


def test_two_programs_do_not_throw_each_other_out(sim):
    with Chassis(sim.master_uri) as first, Chassis(sim.master_uri) as second:
        assert first.node.name != second.node.name
        assert first.battery.wait(5.0) is not None
        assert second.battery.wait(5.0) is not None


def test_two_robots_in_one_program():
    with (
        SimulatedChassis(speed=8, full_graph=False) as a,
        SimulatedChassis(speed=8, full_graph=False) as b,
        Chassis(a.master_uri) as first,
        Chassis(b.master_uri) as second,
    ):
        one, two = first.go_to_mark("A1"), second.go_to_mark("A2")
        one.wait(20.0)
        two.wait(20.0)
        assert a.pose.distance_to(b.pose) > 1.0


def test_stop_from_another_thread_ends_the_task(sim, real_time, chassis, until):
    handle = chassis.go_to_mark("B1")
    until(lambda: not sim.world.body.velocity.is_standing())
    reports = []
    thread = threading.Thread(target=lambda: reports.append(chassis.stop()))
    thread.start()
    outcome = handle.wait(10.0, raises=False)
    thread.join(10.0)
    assert outcome.kind is OutcomeKind.CANCELLED
    assert reports[0].standing is True


def test_stop_everything_ends_what_another_program_started(sim, real_time, chassis, until):
    with Chassis(sim.master_uri) as other:
        handle = other.go_to_mark("B1")
        assert not chassis.stop(timeout=1.0).standing
        report = chassis.stop(everything=True)
        assert report.standing is True
        assert handle.wait(5.0, raises=False).kind is OutcomeKind.CANCELLED


def test_a_chassis_that_falls_silent_is_a_lost_connection(sim, real_time, chassis, until, monkeypatch):
    monkeypatch.setattr("woosh_pure.feed.feed._LOST_AFTER", 0.5)
    handle = chassis.go_to_mark("B1")
    chassis.measured_velocity.wait(5.0)
    sim.fall_silent(30.0)
    with pytest.raises(GoalFailed) as caught:
        handle.wait(10.0)
    assert caught.value.outcome.kind is OutcomeKind.CONNECTION_LOST


# -- the tracker alone: every order of reply and status --------------------------------------------------------


def status(task_id: int, state: int, robot_state: int = 4) -> RobotStatus:
    from woosh_pure.enums import ActionState, ActionType, WorkMode

    return RobotStatus(
        task_id, TaskType.PICK, TaskState(state), ActionType.NAVIGATION, ActionState.RUNNING, RobotState(robot_state),
        RobotMode.AUTOMATIC, WorkMode.TASK, 0, "A1", "", 0,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("events", "kind"),
    [
        ([("reply", True), ("status", 5, 3), ("status", 5, 7)], OutcomeKind.ARRIVED),
        ([("status", 5, 3), ("status", 5, 7), ("reply", True)], OutcomeKind.ARRIVED),
        ([("status", 4, 7), ("reply", True)], None),
        ([("reply", True), ("status", 4, 3)], None),
        ([("reply", True), ("status", 5, 3), ("status", 4, 7)], None),
        ([("reply", True), ("status", 5, 3), ("status", 6, 3)], OutcomeKind.REPLACED),
        ([("reply", True), ("status", 5, 8)], OutcomeKind.CANCELLED),
        ([("reply", True), ("status", 5, 9)], OutcomeKind.FAILED),
        ([("reply", True), ("status", 5, -1)], OutcomeKind.FAILED),
        ([("reply", True), ("status", 5, 3, 6)], OutcomeKind.FAILED),
        ([("reply", True), ("status", 5, 42)], None),
        ([("status", 4, 7), ("reply", False)], OutcomeKind.REJECTED),
        ([("reply", True), ("status", 5, 9), ("status", 5, 7)], OutcomeKind.FAILED),
    ],
)
def test_the_tracker_reads_every_order_right(events, kind):
    tracker = TaskTracker(5)
    for what, *values in events:
        if what == "reply":
            tracker.reply(values[0], "", 4)
        else:
            tracker.status(status(*values))
    assert (tracker.ending.kind if tracker.ending else None) is kind


def test_a_state_that_is_not_documented_is_told_by_its_number():
    """The one number that says more than the kind of end does."""
    tracker = TaskTracker(5)
    tracker.status(status(5, -3))
    assert tracker.ending is not None
    assert tracker.ending.text == "the chassis reports task state -3"


def test_a_goal_is_called_by_what_it_does(chassis):
    """Its random number is in `task_id`; a person reads where the robot goes."""
    assert chassis.go_to_mark("P1").wait(30.0).sentence().startswith("drive to P1: arrived after ")
    assert chassis.charge("C1").wait(60.0).description == "drive to C1 and charge"


def test_task_ids_are_not_reused():
    assert len({new_task_id() for _ in range(1000)}) == 1000


def test_waiting_for_a_state_that_does_not_come_ends_in_time(chassis):
    with pytest.raises(RosTimeout, match="on change only"):
        chassis.wait_until(lambda s: s.robot_state is RobotState.MAPPING, timeout=0.3)


def test_a_mark_that_is_not_known_is_answered_by_near_ones_and_the_list(chassis):
    """As the commands answer it; the simulator tells its marks, and the robot's own words stay."""
    with pytest.raises(
        MotionRefused, match=r"did you mean A1.*\?; marks: A1, A2, B1, B2, C1, P1, W1"
    ) as caught:
        chassis.go_to_mark("a1")
    assert caught.value.robot_text == "this mark is not known"
