"""Addresses, marks, readiness, steps, limits, outcomes: pure values of the chassis API."""

from __future__ import annotations

import math

import pytest

from woosh_pure.connection.arguments import master_uri_of
from woosh_pure.enums import (
    ActionState,
    ActionType,
    RobotMode,
    RobotState,
    StepMode,
    TaskState,
    TaskType,
    WorkMode,
)
from woosh_pure.faults import decode_status_code
from woosh_pure.geometry import Pose2D, Velocity
from woosh_pure.maps.marks import MarkFile
from woosh_pure.motion.steps import Step, check_steps
from woosh_pure.outcome import Outcome, OutcomeKind
from woosh_pure.readiness.readiness_state import assess
from woosh_pure.values.state import RobotStatus
from woosh_pure.velocity.shaper import DriveLimits, Shaper


@pytest.mark.parametrize(
    ("given", "uri"),
    [
        ("169.254.128.2", "http://169.254.128.2:11311/"),
        ("robot", "http://robot:11311/"),
        ("robot:12345", "http://robot:12345/"),
        ("http://robot:11311", "http://robot:11311"),
        ("::1", "http://[::1]:11311/"),
        ("[::1]", "http://[::1]:11311/"),
        (" 10.0.0.7 ", "http://10.0.0.7:11311/"),
    ],
)
def test_an_address_becomes_a_master_uri(given, uri):
    assert master_uri_of(given) == uri


@pytest.mark.parametrize("bad", ["", "a b", "https://robot", "robot/path"])
def test_what_is_no_address_is_refused(bad):
    with pytest.raises(ValueError, match=r"address|http://"):
        master_uri_of(bad)


def test_nothing_given_takes_the_environment(monkeypatch):
    monkeypatch.setenv("ROS_MASTER_URI", "http://robot:11311")
    assert master_uri_of(None) == "http://robot:11311"
    monkeypatch.delenv("ROS_MASTER_URI")
    with pytest.raises(ValueError, match="ROS_MASTER_URI"):
        master_uri_of(None)


def test_marks_are_kept_in_a_file(tmp_path):
    marks = MarkFile(tmp_path / "site" / "marks.json")
    marks.put("A1", Pose2D(3.0, 1.0, 1.57), note="货架")
    marks.put("B1")
    marks.save()
    again = MarkFile(marks.path)
    assert again.names == ["A1", "B1"]
    assert again["A1"].pose == Pose2D(3.0, 1.0, 1.57)
    assert again["A1"].note == "货架"
    assert again["B1"].pose is None
    with pytest.raises(KeyError, match="A1"):
        again["A2"]
    again.remove("B1")
    assert "B1" not in again


@pytest.mark.parametrize("text", ["[1, 2]", "{", '{"A1": 3}', '{"A1": {"x": "north"}}', '{"A1": {"x": NaN}}'])
def test_a_broken_mark_file_says_what_is_expected(tmp_path, text):
    path = tmp_path / "marks.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=r"marks\.json"):
        MarkFile(path)


def status(**changes: object) -> RobotStatus:
    fields: dict[str, object] = {
        "task_id": 1,
        "task_type": TaskType.PICK,
        "task_state": TaskState.COMPLETED,
        "action_type": ActionType.NAVIGATION,
        "action_state": ActionState.DONE,
        "robot_state": RobotState.IDLE,
        "robot_mode": RobotMode.AUTOMATIC,
        "work_mode": WorkMode.TASK,
        "wait_id": 0,
        "destination": "A1",
        "message": "",
        "updated": 0,
    }
    return RobotStatus(**{**fields, **changes})


@pytest.mark.parametrize(
    ("changes", "faults", "key", "ready"),
    [
        ({}, (), None, True),
        ({"robot_mode": RobotMode.MANUAL}, (), "manual_mode", False),
        ({"robot_mode": RobotMode.MAINTENANCE}, (), "manual_mode", False),
        ({"work_mode": WorkMode.DEPLOYMENT}, (), "not_in_task_mode", True),
        ({"robot_state": RobotState.UNINITIALISED}, (), "not_localised", False),
        ({"robot_state": RobotState.FAULT}, (), "fault", False),
        ({"task_state": TaskState.RUNNING}, (), "other_client", True),
        ({}, (110201000013,), "emergency_stop", False),
        ({}, (110202000013,), "bumper", False),
        ({}, (130103000012,), "not_localised", True),
        ({}, (140201000032,), "no_map", True),
    ],
)
def test_readiness_says_what_is_in_the_way(changes, faults, key, ready):
    readiness = assess(status(**changes), [decode_status_code(code) for code in faults], charging=False)
    assert bool(readiness) is ready
    assert [r.key for r in readiness.reasons] == ([key] if key else [])
    assert readiness.sentence()


def test_readiness_tells_our_own_task_from_somebody_elses():
    running = status(task_state=TaskState.RUNNING)
    assert [r.key for r in assess(running, [], own_tasks={running.task_id}).reasons] == ["busy"]
    readiness = assess(running, [], own_tasks={4711}, other_goals=[("/laptop", "/move_base")])
    assert [r.key for r in readiness.reasons] == ["other_client", "other_client"]
    assert "/laptop has a goal of its own under way on /move_base" in readiness.sentence()
    assert readiness.ready


def test_the_robots_own_client_is_told_only_when_its_task_is_not_known():
    drives = [("/ros_interface", "/move_base")]
    assert "another client, or of its own," in assess(None, [], other_goals=drives).sentence()
    assert [r.key for r in assess(None, [], own_tasks={4}, other_goals=drives).reasons] == ["unknown"]
    assert assess(status(), [], other_goals=drives).reasons == ()


def test_readiness_with_nothing_heard_and_with_a_cable():
    assert [r.key for r in assess(None, ()).reasons] == ["unknown"]
    assert not assess(status(), (), charging=True)
    assert assess(status(robot_state=RobotState.CHARGING), (), charging=True)


def test_steps_know_their_limits_and_what_remains():
    assert Step.straight(-2.0).rest(25.0).data == pytest.approx(-1.5)
    assert Step.turn(1.0).highest_speed == 0.1
    assert Step.straight(1.0).highest_speed == 0.2
    direction = Step.diagonal(1.0, math.pi / 4).direction()
    assert (direction.vx, direction.vy) == pytest.approx((math.sqrt(0.5), math.sqrt(0.5)))
    assert len(check_steps([Step.straight(10.0), Step.turn(62.8318)])) == 2
    for bad in (Step.straight(10.001), Step.turn(62.84), Step.straight(math.inf), Step(StepMode(7), 1.0)):
        with pytest.raises(ValueError, match=r"more than|finite|not known"):
            check_steps([bad])


@pytest.mark.parametrize("valid_for", [0.0, -1.0, 5.1, math.inf, math.nan])
def test_a_velocity_may_not_be_valid_for_long(valid_for):
    with pytest.raises(ValueError, match="valid_for"):
        Shaper(DriveLimits()).command(Velocity(0.1), 0.0, valid_for)


def test_a_refused_command_changes_nothing():
    shaper = Shaper(DriveLimits())
    shaper.command(Velocity(0.2), 0.0, 1.0)
    with pytest.raises(ValueError, match="limit"):
        shaper.command(Velocity(0.31), 0.0, 1.0)
    with pytest.raises(ValueError, match="limit"):
        shaper.command(Velocity(0.25, 0.25), 0.0, 1.0)
    assert [shaper.next(0.1 * step) for step in range(10)][-1] == Velocity(0.2)


def test_a_drive_wakes_at_the_end_of_a_command_and_not_a_period_later():
    shaper = Shaper(DriveLimits())
    assert shaper.seconds_to_next(0.0, 0.05) == 0.05
    shaper.command(Velocity(0.2), 0.0, 0.3)
    shaper.next(0.0)
    assert shaper.seconds_to_next(0.2, 0.05) == 0.05
    woken = 0.27 + shaper.seconds_to_next(0.27, 0.05)
    assert 0.3 < woken < 0.305
    assert shaper.next(woken) == Velocity()
    assert shaper.seconds_to_next(woken, 0.05) == 0.05, "zero was sent: no hurry any more"


def test_only_an_arrival_is_true():
    for kind in OutcomeKind:
        outcome = Outcome(kind, "goal", "why", 9, None, 1.5)
        assert bool(outcome) is (kind is OutcomeKind.ARRIVED)
        assert "goal" in outcome.sentence()
        assert f"{outcome}" == outcome.sentence()  # what `print` shows
        assert f"{outcome.kind}" in outcome.sentence()
        assert "9" not in outcome.sentence(), "a number of the interface tells a person nothing"
    assert "STILL MOVING" in Outcome(OutcomeKind.FAILED, "goal", stopped=False).sentence()


def test_goals_of_other_clients_are_known_by_the_name_in_their_id():
    from types import SimpleNamespace

    from woosh_pure.readiness.readiness_state import OtherGoals

    def message(*goals):
        entries = [SimpleNamespace(goal_id=SimpleNamespace(id=i), status=s) for i, s in goals]
        return SimpleNamespace(status_list=entries)

    other_goals = OtherGoals()
    silent = SimpleNamespace(stats=list)
    other_goals.listen(SimpleNamespace(name="/me_1", subscriber=lambda *_, **__: silent))
    other_goals.receive(
        "/move_base", message(("/me_1-4-1.0", 1), ("/laptop-1-1.5", 1), ("/ros_interface-2-3.0", 1))
    )
    other_goals.receive("/cmd_vel_control", message(("odd", 0), ("/laptop-2-1.5", 3)))
    assert other_goals.active() == [
        ("/laptop", "/move_base"),
        ("/ros_interface", "/move_base"),
        ("odd", "/cmd_vel_control"),
    ]
    other_goals.receive("/move_base", message())
    other_goals.receive("/cmd_vel_control", message())
    assert other_goals.active() == []
