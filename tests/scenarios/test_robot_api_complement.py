"""The Robot API beside ROS 1: commands, page and doctor know more with it, and nothing waits for it without it."""

from __future__ import annotations

import contextlib
import json
import threading
from collections.abc import Callable
from typing import Any

import pytest

from rosproto.errors import RosError
from tests.support.robot_api_peer import ANSWERS, PASSWORD, ApiPeer, endless, half, silent
from tests.support.waiting import until
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.cli import main
from woosh_pure.errors import MotionRefused
from woosh_pure.maps.marks import MarkFile, mark_file
from woosh_pure.outcome import OutcomeKind
from woosh_pure.reasons import ReasonKey
from woosh_pure.robot_api import http

pytestmark = pytest.mark.usefixtures("private_config")

NOBODY = ["--master", "http://127.0.0.1:1"]
Command = Callable[..., tuple[int, str, str]]


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str]) -> Command:
    """Run `woosh` with the Robot API of a peer, and no ROS master; exit code, stdout, stderr."""

    def run(peer: ApiPeer, *words: str) -> tuple[int, str, str]:
        code = main([*NOBODY, "--api-address", peer.address, *words])
        return code, *capsys.readouterr()

    return run


def test_api_prints_the_answer_as_json(command: Command) -> None:
    with ApiPeer() as peer:
        code, out, _ = command(peer, "api", "Scene")
        assert (code, json.loads(out)["mapName"], json.loads(out)["version"]) == (0, "ground", "12")
        code, out, _ = command(peer, "api", "SceneDataEasy", '{"name": "yard"}', "--json")
        assert (code, json.loads(out)["name"]) == (0, "hall")
        assert peer.asked[-1][1] == {"name": "yard"}


def test_api_without_a_type_lists_what_can_be_read(command: Command) -> None:
    with ApiPeer() as peer:
        code, out, _ = command(peer, "api")
        assert code == 0
        assert "woosh.robot.Battery" in out
        assert "Twist" not in out
        assert peer.asked == []


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        (["Twist", "{}"], 3, "use the verbs of Chassis"),
        (["SwitchMap", '{"sceneName": "yard"}'], 2, "changes something on the robot"),
        (["Batery"], 2, "near names: woosh.robot.Battery"),
        (["SceneData", "{name}"], 2, "is not JSON"),
        (["SceneData", '{"nam": 1}'], 2, "has no field 'nam'"),
        (["Network"], 3, "woosh.robot.Network was refused: no such request"),
    ],
)
def test_api_refuses_what_is_not_a_question(command: Command, words: list[str], code: int, text: str) -> None:
    with ApiPeer() as peer:
        found, _, problem = command(peer, "api", *words)
        assert (found, text in problem) == (code, True), problem
        assert "Twist" not in peer.requests
        assert "SwitchMap" not in peer.requests


def test_api_without_one_says_so(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*NOBODY, "--api-address", "127.0.0.1:1", "api", "Scene"]) == 4
    assert "refused" in capsys.readouterr().err
    assert main([*NOBODY, "--api-address", "off", "api", "Scene"]) == 1
    assert "switched off" in capsys.readouterr().err
    assert main(["--sim", "api", "Scene"]) == 2


def test_the_list_of_marks_has_the_robots_marks_of_its_map(command: Command) -> None:
    with ApiPeer() as peer:
        own = MarkFile(mark_file())
        own.put("A1", None, "mine")
        own.save()
        marks = {mark["name"]: mark for mark in json.loads(command(peer, "marks", "list", "--json")[1])}
        assert sorted(marks) == ["A1", "C1", "nowhere", "仓库 2"], "U1 is on another map"
        assert (marks["A1"]["source"], marks["A1"]["note"], marks["A1"]["pose"]["x"]) == ("list", "mine", 3.0)
        assert (marks["C1"]["source"], marks["C1"]["charger"]) == ("robot", True)
        out = command(peer, "marks", "list")[1]
        assert "(robot)" in out


def test_a_robot_that_wants_a_password_is_said_in_the_list(capsys: pytest.CaptureFixture[str]) -> None:
    with ApiPeer(password=PASSWORD) as peer:
        assert main([*NOBODY, "--api-address", f"127.0.0.1:{peer.port}", "marks", "list"]) == 0
        assert "own marks are not known" in capsys.readouterr().out


def test_completion_offers_the_robots_marks(command: Command) -> None:
    with ApiPeer() as peer:
        code, out, _ = command(peer, "completion", "_words", "=goto", "=")
        assert (code, "A1" in out.splitlines(), "仓库 2" in out.splitlines()) == (0, True, True)


@pytest.mark.parametrize(
    ("answers", "level", "text"),
    [
        (ANSWERS, "ok", "Demo 200 1.1.71, map ground of hall, 5 marks"),
        ({"woosh.robot.RobotState": {"state": "?"}}, "warning", "answers that are not understood"),
        ({}, "warning", "refuses: woosh.robot.RobotState was refused"),
    ],
)
def test_the_doctor_says_what_it_found(
    sim: SimulatedChassis, capsys: pytest.CaptureFixture[str], answers: dict[str, Any], level: str, text: str
) -> None:
    with ApiPeer(answers) as peer:
        words = [
            "--master",
            sim.master_uri,
            "--api-address",
            peer.address,
            "doctor",
            "--listen",
            "0.2",
            "--json",
        ]
        assert main(words) == 0
        findings = json.loads(capsys.readouterr().out)["findings"]
        found = next(finding for finding in findings if finding["check"] == "robot_api")
        assert (found["level"], text in found["text"]) == (level, True), found


LIES: dict[str, Any] = {
    "silent": silent,
    "endless": endless,
    "another protocol": lambda *_: b"SSH-2.0\r\n\r\n",
    "dies in between": half,
    "another schema": {"state": {"text": []}},
}


@pytest.mark.promise("Robot API (port 5480) is slow, wrong or silent")
@pytest.mark.parametrize("kind", LIES)
def test_ros_goes_on_beside_a_robot_api_that_is_silent_or_lies(
    sim: SimulatedChassis, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A thread asks it again and again, without a pause, while the verbs do what they always do; none of them asks."""
    monkeypatch.setattr(http, "PAUSE_SECONDS", 0.0)
    over = threading.Event()

    def ask() -> None:
        while not over.is_set():
            with contextlib.suppress(RosError):
                chassis.robot_api.marks()

    with ApiPeer({"woosh.robot.RobotState": LIES[kind]}) as peer:
        with Chassis(sim.master_uri, robot_api=peer.address) as chassis:
            chassis.pose.wait(20.0)
            assert peer.connections == 0, "no feed asks it"
            assert not chassis.wait_until_ready(timeout=20.0).blocked
            asker = threading.Thread(target=ask)
            asker.start()
            until(lambda: peer.requests)
            assert chassis.move(0.2).wait(timeout=60.0).arrived
            assert chassis.go_to_mark("A2").cancel().kind is OutcomeKind.CANCELLED
            with chassis.velocity(bypasses_protection=True) as drive:
                drive.hold(0.1, seconds=0.5)
            assert chassis.stop().standing
            assert set(peer.requests) == {"RobotState"}, "no verb asks it"
            over.set()
        asker.join(20.0)
        assert not asker.is_alive(), "closing the Chassis ends the question"


def test_ready_answers_yes_or_no_where_ros_knows_nothing(
    sim: SimulatedChassis, capsys: pytest.CaptureFixture[str]
) -> None:
    """An idle chassis never reports its state, and never an emergency stop from before."""
    to = ["--master", sim.master_uri, "--api-address"]
    assert main([*to, "off", "ready"]) == 5
    with ApiPeer() as peer:
        assert main([*to, peer.address, "ready"]) == 0
        peer.answers["woosh.robot.DeviceState"] = {"hardware": 1024, "software": 1}
        capsys.readouterr()
        assert main([*to, peer.address, "ready"]) == 3
        assert "the emergency stop is pressed" in capsys.readouterr().out


def test_a_verb_is_refused_while_the_robot_says_that_its_emergency_stop_is_pressed(
    sim: SimulatedChassis,
) -> None:
    with ApiPeer() as peer, Chassis(sim.master_uri, robot_api=peer.address) as chassis:
        assert chassis.readiness().ready
        peer.answers["woosh.robot.DeviceState"] = {"hardware": 1024, "software": 1}
        until(lambda: not chassis.readiness().ready)
        with pytest.raises(MotionRefused, match="the emergency stop is pressed") as refused:
            chassis.move(0.1)
        assert [reason.key for reason in refused.value.reasons] == [ReasonKey.EMERGENCY_STOP]
        peer.answers["woosh.robot.DeviceState"] = {"hardware": 0, "software": 1}
        until(lambda: chassis.readiness().ready)
        assert chassis.move(0.1).wait(timeout=60.0).arrived


def test_at_the_usual_port_of_this_computer_nothing_answers_for_a_robot(sim: SimulatedChassis) -> None:
    """A simulator there may stand beside a tunnel to another robot, whose emergency stop it does not know."""
    with Chassis(sim.master_uri) as chassis, ApiPeer() as peer:
        chassis._robot_api = Chassis(sim.master_uri, robot_api=peer.address).robot_api
        assert not chassis.readiness().ready
        assert peer.asked == []
