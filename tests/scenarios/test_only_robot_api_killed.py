"""A program at a robot that has only the Robot API is killed: what its watchdog sends, and what goes on without it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from rosproto import Node
from rosproto.gateway import Access
from tests.support.extras import needs
from tests.support.robot_api_peer import ANSWERS, ApiPeer
from tests.support.waiting import until
from woosh_pure import SimulatedChassis
from woosh_pure.api_server import RobotApiServer, simulated_site
from woosh_pure.enums import TaskState

if os.name != "posix":
    pytest.skip("needs SIGKILL", allow_module_level=True)
needs("api")

WATCHED = """
import os, signal, sys
from rosproto import message_class, service_class
from rosproto.watchdog import WatchedNode, Watchdog
from woosh_pure.robot_api.http import ApiAddress
from woosh_pure.robot_api.last_requests import last_request

api = ApiAddress("127.0.0.1", int(sys.argv[1]))
cancel = service_class("woosh_msgs/ExecTask").Request(task_exect=4, task_id=4711)
with Watchdog() as watchdog:
    what = {"/smooth_cmd_vel": message_class("geometry_msgs/Twist")(), "/exec_task": cancel, "/move_base": None}
    requests = [last_request(api, name, message, 0.5) for name, message in what.items()]
    assert watchdog.watch(WatchedNode("http://127.0.0.1:1", "/x"), requests=requests).ready
    os.kill(os.getpid(), signal.SIGKILL)
"""
TASK = """
import sys, time
from woosh_pure import Chassis

with Chassis(sys.argv[1], watchdog=sys.argv[2] == "watchdog") as chassis:
    goal = chassis.go_to_mark("B2")
    time.sleep(60)
"""


def start(program: str, *words: str) -> subprocess.Popen[bytes]:
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[2])}
    return subprocess.Popen([sys.executable, "-c", program, *words], env=environment)


@pytest.mark.promise("at a robot that has only the Robot API")
@pytest.mark.parametrize("task", ["4711", 4711])
def test_the_watchdog_sends_zero_and_the_cancels(task: object) -> None:
    answers = {**ANSWERS, "woosh.robot.TaskProc": {"robotTaskId": task, "state": 3}}
    answers |= {f"woosh.{name}": {} for name in ("robot.Twist", "robot.ActionOrder", "ros.CallAction")}
    with ApiPeer(answers) as peer:
        assert start(WATCHED, str(peer.port)).wait(30.0) == -signal.SIGKILL
        until(lambda: peer.requests.count("Twist") >= 3)
        until(lambda: {"ActionOrder", "CallAction"} <= set(peer.requests))
        assert {str(body) for request, body in peer.asked if request == "woosh.robot.ActionOrder"} == {
            "{'order': 4}"
        }
        zeros = [body for request, body in peer.asked if request == "woosh.robot.Twist"]
        assert not any(any(body.values()) for body in zeros)


@pytest.mark.promise("a robot that has only the Robot API carries out another program")
def test_the_watchdog_spares_another_programs_task() -> None:
    answers = {**ANSWERS, "woosh.robot.TaskProc": {"robotTaskId": "99", "state": 3}}
    answers |= {f"woosh.{name}": {} for name in ("robot.Twist", "robot.ActionOrder", "ros.CallAction")}
    with ApiPeer(answers) as peer:
        assert start(WATCHED, str(peer.port)).wait(30.0) == -signal.SIGKILL
        until(lambda: peer.requests.count("Twist") >= 3 and "CallAction" in peer.requests)
        assert "ActionOrder" not in peer.requests


@pytest.fixture
def robot() -> Iterator[tuple[SimulatedChassis, str]]:
    with (
        SimulatedChassis(full_graph=False) as sim,
        Node("robot_api", master_uri=sim.master_uri, rosout=False) as node,
        RobotApiServer(node, port=0, site=simulated_site(sim), access=Access(write=["api:*"])) as server,
    ):
        yield sim, server.url


@pytest.mark.slow
@pytest.mark.parametrize("way", ["watchdog", "none"])
def test_after_kill_9_a_task_ends_by_the_watchdog_only(robot: tuple[SimulatedChassis, str], way: str) -> None:
    sim, url = robot
    process = start(TASK, url, way)
    try:
        until(lambda: sim.world.body.velocity.vx > 0.1, 60.0)
    finally:
        process.kill()
        process.wait(10.0)
    if way == "watchdog":
        until(lambda: sim.world.status().task_state is TaskState.CANCELLED, 5.0)
    else:
        until(lambda: sim.world.status().task_state is TaskState.COMPLETED, 60.0)
