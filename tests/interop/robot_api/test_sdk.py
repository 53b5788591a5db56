"""The vendor's SDK, unchanged, as judge: its example, its message classes, its client class with all subscriptions."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from rosproto import Node
from rosproto.gateway import Access
from tests.support import woosh_sdk
from tests.support.extras import needs
from tests.support.robot_api import ApiClient
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.api_server import RobotApiServer, simulated_site
from woosh_pure.geometry import normalize_angle
from woosh_pure.robot_api import wire

needs("api")
HERE = Path(__file__).resolve().parent
FAILED = ("失败", "错误", "ERROR", "Traceback", "failed", "Failed")


@pytest.fixture
def sdk() -> Path:
    return woosh_sdk.folder()


@pytest.fixture(scope="module")
def world() -> Iterator[tuple[SimulatedChassis, RobotApiServer]]:
    with (
        SimulatedChassis(full_graph=False) as sim,
        Node("robot_api", master_uri=sim.master_uri, rosout=False) as node,
        RobotApiServer(node, port=0, access=Access(write=["api:*"]), site=simulated_site(sim)) as server,
    ):
        yield sim, server


def judged(sdk: Path, bodies: list[tuple[str, Any]]) -> list[tuple[str, dict[str, int]]]:
    """What the SDK's message classes say of bodies: a problem or "", and the numbers of the type's fields."""
    done = subprocess.run(
        [woosh_sdk.python(), HERE / "sdk_types.py"],
        input=json.dumps(bodies),
        capture_output=True,
        text=True,
        timeout=120,
        env={**os.environ, "PYTHONPATH": str(sdk)},
    )
    assert done.returncode == 0, done.stderr
    return [(problem, fields) for problem, fields in json.loads(done.stdout)]


def filled(kind: str) -> wire.Values:
    """Values that are no defaults, for each field; of a oneof the first member."""
    scalars: dict[str, Any] = {"bool": True, "string": "a1", "bytes": b"\xfb\xff", "float": 0.5}
    found: wire.Values = {}
    chosen: set[str] = set()
    for field in wire.fields(kind):
        if field.oneof in chosen:
            continue
        chosen |= {field.oneof} - {""}
        one = filled(field.type) if field.type in wire.messages() else scalars.get(field.type, 7)
        found[field.key] = [one, one] if field.repeated else one
    return found


def test_every_type_of_the_table_is_parsed_by_the_sdk(sdk: Path) -> None:
    """Filled and empty; its names and numbers are ours."""
    kinds = sorted(set(wire.messages()) - {wire.SUBSCRIPTION})  # part of its envelope, not of its types
    bodies = [(kind, wire.dump(kind, values)) for kind in kinds for values in (filled(kind), {})]
    for (kind, _), (problem, fields) in zip(bodies, judged(sdk, bodies), strict=True):
        assert problem == "", kind
        assert fields == {field.name: field.number for field in wire.fields(kind)}


def test_every_answer_and_push_is_parsed_by_the_sdk(
    sdk: Path, world: tuple[SimulatedChassis, RobotApiServer]
) -> None:
    """One field that its class does not know, and its client drops the message."""
    sim, server = world
    with ApiClient(server.url) as client, Chassis(sim.master_uri) as chassis:
        client.subscribe(*wire.topics())
        motion = chassis.go_to_mark("B2")
        frames = client.pushed_within(2.0)
        frames += [client.answer({"type": kind, "sn": 1}) for kind in wire.requests()]
        motion.cancel()
        sim.press_emergency_stop()
        frames += client.pushed_within(1.5)
        sim.reset()
    bodies = [(frame["type"], frame["body"]) for frame in frames]
    assert len({kind for kind, _ in bodies}) > 60
    assert [
        (kind, problem)
        for (kind, _), (problem, _) in zip(bodies, judged(sdk, bodies), strict=True)
        if problem
    ] == []


def run(
    sdk: Path, program: str, *words: str, seconds: float, folder: str = "examples", typed: str = ""
) -> str:
    """Run one of its programs until SIGINT, with a text on its standard input; its output."""
    process = subprocess.Popen(
        [woosh_sdk.python(), "-u", program, *words],
        cwd=sdk / folder,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env={**os.environ, "PYTHONPATH": str(sdk), "PYTHONDONTWRITEBYTECODE": "1"},
    )
    try:
        try:
            said, _ = process.communicate(typed, timeout=seconds)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGINT)
            said, _ = process.communicate(timeout=30.0)
    finally:
        process.kill()
    return said


@pytest.mark.slow
def test_monitor_runs_unchanged(sdk: Path, world: tuple[SimulatedChassis, RobotApiServer]) -> None:
    """RobotInfo with all its sections, ten subscriptions, pushes while the robot drives; nothing fails."""
    sim, server = world
    with Chassis(sim.master_uri) as chassis:
        motion = chassis.go_to_mark("A1")
        said = run(sdk, "monitor.py", "--ip", "127.0.0.1", "--port", str(server.port), seconds=6.0)
        motion.cancel()
    lines = said.splitlines()
    assert not [line for line in lines if any(word in line for word in FAILED)], said
    assert "Request completed successfully: woosh.robot.RobotInfo" in said
    assert said.count("Subscribed to topic successfully") == 10
    assert "simulated chassis, ID: 1" in said
    assert any("A1" in line for line in lines), said  # the task, which it was told of by a push


@pytest.mark.slow
def test_the_agent_has_all_its_subscriptions(
    sdk: Path, world: tuple[SimulatedChassis, RobotApiServer]
) -> None:
    """17 topics at once, 20 requests in parallel, each matched with its answer; it knows what the robot does."""
    sim, server = world
    with Chassis(sim.master_uri) as chassis:
        motion = chassis.go_to_mark("B1")
        said = run(sdk, str(HERE / "sdk_agent.py"), str(server.port), "3", seconds=60.0, folder=".")
        motion.cancel()
    known = json.loads(
        next(line for line in said.splitlines() if line.startswith("KNOWN ")).removeprefix("KNOWN ")
    )
    assert known["answered"] == [True] * 20
    assert (known["state"], known["mode"], known["task"]) == (4, [1, 2], ["B1", 3])
    assert (known["power"] > 0, known["taskable"], known["path"] > 0, known["outline"] > 4) == (
        True,
        0,
        True,
        True,
    )
    assert not [line for line in said.splitlines() if any(word in line for word in FAILED)], said


@pytest.mark.slow
def test_demo_lite_runs_unchanged(sdk: Path, world: tuple[SimulatedChassis, RobotApiServer]) -> None:
    """A task that it cancels, a step, and driving by velocity: every request is accepted, and at its end the
    robot stands, turned."""
    sim, server = world
    sim.reset()
    with ApiClient(server.url) as witness:
        witness.subscribe("woosh.robot.TaskProc", "woosh.ros.Feedbacks", "woosh.robot.PoseSpeed")
        said = run(sdk, "demo_lite.py", "127.0.0.1", str(server.port), seconds=90.0, typed="\n\n\nx\n\n")
        seen = witness.pushed_within(1.0)
    assert "失败" not in said, said  # its own error about a name of Feedbacks is logged, and harmless
    assert "执行任务请求成功" in said
    assert said.count("速度控制请求成功") == 51
    tasks = [f["body"]["state"] for f in seen if f["body"].get("robotTaskId") == "66666"]
    assert (3 in tasks, tasks[-1]) == (True, 8)
    ends = [one for f in seen for one in f["body"].get("fbs", [])]
    assert (ends[-1]["action"], ends[-1]["state"]) == ("woosh.ros.action.StepControl", 1)
    stepped = max(number for number, frame in enumerate(seen) if "fbs" in frame["body"])
    yaws = [f["body"]["pose"]["theta"] for f in seen[stepped:] if "pose" in f["body"]]
    assert sum(normalize_angle(b - a) for a, b in pairwise(yaws)) > 1.5
    with sim.lock:
        assert sim.world.body.velocity.is_standing()
    assert said.count("ros feedbacks") == 2
