"""Programs in the shape of those that owners run on such robots, written anew: what they rely on beside the manual.

Whole seconds as `sn`, requests without a body, both spellings in one body, two connections of one program, velocities by HTTP at
10 Hz, and the steps by which they make a robot ready.
"""

from __future__ import annotations

import http.client
import json
import time
from collections.abc import Iterator
from typing import Any

import pytest

from rosproto import Node
from rosproto.gateway import Access
from tests.support.driving_commands import moving
from tests.support.extras import needs
from tests.support.waiting import until
from tests.support.websocket import connect
from woosh_pure import SimulatedChassis
from woosh_pure.api_server import RobotApiServer, simulated_site

needs("api")


@pytest.fixture(scope="module")
def robot() -> Iterator[tuple[SimulatedChassis, RobotApiServer]]:
    with (
        SimulatedChassis(full_graph=False) as sim,
        Node("robot_api", master_uri=sim.master_uri, rosout=False) as node,
        RobotApiServer(node, port=0, access=Access(write=["api:*"]), site=simulated_site(sim)) as server,
    ):
        yield sim, server


class Post:
    """A client by HTTP that keeps its connection and reads what it asked for."""

    def __init__(self, port: int) -> None:
        self._connection = http.client.HTTPConnection("127.0.0.1", port, timeout=5.0)

    def __call__(self, path: str, **body: object) -> dict[str, Any]:
        data = json.dumps(body) if body else None
        headers = {"Content-Type": "application/json"}
        self._connection.request("POST", f"/woosh/{path}", data, headers)
        response = self._connection.getresponse()
        answer: dict[str, Any] = json.loads(response.read())
        assert response.status == 200
        assert "sn" not in answer
        return answer

    def close(self) -> None:
        self._connection.close()


@pytest.fixture
def post(robot: tuple[SimulatedChassis, RobotApiServer]) -> Iterator[Post]:
    robot[0].reset()
    robot[0].speed = 1.0
    asking = Post(robot[1].port)
    yield asking
    asking.close()


def test_a_program_with_one_connection_for_pushes_and_one_for_requests(
    robot: tuple[SimulatedChassis, RobotApiServer],
) -> None:
    """Number by whole seconds, so that two requests share it; no body; snake_case; the end by TaskProc."""
    sim, server = robot
    sim.reset()
    sim.speed = 4.0

    def ask(kind: str, body: object = None) -> dict[str, Any]:
        frame = {"type": f"woosh.robot.{kind}", "sn": int(time.time())}
        requests.send(json.dumps(frame if body is None else {**frame, "body": body}))
        answer: dict[str, Any] = json.loads(requests.recv(10.0))
        assert (answer["sn"], answer["ok"]) == (frame["sn"], True), answer
        body_got: dict[str, Any] = answer["body"]
        return body_got

    with connect(server.url) as requests, connect(server.url) as pushes:
        topics = ["woosh.robot.TaskProc", "woosh.robot.PoseSpeed"]
        pushes.send(json.dumps({"type": "woosh.Subscription", "body": {"sub": True, "topics": topics}}))
        until(lambda: ask("OperationState")["robot"] & 1)
        assert {"robotId", "state"} <= set(ask("RobotState"))
        assert {"power", "health", "chargeState", "chargeCycle", "batteryCycle", "tempMax"} <= set(
            ask("Battery")
        )
        assert ask("ExecTask", {"task_id": 4711, "type": 1, "mark_no": "A1", "task_type_no": 0}) == {}
        seen: list[dict[str, Any]] = []
        while not any(one.get("robotTaskId") == "4711" and one["state"] == 7 for one in seen):
            seen.append(json.loads(pushes.recv(60.0))["body"])
        assert any("pose" in one for one in seen)


def test_a_program_that_drives_by_http_at_ten_hertz(
    robot: tuple[SimulatedChassis, RobotApiServer], post: Post
) -> None:
    """Three zeros at the end, and zero from the server when it just ends; state and battery in between."""
    sim, server = robot

    def drive(turns: int) -> None:
        for _ in range(turns):
            assert post("robot/Twist", linear=0.2, angular=0)["ok"]
            assert post("robot/RobotState")["body"]["state"] == 2
            time.sleep(0.1)

    drive(8)
    assert moving(sim)
    for _ in range(3):
        assert post("robot/Twist", linear=0, angular=0)["ok"]
    until(lambda: not moving(sim))
    drive(8)
    assert moving(sim)
    post.close()
    before = server._gateway.velocity_watchdog.zeros
    until(lambda: not moving(sim))
    assert server._gateway.velocity_watchdog.zeros > before
    assert post("robot/count/AbnormalCodes")["body"]["scs"] == []


def test_the_steps_by_which_owners_make_a_robot_ready(
    robot: tuple[SimulatedChassis, RobotApiServer], post: Post
) -> None:
    """List of scenes, the scene in use, where it is, automatic, taskable, a task; robotId in every body."""
    sim, _ = robot
    sim.lose_localization()
    until(lambda: post("robot/RobotState")["body"]["state"] == 1)
    (scene,) = post("map/SceneList", robotId=1)["body"]["scenes"]
    assert post("robot/SwitchMap", robotId=1, scene_name=scene["name"])["ok"]
    pose = {"x": 0.5, "y": 0.0, "theta": 0.0}
    assert post("robot/SetRobotPose", pose=pose)["ok"]
    assert post("robot/InitRobot", pose=pose)["ok"]
    assert post("robot/SwitchControlMode", mode=1)["ok"]
    until(lambda: post("robot/OperationState")["body"]["robot"] & 1)
    sim.speed = 4.0
    target = {"x": 1.5, "y": 0.5, "theta": 1.57}
    assert post("robot/ExecTask", taskId="12", type=2, pose=target, nav_mode=1, map_id=1)["ok"]
    until(lambda: post("robot/TaskProc")["body"]["state"] == 7, 60.0)
    assert post("robot/TaskProc")["body"]["robotTaskId"] == "12"


def test_a_program_that_keeps_several_velocities_unanswered(
    robot: tuple[SimulatedChassis, RobotApiServer],
) -> None:
    """20 a second by WebSocket without waiting for answers, on two connections of one program, one after the other."""
    sim, server = robot
    sim.reset()
    sim.speed = 1.0
    for _ in range(2):
        with connect(server.url) as socket:
            for number in range(20):
                socket.send(
                    json.dumps({"type": "woosh.robot.Twist", "body": {"angular": "0.4"}, "sn": number})
                )
                time.sleep(0.05)
            assert moving(sim)
            socket.send(json.dumps({"type": "woosh.robot.Twist", "body": {}, "sn": 99}))
            answers = [json.loads(socket.recv(5.0)) for _ in range(21)]
            assert {one["sn"] for one in answers} == {*range(20), 99}
            assert all(one["ok"] for one in answers)
        until(lambda: not moving(sim))
