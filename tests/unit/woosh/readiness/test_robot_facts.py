"""What the robot says by its Robot API, beside ROS: who speaks against moving wins, and only one doubt ends."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.unit.woosh.test_values import status
from woosh_pure.enums import RobotMode, RobotState, WorkMode
from woosh_pure.faults import decode_status_code
from woosh_pure.readiness.readiness_state import assess
from woosh_pure.reasons import Ready, ReasonKey
from woosh_pure.robot_api.values import DeviceFacts

FINE = DeviceFacts(
    RobotState.IDLE, RobotMode.AUTOMATIC, WorkMode.TASK, emergency_stop=False, localised=True, occupied=False,
    taskable=True, obstructed=False,
)  # fmt: skip
PRESSED = decode_status_code(110201000013)


def test_what_ros_never_reported_is_known_by_the_robot_api() -> None:
    assert assess(None, []).answer is Ready.UNKNOWN
    assert assess(None, [], robot=FINE).answer is Ready.YES


@pytest.mark.promise("pressed before you connect, and the robot has a Robot API")
def test_an_emergency_stop_from_before_is_a_no() -> None:
    """ROS never reports it: no status, no code."""
    readiness = assess(None, [], robot=replace(FINE, emergency_stop=True))
    assert readiness.answer is Ready.NO
    assert readiness.refuses, "a verb does not even ask the chassis"
    assert [reason.key for reason in readiness.reasons] == [ReasonKey.EMERGENCY_STOP]


@pytest.mark.parametrize(
    ("change", "key", "answer"),
    [
        ({"robot_mode": RobotMode.MANUAL}, ReasonKey.MANUAL_MODE, Ready.NO),
        ({"robot_state": RobotState.FAULT}, ReasonKey.FAULT, Ready.NO),
        ({"robot_state": RobotState.MAPPING}, ReasonKey.MAPPING, Ready.NO),
        ({"localised": False}, ReasonKey.NOT_LOCALISED, Ready.YES),
        ({"taskable": False}, ReasonKey.NOT_TASKABLE, Ready.YES),
        ({"occupied": True}, ReasonKey.OCCUPIED, Ready.YES),
    ],
)
def test_each_fact_is_a_reason_with_a_sentence(
    change: dict[str, object], key: ReasonKey, answer: Ready
) -> None:
    """Not localised, not taskable and occupied are told: they do not block a velocity or a step."""
    readiness = assess(status(), [], robot=replace(FINE, **change))  # type: ignore[arg-type]
    assert (readiness.answer, [reason.key for reason in readiness.reasons]) == (answer, [key])


def test_the_robot_api_ends_no_reason_of_ros() -> None:
    assert assess(status(), [PRESSED], robot=FINE).answer is Ready.NO
    assert assess(status(robot_mode=RobotMode.MANUAL), [], robot=FINE).answer is Ready.NO
    assert assess(status(), [], link_lost=True, robot=FINE).answer is Ready.UNKNOWN


def test_a_reason_of_both_is_told_once() -> None:
    readiness = assess(status(), [PRESSED], robot=replace(FINE, emergency_stop=True))
    assert [reason.key for reason in readiness.reasons].count(ReasonKey.EMERGENCY_STOP) == 1


@pytest.mark.parametrize(
    "change",
    [
        {"emergency_stop": None},
        {"robot_state": RobotState.UNDEFINED},
        {"robot_state": RobotState.UNINITIALISED},
    ],
)
def test_a_robot_that_does_not_say_leaves_the_doubt(change: dict[str, object]) -> None:
    assert assess(None, [], robot=replace(FINE, **change)).answer is Ready.UNKNOWN  # type: ignore[arg-type]
