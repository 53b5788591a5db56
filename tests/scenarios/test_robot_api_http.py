"""The Robot API of a simulated chassis by HTTP: `chassis.robot_api`, the commands and the page work with it, and
hostile requests end alone."""

from __future__ import annotations

import http.client
import json
import math
import random
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, suppress
from typing import Any, NamedTuple

import pytest

from rosproto import Node
from rosproto.gateway import Access
from tests.support.extras import needs
from tests.support.robot_api import ApiClient
from tests.support.waiting import until
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.api_server import RobotApiServer, simulated_site
from woosh_pure.cli import main
from woosh_pure.enums import RobotMode, TaskState, TaskType, WorkMode
from woosh_pure.errors import ApiRefused, MotionRefused
from woosh_pure.faults import FaultLevel
from woosh_pure.reasons import ReasonKey
from woosh_pure.robot_api import wire
from woosh_pure.robot_api.api import RobotApi

needs("api")
pytestmark = pytest.mark.usefixtures("private_config")
ROBOT = "woosh.robot."


class World(NamedTuple):
    sim: SimulatedChassis
    server: RobotApiServer
    chassis: Chassis

    @property
    def address(self) -> str:
        return f"127.0.0.1:{self.server.port}"

    @property
    def api(self) -> RobotApi:
        return self.chassis.robot_api


@pytest.fixture(scope="module")
def running() -> Iterator[World]:
    with (
        SimulatedChassis(speed=4.0, full_graph=False) as sim,
        Node("robot_api", master_uri=sim.master_uri, rosout=False) as node,
        RobotApiServer(node, port=0, robot_id=7, site=simulated_site(sim, 7)) as server,
        Chassis(sim.master_uri, robot_api=f"127.0.0.1:{server.port}") as chassis,
    ):
        yield World(sim, server, chassis)


@pytest.fixture
def world(running: World) -> World:
    running.sim.reset()
    running.sim.speed = 4.0
    return running


def post(world: World, path: str, body: Any = None, **headers: str) -> dict[str, Any]:
    """The JSON of the answer to one POST."""
    text = body if isinstance(body, (str, bytes)) else json.dumps(body or {})
    with closing(http.client.HTTPConnection("127.0.0.1", world.server.port, timeout=20.0)) as connection:
        connection.request("POST", path, text, {"Content-Type": "application/json", **headers})
        found: dict[str, Any] = json.loads(connection.getresponse().read())
        return found


# -- chassis.robot_api ---------------------------------------------------------------------------------------


def test_what_the_robot_is(world: World) -> None:
    assert world.api.available()
    identity, radius = world.api.identity(), world.sim.world.settings.radius
    assert (identity.model, identity.serial_number) == ("simulated chassis", 7)
    assert (identity.length, identity.width) == (2 * radius, 2 * radius)
    assert identity.software == "woosh_pure simulation"
    outline = world.api.outline()
    assert {round(math.hypot(*point), 6) for point in outline.points} == {radius}
    assert outline.kind == "original"
    assert world.api.settings()["identity"] == {"name": "simulated chassis"}
    assert world.api.settings()["allow"]["autoCharge"] is False


def test_how_the_robot_is(world: World) -> None:
    """And an emergency stop that was pressed before anybody listened."""
    until(lambda: world.api.facts().taskable)
    facts = world.api.facts()
    assert (facts.robot_mode, facts.work_mode) == (RobotMode.AUTOMATIC, WorkMode.TASK)
    assert (facts.emergency_stop, facts.localised, facts.occupied) == (False, True, False)
    world.sim.press_emergency_stop()
    until(lambda: world.api.facts().emergency_stop)
    with Chassis(world.sim.master_uri, robot_api=world.address) as late:
        assert not late.readiness().ready
        with pytest.raises(MotionRefused, match="the emergency stop is pressed") as refused:
            late.move(0.1)
        assert ReasonKey.EMERGENCY_STOP in {reason.key for reason in refused.value.reasons}


def test_which_maps_and_marks_it_has(world: World) -> None:
    scene = world.api.scene()
    assert (scene.name, scene.current_map, scene.version) == ("simulation", "map", 1)
    assert [(one.name, one.maps, one.current_map) for one in world.api.scenes()] == [
        ("simulation", ("map",), "map")
    ]
    marks = {mark.name: mark for mark in world.api.marks()}
    assert {name: mark.pose for name, mark in marks.items()} == world.sim.marks
    chargers = {name for name, mark in marks.items() if mark.kind == "charger"}
    assert chargers == {mark.name for mark in world.sim.world.site.user_marks().values() if mark.charger}
    assert {mark.map for mark in marks.values()} == {"map"}
    assert len({mark.number for mark in marks.values()}) == len(marks)
    assert world.api.zones() == []
    assert world.api.marks("simulation") == world.api.marks()
    with pytest.raises(ApiRefused, match="no scene 'cellar'; there is: simulation"):
        world.api.marks("cellar")


def test_what_it_did_and_what_is_wrong(world: World) -> None:
    """Tasks with their ends; events in their order; a fault until it is over."""
    assert world.chassis.go_to_mark("A2").wait(timeout=60.0).arrived
    until(lambda: world.api.task_history() and world.api.task_history()[-1].destination == "A2")
    record = world.api.task_history()[-1]
    assert (record.type, record.state) == (TaskType.PICK, TaskState.COMPLETED)
    world.sim.press_emergency_stop()
    until(world.api.unresolved)
    (fault,) = world.api.unresolved()
    assert ("emergency stop" in fault.text, fault.level) == (True, FaultLevel.SEVERE)
    assert world.api.events()[-1].code == fault.code
    told = world.api.statistics()
    assert (told.completed >= 1, told.metres >= 1.0, told.faults >= 1) == (True, True, True)
    assert 0.0 <= told.seconds_on < 3600.0
    assert abs(world.api.events()[-1].time - time.time()) < 60.0
    world.sim.release_emergency_stop()
    until(lambda: not world.api.unresolved())


def test_what_it_does_not_know_is_refused_with_a_sentence(world: World) -> None:
    """Rather than answered with zeros."""
    for kind in ("PlanPath", "map.Download", "map.SceneMd5"):
        with pytest.raises(ApiRefused, match="is not known here"):
            world.api.request(kind)


def test_another_map_is_refused_and_nothing_changes(world: World) -> None:
    before = world.api.scene()
    with pytest.raises(ApiRefused, match="SwitchMap"):
        world.api.switch_map("hall", "ground")
    assert world.api.scene() == before


@pytest.mark.parametrize("kind", sorted(name for name, one in wire.requests().items() if one.kind == "read"))
def test_a_question_has_the_same_answer_by_http_and_by_websocket(world: World, kind: str) -> None:
    """Without a number; whoever asks."""
    with ApiClient(world.server.url) as client:
        by_websocket, by_http = client.answer({"type": kind}), post(world, wire.path_of(kind))
    if by_http["ok"] and kind.endswith(("ScannerData", "PoseSpeed", "RobotInfo", "CountData")):
        by_websocket["body"], by_http["body"] = sorted(by_websocket["body"]), sorted(by_http["body"])
    assert by_http == by_websocket


@pytest.mark.promise("the password of Basic authentication")
def test_a_server_with_a_token_takes_it_as_the_password(world: World) -> None:
    """Of a Chassis as of the vendor's clients by HTTP; without it nothing is told."""
    token = "kd83-hsa2"
    with RobotApiServer(world.server.node, port=0, token=token, site=simulated_site(world.sim)) as server:

        def api(credentials: str) -> RobotApi:
            return Chassis(world.sim.master_uri, robot_api=f"{credentials}127.0.0.1:{server.port}").robot_api

        assert api(f"robot:{token}@").scene().name == "simulation"
        for credentials in ("", "robot:wrong-word@", f"{token}:robot@"):
            with pytest.raises(ApiRefused, match="wants a name and a password") as refused:
                api(credentials).scene()
            assert refused.value.status == 401


# -- commands and page ---------------------------------------------------------------------------------------


def test_the_commands_know_what_it_names(world: World, capsys: pytest.CaptureFixture[str]) -> None:
    to = ["--master", world.sim.master_uri, "--api-address", world.address]
    assert main([*to, "api", "Battery"]) == 0
    assert json.loads(capsys.readouterr().out)["power"] == 87
    assert main([*to, "api", "woosh.map.SceneList"]) == 0
    assert json.loads(capsys.readouterr().out)["scenes"][0]["maps"] == ["map"]
    assert main([*to, "api", "PlanPath"]) == 3
    assert "not known here" in capsys.readouterr().err
    assert main([*to, "marks", "list", "--json"]) == 0
    listed = {mark["name"]: mark for mark in json.loads(capsys.readouterr().out)}
    assert set(listed) == set(world.sim.marks)
    assert {mark["source"] for mark in listed.values()} == {"robot"}
    assert main([*to, "ready"]) == 0
    capsys.readouterr()
    assert main([*to, "doctor", "--listen", "0.2", "--json"]) == 0
    findings = json.loads(capsys.readouterr().out)["findings"]
    found = next(finding for finding in findings if finding["check"] == "robot_api")
    assert (found["level"], "map map of simulation, 7 marks" in found["text"]) == ("ok", True), found


def test_the_page_shows_the_marks_and_the_map_of_the_simulated_robot(world: World) -> None:
    pytest.importorskip("fastapi", reason="needs the extra `web`")
    pytest.importorskip("uvicorn", reason="needs the extra `web`")
    from tests.support.web import PageClient, serving

    with serving(world.chassis) as served, PageClient(served.port) as page:
        marks = {mark["name"]: mark for mark in served.get("marks").json}
        assert {name: (mark["x"], mark["source"]) for name, mark in marks.items()} == {
            name: (pose.x, "robot") for name, pose in world.sim.marks.items()
        }
        scenes = served.get("scenes").json
        assert (scenes["scene"], scenes["map"], scenes["zones"]) == ("simulation", "map", [])
        page.of("hello")
        site = page.wait(lambda d: d["t"] == "site" and d["map"])
        assert (site["map"], len(site["outline"])) == ("map", 12)


def test_sim_says_where_its_robot_api_is(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--sim", "api", "Battery"]) == 2
    assert "start `woosh sim --robot-api` and give --api-address 127.0.0.1:5480" in capsys.readouterr().err


# -- owners' programs ----------------------------------------------------------------------------------------


def test_a_program_that_asks_by_http_at_ten_hertz_and_listens_by_websocket(world: World) -> None:
    """On one kept connection, with the number of the robot in every body, as owners' programs do."""
    connection = http.client.HTTPConnection("127.0.0.1", world.server.port, timeout=5.0)
    with closing(connection), ApiClient(world.server.url) as listener:
        listener.subscribe(ROBOT + "TaskProc")
        motion = world.chassis.go_to_mark("A1")
        states = set()
        for _ in range(50):
            connection.request("POST", "/woosh/robot/TaskProc", json.dumps({"robotId": 7, "robot_id": "7"}))
            answer = json.loads(connection.getresponse().read())
            assert (answer["ok"], answer["type"]) == (True, ROBOT + "TaskProc")
            states.add((answer["body"]["dest"], answer["body"]["state"]))
            if ("A1", int(TaskState.RUNNING)) in states:
                break
            time.sleep(0.1)
        assert ("A1", int(TaskState.RUNNING)) in states
        assert listener.next_push(ROBOT + "TaskProc")
        motion.cancel()


# -- hostile input -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "body", "says"),
    [
        ("Battery", "{", "the body is not JSON"),
        ("Battery", b"\xff\xfe", "the body is not UTF-8"),
        ("Battery", "[" * 60_000, "the body"),
        ("Battery", '{"a":' * 100 + "1" + "}" * 100, "arrays and objects inside one another"),
        ("Battery", "{} {}", "more than 1 values in a row"),
        ("Battery", "[]", "expected an object"),
        ("Battery", "5", "expected an object"),
        ("Battery", '"text"', "expected an object"),
        ("Battery", '{"power": {"x": 1}}', "expected a whole number"),
        ("Battery", '{"power": "NaN"}', "expected a whole number"),
        ("Battery", '{"power": 1e999}', "expected a whole number"),
        ("Battery", '{"power": ' + "9" * 400 + "}", "expected a whole number"),
        ("Battery", '{"power": ' + "9" * 60_000 + "}", "the body is not JSON"),
        ("PlanNavPath", '{"end": {"x": NaN}}', "finite"),
        ("PlanNavPath", '{"end": {"x": "Infinity"}}', "finite"),
        ("PlanNavPath", '{"end": {"x": 1e39}}', "a number within float32"),
        ("PlanNavPath", '{"end": {"x": 1e30}}', "metres"),
        ("PlanNavPath", '{"tolerance": "-Infinity"}', "finite"),
        ("PlanNavPath", '{"end": {"x": "\\ud800"}}', "'\\ud800' given"),
        ("Battery", '{"power": true}', "expected a whole number"),
    ],
)
def test_a_body_that_cannot_be_meant_is_refused_with_a_sentence(
    world: World, kind: str, body: Any, says: str
) -> None:
    got = post(world, f"/woosh/robot/{kind}", body)
    assert (got["type"], got["ok"], got["body"]) == (ROBOT + kind, False, {})
    assert says in got["msg"]


@pytest.mark.parametrize("seed", range(4))
def test_whatever_bytes_come_the_next_client_is_answered(
    world: World, seed: int, caplog: pytest.LogCaptureFixture
) -> None:
    """Requests, each with some bytes changed, cut, doubled or in many pieces: an answer or an end, and no error of ours."""
    chance = random.Random(seed)
    for _ in range(100):
        kind = chance.choice([*wire.requests(), "woosh.Subscription", "x"])
        text = json.dumps({"name": "simulation", "power": 5, "start": {"x": 1}}).encode()
        data = bytearray(
            b"POST %b HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: %d\r\n\r\n%b"
            % (wire.path_of(kind).encode(), len(text), text)
            if chance.random() < 0.8
            else b"GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\n\r\n"
        )
        for _ in range(chance.randrange(4)):
            data[chance.randrange(len(data))] = chance.randrange(256)
        if chance.random() < 0.3:
            del data[chance.randrange(len(data)) :]
        data *= chance.choice((1, 1, 2))
        with socket.create_connection(("127.0.0.1", world.server.port), 20.0) as sock, suppress(OSError):
            cut = chance.randrange(len(data)) if data else 0
            sock.sendall(data[:cut])
            sock.sendall(data[cut:])
            sock.shutdown(socket.SHUT_WR)
            while sock.recv(1 << 16):
                pass
    assert post(world, "/woosh/robot/RobotState")["body"] == {"state": 2, "robotId": 7}
    assert not [record for record in caplog.records if record.exc_info], "an error of ours"


@pytest.mark.promise("answers requests by POST, too, by the same rules")
@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": "https://evil.example"},
        {"Origin": "https://evil.example", "Content-Type": "text/plain"},
        {"Origin": "null", "Content-Type": "application/x-www-form-urlencoded"},
        {"Sec-Fetch-Site": "cross-site", "Content-Type": "text/plain"},
        {"Host": "evil.example"},
    ],
)
def test_a_page_of_another_site_drives_no_robot(world: World, headers: dict[str, str]) -> None:
    """Where every command is open, as in `woosh sim --robot-api`; a program does it the next moment."""
    access = Access(write=["api:*"])
    with RobotApiServer(world.server.node, port=0, access=access, share=True) as server:
        open_world = world._replace(server=server)
        for _ in range(3):
            got = post(open_world, "/woosh/robot/Twist", {"linear": 0.2}, **headers)
            assert (got["ok"], got["type"]) == (False, "")
        with world.sim.lock:
            assert world.sim.world.body.velocity.is_standing(0.0, 0.0)
        until(
            lambda: (
                post(open_world, "/woosh/robot/Twist", {"linear": 0.2})["ok"]
                and not world.sim.world.body.velocity.is_standing(0.0, 0.0)
            )
        )
        assert post(open_world, "/woosh/robot/Twist")["ok"]


Crowd = Callable[[int], bytes]
CROWDS: dict[str, Crowd] = {
    "nothing": lambda n: b"",
    "half a request": lambda n: b"POST /woosh/robot/Battery HTTP/1.1\r\n",
    "half a body": lambda n: (
        b"POST /woosh/robot/Battery HTTP/1.1\r\nContent-Length: 60000\r\n\r\n" + b" " * 50_000
    ),
    "whole requests": lambda n: (
        b"POST /woosh/robot/RobotInfo HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n"
    ),
    "half a handshake": lambda n: b"GET / HTTP/1.1\r\nHost: localhost\r\n",
    "WebSockets": lambda n: (
        b"GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        b"Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n"
    ),
}


@pytest.mark.slow
@pytest.mark.promise("All connections by HTTP together are bounded")
@pytest.mark.parametrize("kind", CROWDS)
def test_two_thousand_connections_at_once_keep_no_client_from_its_answers(world: World, kind: str) -> None:
    """A client that is connected and a new one are answered all the time, in bounded time and memory."""
    over, slowest, failed = threading.Event(), [0.0], []

    def ask() -> None:
        try:
            while not over.is_set():
                began = time.monotonic()
                client.ask(ROBOT + "RobotState")
                with suppress(ConnectionError, http.client.HTTPException):  # replaced: asked again
                    post(world, "/woosh/robot/RobotState")
                slowest[0] = max(slowest[0], time.monotonic() - began)
                over.wait(0.02)
        except Exception as error:
            failed.append(error)

    with ApiClient(world.server.url) as client, ExitStack() as stack:
        thread = threading.Thread(target=ask)
        thread.start()
        try:
            for number in range(2000):
                sock = socket.create_connection(("127.0.0.1", world.server.port), 20.0)
                stack.enter_context(sock).setblocking(False)
                with suppress(OSError):
                    sock.sendall(CROWDS[kind](number))
            time.sleep(1.0)
        finally:
            over.set()
            thread.join(60.0)
        assert failed == []
        assert slowest[0] < 30.0  # bounded; a busy computer needs seconds
        assert len(world.server._server.slots) <= world.server.limits.pending_handshakes
        assert len(world.server._server.channels) <= world.server.limits.connections
    until(lambda: len(world.server._server.slots) == 0)
    assert post(world, "/woosh/robot/RobotState")["ok"]
