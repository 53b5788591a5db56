"""Every row of the interface table against a chassis made of rospy nodes: read, written, called, acted on."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from rosproto.master import Master
from tests.support import ros
from woosh_pure import Chassis, MotionRefused, Pose2D, interface
from woosh_pure.enums import LedState, NavigationMode, TaskType
from woosh_pure.interface.table import Row
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.values.messages import message_type

PROGRAM = Path(__file__).with_name("programs") / "chassis_of_the_table.py"
ROWS = [row for row in interface.ROWS if row.definition_known]

Verb = Callable[[Chassis], object]


def grid() -> GridMap:
    import numpy as np

    return GridMap(np.zeros((2, 3), np.int8), 0.5)


# What a user writes for a row, and what of it must arrive at the rospy node.
VERBS: dict[str, tuple[Verb, str]] = {
    "/rgbled": (lambda c: c.light(LedState.WARNING, module=2), "submodule: 2 .*normal: 160"),
    "/rgbled_shelf": (lambda c: c.light(color=(1, 2, 3), strip="shelf"), "color: 66051"),
    "/move_base/local_costmap/set_footprint": (
        lambda c: c.set_footprint([(0.5, 0.25), (-0.5, 0.25), (-0.5, -0.25), (0.5, -0.25)]),
        "x: 0.5 y: 0.25",
    ),
    "/move_base/global_costmap/set_footprint": (
        lambda c: c.set_footprint([(0.75, 0.25), (-0.5, 0.25), (-0.5, -0.25), (0.5, -0.25)], local=False),
        "x: 0.75 y: 0.25",
    ),
    "/initialpose": (lambda c: c.set_pose(Pose2D(1.5, -2.5)), "x: 1.5 y: -2.5"),
    "/voice_synthesis": (lambda c: c.say("hello"), 'data: "hello"'),
    "/exec_task": (
        lambda c: c.task(TaskType.CARRY, "A7", type_number=5, custom=9).wait(20.0),
        'task_exect: 1 .*task_type: 4 .*task_type_no: 5 mark_no: "A7" .*custom: 9',
    ),
    "/start_localization": (lambda c: c.start_localization(False), "data: False"),
    "/move_base/enable_costmaps": (lambda c: c.enable_costmaps(), "data: True"),
    "/aic_map_server/get_map": (lambda c: check(c.get_map().cells.tolist() == [[0, 100], [-1, 0]]), ""),
    "/set_map": (lambda c: c.set_map(grid(), Pose2D(1.0, 2.0)), "width: 3 height: 2"),
    "/move_base/make_plan": (
        lambda c: check(
            [p.x for p in c.plan(Pose2D(3.0, 0.0), Pose2D(1.0, 0.0), tolerance=0.25)] == [1.0, 3.0]
        ),
        "tolerance: 0.25",
    ),
    "/move_base/clear_costmaps": (lambda c: c.clear_costmaps(), ""),
    "/init_pose": (lambda c: c.set_pose(Pose2D(1.5, -2.5), via="service"), "x: 1.5 y: -2.5"),
    "/woosh_init": (lambda c: c.initialise(), ""),
    "/move_base": (
        lambda c: c.follow([Pose2D(1.0, 0.0), Pose2D(2.0, 0.5)], point_by_point=True).wait(20.0),
        "target_pose: .*x: 2.0 y: 0.5 .*execution_mode: 1",
    ),
    "/cmd_vel_control": (
        lambda c: c.move_diagonal(-0.5, 0.25, speed=0.125, avoid=False).wait(20.0),
        "mode: 1 useAvoid: False stepControl: - executeMode: 4 data: -0.5 speed: 0.125 angle: 0.25",
    ),
    "/navigation_mode": (
        lambda c: c.set_navigation_mode(NavigationMode.WAIT_THEN_AVOID, waiting_timeout=2.5, max_speed=0.5),
        "navigation_mode: 3 waiting_timeout: 2.5 max_speed: 0.5",
    ),
}


def check(condition: bool) -> None:
    assert condition


@pytest.fixture(scope="module")
def robot(genpy_packages: Path) -> Iterator[tuple[Chassis, ros.RosProcess]]:
    """One rospy chassis for the whole file, and a Chassis on it."""
    rows = json.dumps([(row.name, row.type, row.flow) for row in ROWS])
    with Master() as master:
        env = {"CHASSIS_ROWS": rows}
        with ros.start_rospy(PROGRAM, master.uri, packages=genpy_packages, env=env) as process:
            process.wait_for("^up$", 60.0)
            with Chassis(master.uri, timeout=20.0) as chassis:
                yield chassis, process


def named(rows: list[Row]) -> Any:
    return pytest.mark.parametrize("row", rows, ids=lambda row: row.name)


@named([row for row in ROWS if row.flow == "read"])
def test_every_topic_to_read(robot: tuple[Chassis, ros.RosProcess], row: Row) -> None:
    chassis, _ = robot
    feed = chassis.feed(row.name)
    assert feed.wait(30.0, new=False) is not None
    assert feed.reading is not None
    assert feed.reading.age < 30.0


@named([row for row in ROWS if row.flow != "read" and row.name in VERBS])
def test_every_row_with_a_verb(robot: tuple[Chassis, ros.RosProcess], row: Row) -> None:
    chassis, process = robot
    verb, arrives = VERBS[row.name]
    verb(chassis)
    what = {"write": "heard", "call": "called", "act": "goal"}[row.flow]
    process.wait_for(f"^{what} {re.escape(row.name)} .*{arrives}", 20.0)


@named([row for row in ROWS if row.flow == "act" and row.name not in VERBS])
def test_every_other_action(robot: tuple[Chassis, ros.RosProcess], row: Row) -> None:
    chassis, process = robot
    assert chassis.action(row.name, message_type(f"{row.type}Goal")()).wait(30.0)
    process.wait_for(f"^goal {re.escape(row.name)} ", 20.0)


@named([row for row in ROWS if row.flow == "write" and row.name not in VERBS and not row.bypasses_protection])
def test_every_other_topic_to_write(robot: tuple[Chassis, ros.RosProcess], row: Row) -> None:
    chassis, process = robot
    chassis.send(row.name, message_type(row.type)())
    process.wait_for(f"^heard {re.escape(row.name)} ", 20.0)


@named([row for row in ROWS if row.bypasses_protection])
def test_every_velocity_topic(robot: tuple[Chassis, ros.RosProcess], row: Row) -> None:
    """Inside a block only; and the last thing that arrives is zero."""
    chassis, process = robot
    if row.name == "/key_cmd_vel":
        with pytest.raises(MotionRefused):
            chassis.send(row.name, message_type(row.type)())
        return
    direct = row.name == "/base_cmd_vel"
    with chassis.velocity(
        bypasses_protection=True, direct=direct, max_linear=0.2, feedback_timeout=10.0
    ) as drive:
        drive.set(0.125, valid_for=5.0)
        process.wait_for(f"^heard {row.name} linear: x: 0.125 ", 20.0)
    process.wait_for(
        f"^heard {row.name} linear: x: 0.125 [^\\0]*^heard {row.name} linear: x: 0.0 y: 0.0", 20.0
    )


def test_no_row_is_left_out() -> None:
    left = [row.name for row in ROWS if row.flow == "call" and row.name not in VERBS]
    assert left == []
    assert set(VERBS) <= {row.name for row in ROWS}
