"""`pytest --through-robot-api`: every `Chassis` of a simulated robot reaches it by the Robot API alone.

Simulator, server, bridge and Chassis are a circle: a scenario that was written for ROS 1 judges the server and the
bridge at once. What this way cannot express is a row of `CANNOT`, and a test that needs it is skipped with that row.
"""

from __future__ import annotations

from typing import Any

import pytest

from rosproto import Node
from rosproto.gateway import Access
from tests.support.robot_pool import Robot, RobotPool
from woosh_pure import SimulatedChassis

__all__ = ["CANNOT", "SKIPPED", "begin", "skip_what_it_cannot"]

CANNOT: dict[str, str] = {
    "pause of a step move": "the robot does not tell how far it has come, so what remains is not known",
    "speed limits": "the robot does not tell them: `velocity` takes 0.3 m/s and 0.5 rad/s",
    "camera, depth, clouds, IMU, odometry, BMS, inputs": "no type tells them",
    "voltage, current, capacity": "Battery has only the charge: they are NaN, null in JSON, and `battery.measured` is false; `temperature_min` repeats `temperature_max`",
    "outline, costmaps, localisation on or off, new map, shelf light": "no request changes them",
    "docks, rollers, hook, charging contacts": "CallAction has only steps, navigation, its mode, and lifts",
    "poses in another frame than the map": "a request has no frame: refused before anything is sent",
    "who drives beside": "the protocol names no clients; programs on the master of the same bridge are seen",
    "marks in a refusal": "the robot names them by `chassis.robot_api.marks()`, which nothing waits for",
    "a robot that drives on": "the protocol promises that a velocity ends by itself; our server sends the zero",
    "a silence of the base after which a drive ends": "the robot (our server after 1 s) refuses the next velocity, which ends the drive first and with its words",
    "a button that nobody knows of": "the Robot API tells an emergency stop from before we connected",
    "graph of the robot": "there are no nodes of the robot to look at, crash or shut down",
    "a state that is never told": "the topic of the state is there as soon as the robot answers, so a task is given",
    "link between nodes": "the test cuts a link of ROS 1; here it is the WebSocket, with tests of its own",
}
"""What cannot be expressed: name of the row -> why. docs/robot-api.md has the same rows."""

LINK = "link between nodes"
SILENCE = "a silence of the base after which a drive ends"
SKIPPED: dict[str, str] = {
    "test_motion::test_a_chassis_that_tells_no_velocity_is_not_driven_blind": SILENCE,
    "test_tasks::test_a_task_without_a_visible_end_is_not_started": "a state that is never told",
    "test_motion::test_a_chassis_that_falls_silent_ends_the_drive_with_zero": SILENCE,
    "test_motion::test_the_feedback_timeout_is_what_the_caller_says[30.0-True]": SILENCE,
    "test_motion::test_limits_come_from_the_chassis_and_the_caller_may_only_lower_them": "speed limits",
    "test_motion::test_what_remains_of_a_killed_process_is_the_chassis_own_behaviour": "a robot that drives on",
    "test_motion::test_after_a_kill_only_the_chassis_own_behaviour_remains": "a robot that drives on",
    "test_motion::test_pause_and_resume_of_steps_send_what_remains": "pause of a step move",
    "test_safety::test_a_drive_does_not_go_on_after_its_program_was_stopped": "a robot that drives on",
    "test_safety::test_limits_of_the_chassis_that_cannot_be_meant_leave_the_careful_ones": "speed limits",
    "test_safety::test_a_resume_that_a_stop_overtakes_does_not_move": "pause of a step move",
    "test_safety::test_a_paused_move_is_lost_with_its_chassis": "pause of a step move",
    "test_safety::test_a_robot_that_stands_although_it_is_told_to_move_ends_the_drive": "a button that nobody knows of",
    "test_safety::test_a_goal_of_ones_own_that_drives_the_robot_is_one_like_the_others": "docks, rollers, hook, charging contacts",
    "test_motion::test_a_lost_subscriber_ends_the_drive_at_once_and_zero_comes_first_afterwards": LINK,
    "test_stop::test_a_cancel_that_is_lost_is_sent_again": LINK,
    "test_stop::test_a_goal_that_ignores_its_cancel_is_named": LINK,
    "test_tasks::test_a_mark_that_is_not_known_is_answered_by_near_ones_and_the_list": "marks in a refusal",
}
"""Test, or one of its cases -> row."""


def begin() -> None:
    """Give each simulated robot a server of the Robot API, and its address instead of its master's."""
    from woosh_pure.api_server import RobotApiServer, simulated_site

    start, close = SimulatedChassis.start, SimulatedChassis.close
    real = SimulatedChassis.master_uri
    doors: dict[int, tuple[Node, RobotApiServer]] = {}

    def start_with_door(self: Any) -> Any:
        self._latch = True  # a robot with a Robot API knows its own state
        start(self)
        if id(self) not in doors:
            node = Node("robot_api", master_uri=real.fget(self), rosout=False, anonymous=True)  # type: ignore[attr-defined]
            server = RobotApiServer(node, port=0, site=simulated_site(self), access=Access(write=["api:*"]))
            doors[id(self)] = node, server
        return self

    def close_with_door(self: Any) -> None:
        for part in reversed(doors.pop(id(self), ())):
            part.close()
        close(self)

    def address(self: Any) -> str:
        return doors[id(self)][1].url.rstrip("/") if id(self) in doors else real.fget(self)  # type: ignore[attr-defined]

    def close_it(self: RobotPool, robot: Robot) -> None:
        robot.sim.close()  # its server remembers the faults of the test before

    pool: Any = RobotPool
    pool.give_back = close_it
    changed: Any = SimulatedChassis
    changed.start, changed.close, changed.master_uri = start_with_door, close_with_door, property(address)


def skip_what_it_cannot(items: list[pytest.Item]) -> None:
    """Skip the tests that need a row of `CANNOT`."""
    for item in items:
        names = (f"{item.path.stem}::{name}" for name in (item.name, getattr(item, "originalname", "")))
        if row := next((SKIPPED[name] for name in names if name in SKIPPED), None):
            item.add_marker(pytest.mark.skip(reason=f"{row}: {CANNOT[row]}"))
