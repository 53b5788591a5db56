"""Values of the Robot API: what a robot says becomes poses, marks and facts, and what it does not say None."""

from __future__ import annotations

import math
from typing import Any

from tests.support.robot_api_peer import ANSWERS
from woosh_pure.enums import TaskState
from woosh_pure.faults import FaultLevel
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.marks import UserMark, with_robot_marks
from woosh_pure.motion.task_list import ListTracker
from woosh_pure.outcome import OutcomeKind
from woosh_pure.robot_api import values, wire
from woosh_pure.values.convert import to_value
from woosh_pure.values.messages import message_type


def body(request: str) -> wire.Values:
    return wire.load(wire.requests()[request].answer, ANSWERS[request])


def test_a_drive_to_a_mark_ends_at_the_place_where_the_robot_docks() -> None:
    marks = {mark.name: mark for mark in values.marks_of(body("woosh.map.SceneDataEasy"))}
    charger = marks["C1"]
    assert (charger.kind, charger.map, charger.number) == ("charger", "ground", 14)
    assert (charger.pose, charger.dock) == (Pose2D(-2.0, -3.0, 3.0), Pose2D(-0.9, -3.0, 3.0))
    assert marks["A1"].pose == Pose2D(3.0, 1.0, 1.5)
    assert charger.as_user_mark() == UserMark("C1", charger.pose, charger=True, source="robot")


def test_an_angle_is_normalized_and_an_absent_number_is_zero() -> None:
    marks = {mark.name: mark for mark in values.marks_of(body("woosh.map.SceneDataEasy"))}
    pose = marks["仓库 2"].pose
    assert pose is not None
    assert (pose.x, round(pose.yaw, 4)) == (5.5, round(7.0 - 2 * math.pi, 4))
    assert marks["U1"].pose == Pose2D(9.0, 0.0, 0.0)


def test_a_place_that_no_map_has_is_not_known() -> None:
    marks = {mark.name: mark for mark in values.marks_of(body("woosh.map.SceneDataEasy"))}
    assert marks["nowhere"].pose is None
    far = {"identity": {"no": "far"}, "pose": {"dock": {"x": 1e9}}}
    scene = wire.load("woosh.map.SceneDataEasy", {"maps": [{"storages": {"bases": [far, {}]}}]})
    assert [(mark.name, mark.pose) for mark in values.marks_of(scene)] == [("far", None)], "no name: no mark"


def test_a_zone_has_its_polygon_and_one_without_an_area_is_left_out() -> None:
    assert values.zones_of(body("woosh.map.SceneData")) == [
        values.Zone("speed_limit", 3, ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)), 0.3, "wait", "ground")
    ]


def test_every_kind_of_mark_and_zone_is_a_list_of_the_interface() -> None:
    storages = {field.key for field in wire.fields("woosh.map.mark.Storages")}
    fields = {field.key for field in wire.fields("woosh.map.field.FieldInfo")}
    assert set(values.KINDS_OF_MARKS) == storages
    assert set(values.KINDS_OF_ZONES) == fields - {"guideMarkers"}


def test_facts_are_bits() -> None:
    state, mode = body("woosh.robot.RobotState"), body("woosh.robot.Mode")
    device, operation = {"hardware": 1024 + 4, "software": 8}, {"nav": 8, "robot": 0}
    facts = values.facts_of(state, mode, device, operation)
    assert (facts.emergency_stop, facts.localised, facts.occupied) == (True, False, True)
    assert (facts.taskable, facts.obstructed) == (False, True)
    unknown = values.facts_of(state, mode, None, operation)
    assert (unknown.emergency_stop, unknown.localised, unknown.occupied) == (None, None, None)


def test_a_number_without_a_name_is_kept() -> None:
    """Newer robots have more."""
    record = wire.load("woosh.robot.TaskProc", {"state": 44, "type": 9})
    assert values.task_of(record).state == TaskState(44)
    assert (
        values.facts_of({"state": 77}, {"ctrl": 8, "work": 9}, None, {"nav": 0, "robot": 0}).robot_state == 77
    )
    assert values.outline_of({"model": [], "type": 9}) == values.Outline((), "")


def test_an_event_without_words_has_ours_and_an_odd_level_is_a_warning() -> None:
    event = values.event_of(body("woosh.robot.count.AbnormalCodes")["scs"][0])
    assert event.text == "emergency stop 1 pressed (110201000013)"
    assert (event.level, event.time) == (FaultLevel.WARNING, 1790000000.5)


def test_empty_answers_are_values_too() -> None:
    """A robot leaves out what it has not."""
    general, model = wire.load("woosh.robot.General", {}), wire.load("woosh.robot.Model", {})
    assert values.identity_of(general, "").length == 0.0
    assert values.outline_of(model).points == ()
    assert values.marks_of(wire.load("woosh.map.SceneDataEasy", {"maps": [{}]})) == []
    assert (
        values.zones_of(wire.load("woosh.map.SceneData", {"maps": [{}, {"fieldInfo": {"oneWays": [{}]}}]}))
        == []
    )
    count = wire.load("woosh.robot.CountDataResponse", {"operations": {"ops": [{}]}})
    assert values.statistics_of([count]) == values.Statistics(0.0, 0.0, 0, 0, 0, 0)


def test_the_users_mark_stays_the_users_and_takes_the_robots_pose_if_it_has_none() -> None:
    robot = [UserMark("A", Pose2D(1.0, 1.0), source="robot"), UserMark("B", Pose2D(2.0, 2.0), source="robot")]
    own = [UserMark("B", None, "my note"), UserMark("C", Pose2D(3.0, 3.0), on_chassis=False)]
    merged = {mark.name: mark for mark in with_robot_marks(own, robot)}
    assert sorted(merged) == ["A", "B", "C"]
    assert merged["B"] == UserMark("B", Pose2D(2.0, 2.0), "my note")
    assert merged["A"].source == "robot"
    place = UserMark("A", Pose2D(9.0, 9.0), on_chassis=False)
    assert with_robot_marks([place], robot)[-1] == place, "a place of the user's own is driven to as before"


def test_task_lists_have_the_ids_that_their_tasks_will_have() -> None:
    """With the list's sign, as /robot_status has it; one that a cancel does not end is not stoppable."""

    def stored(number: int, **task: Any) -> dict[str, Any]:
        given = {"id": 3, "cannotCancel": False, **task}
        consta = {key: given.pop(key) for key in ("cancelNext", "cancelSkip") if key in given}
        more = {"consta": consta} if consta else {}
        return {"taskSet": {"base": {"id": number, "name": f"n{number}"}, "tasks": [{"base": given, **more}]}}

    lists = values.task_lists_of(
        wire.load(
            "woosh.task.TaskInfo",
            {
                "repeatTasks": [stored(7), stored(-7), stored(8, cannotCancel=True), {}],
                "callTasks": [
                    stored(9, cancelNext=True),
                    stored(10, cancelSkip=True),
                    stored(11, cancelSkip=False),
                ],
            },
        )
    )
    found = [(each.id, each.name, each.tasks[0], each.stoppable) for each in lists]
    assert found == [
        (7, "n7", 703, True),
        (-7, "n-7", 2**64 - 703, True),
        (8, "n8", 803, False),
        (9, "n9", 903, False),
        (10, "n10", 1003, False),
        (11, "n11", 1103, True),
    ]


def test_a_list_ends_with_its_last_task_of_this_run() -> None:
    """What the robot still shows of an earlier run is no end; the end of another task is none, either."""
    tracker = ListTracker(values.TaskList(1, "Round", (101, 102), True))

    def tell(task: int, state: TaskState) -> OutcomeKind | None:
        message = message_type("woosh_msgs/RobotStatus")(task_id=task, task_state=int(state))
        tracker.status(to_value("woosh_msgs/RobotStatus", message))
        return tracker.ending and tracker.ending.kind

    assert tell(102, TaskState.COMPLETED) is None
    assert tell(0, TaskState.UNDEFINED) is None
    assert tell(101, TaskState.RUNNING) is None
    assert tell(101, TaskState.COMPLETED) is None
    assert tell(102, TaskState.RUNNING) is None
    assert tell(102, TaskState.COMPLETED) is OutcomeKind.ARRIVED
