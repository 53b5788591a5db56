"""The Robot API of a simulated chassis, by raw WebSockets: what is answered, refused and pushed."""

from __future__ import annotations

import base64
import itertools
import json
import socket
import time
from collections.abc import Iterator
from typing import Any, NamedTuple

import pytest

from rosproto import Master, Node
from tests.support.extras import needs
from tests.support.png import read_png
from tests.support.robot_api import ApiClient
from tests.support.waiting import until
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.api_server import RobotApiServer, simulated_site
from woosh_pure.enums import RobotMode
from woosh_pure.firmware.versions import firmware_names
from woosh_pure.robot_api import wire

needs("api")

ROBOT, COUNT = "woosh.robot.", "woosh.robot.count."
TASKABLE, LOCALISED, EMERGENCY_STOP = 1, 1, 1024


class World(NamedTuple):
    sim: SimulatedChassis
    server: RobotApiServer


@pytest.fixture(scope="module")
def running() -> Iterator[World]:
    with (
        SimulatedChassis(speed=4.0, full_graph=False) as sim,
        Node("robot_api", master_uri=sim.master_uri, rosout=False) as node,
        RobotApiServer(node, port=0, robot_id=7, site=simulated_site(sim, 7)) as server,
    ):
        yield World(sim, server)


@pytest.fixture
def world(running: World) -> World:
    running.sim.reset()
    running.sim.speed = 4.0
    return running


@pytest.fixture
def client(world: World) -> Iterator[ApiClient]:
    with ApiClient(world.server.url) as client:
        yield client


def asked_until(client: ApiClient, kind: str, **wanted: object) -> dict[str, Any]:
    """Ask until the answer has these values: the world changes before its topics tell."""
    found: dict[str, Any] = {}

    def is_so() -> bool:
        found.update(client.ask(kind))
        return all(found.get(key) == value for key, value in wanted.items())

    until(is_so, what=lambda: f"{kind} with {wanted}; last {found}")
    return found


# -- requests ------------------------------------------------------------------------------------------------


def test_a_first_client_sees_everything(client: ApiClient, world: World) -> None:
    """RobotInfo has all sections that are known, right after the start of the server."""
    info = client.ask(ROBOT + "RobotInfo")
    assert info["robotId"] == 7
    assert info["state"] == 2
    assert info["mode"] == {"ctrl": 1, "work": 2}
    assert info["battery"]["power"] == 87
    assert info["genral"]["serialNumber"] == 7
    assert info["scene"] == {"sceneName": "simulation", "mapId": 1, "mapName": "map", "version": "1"}
    assert info["poseSpeed"]["twist"] == {"linear": 0.0, "angular": 0.0}
    assert info["deviceState"] == {"hardware": 0, "software": LOCALISED}
    assert info["operationState"] == {"nav": 0, "robot": TASKABLE}
    assert len(info["model"]["model"]) > 4
    assert {
        "taskProc",
        "hardwareState",
        "setting",
        "network",
        "taskHistory",
        "statusCodes",
        "abnormalCodes",
    } <= set(info)


@pytest.mark.promise("a client of the Robot API asks for a motion or a change that is not opened")
@pytest.mark.parametrize("kind", sorted(name for name, one in wire.requests().items() if one.kind != "read"))
def test_what_moves_or_changes_something_is_refused(client: ApiClient, world: World, kind: str) -> None:
    """Every request that is not a read: `ok` is false, and nothing is published, called or sent as a goal."""
    names = {field.key for field in wire.fields(kind)}
    given = {
        "linear": 0.5, "taskId": 5, "pose": {"x": 3.0}, "stepControl": {"steps": [{"mode": 1}], "action": 1},
    }  # fmt: skip
    body = {key: value for key, value in given.items() if key in names}
    got = client.answer({"type": kind, "body": body, "sn": 3})
    assert (got["type"], got["ok"], got["body"], got["sn"]) == (kind, False, {}, 3)
    assert "is refused: " in got["msg"]
    with world.sim.lock:
        assert world.sim.world.motion is None
        assert world.sim.world.body.velocity.is_standing(0.0, 0.0)


@pytest.mark.promise("a client of the Robot API asks for a motion or a change that is not opened")
def test_the_node_of_the_server_writes_nothing(client: ApiClient, world: World) -> None:
    """Whatever was asked, a zero and a cancel as well: it publishes on no topic of the robot."""
    for kind in wire.requests():
        client.answer({"type": kind})
    client.answer({"type": "woosh.ros.CallAction", "body": {"stepControl": {}}})
    client.answer({"type": "woosh.robot.ActionOrder", "body": {"order": 4}})
    node = world.server.node
    published = node.master.get_system_state().publishers
    assert [topic for topic, names in published.items() if node.name in names] == []


@pytest.mark.parametrize(
    "frame",
    [
        {"type": "woosh.robot.RobotState"},
        {"type": "woosh.robot.RobotState", "body": None},
        {"type": "woosh.robot.RobotState", "body": {"robotId": 99}},
        {"type": "woosh.robot.RobotState", "body": {"robot_id": "99"}, "timestamp": 1790000000000},
    ],
)
def test_owners_ask_in_many_ways(client: ApiClient, frame: dict[str, Any]) -> None:
    """Without a body, with a number of the robot that is ignored, with whole seconds as number, twice the same."""
    number = int(time.time())
    for _ in range(2):
        assert client.answer({**frame, "sn": number}) == {
            "type": "woosh.robot.RobotState",
            "body": {"state": 2, "robotId": 7},
            "ok": True,
            "msg": "",
            "sn": number,
        }
    assert "sn" not in client.answer(frame)
    assert client.answer(json.dumps(frame).encode())["ok"]


def test_many_requests_at_once_are_matched_by_their_numbers(client: ApiClient) -> None:
    kinds = ["RobotInfo", "Battery", "ScannerData", "PoseSpeed", "Mode"] * 4
    for number, kind in enumerate(kinds):
        client.send({"type": ROBOT + kind, "body": {}, "sn": number})
    answers = [client.receive() for _ in kinds]
    assert {(one["sn"], one["type"]) for one in answers} == {
        (n, ROBOT + kind) for n, kind in enumerate(kinds)
    }
    assert all(one["ok"] for one in answers)


@pytest.mark.parametrize(
    ("frame", "says"),
    [
        ("{", "the message is not JSON"),
        ("", "expected an object"),
        ("[]", "the message is an array of 0; expected an object"),
        ("{} {}", "more than 1 values in a row"),
        (b"\xff\xfe", "is not UTF-8"),
        ("[" * 60_000, "the message"),
        ('{"type":' + '{"a":' * 100 + "1" + "}" * 101, "arrays and objects inside one another"),
        ({}, "has no type"),
        ({"type": 5}, "has no type"),
        ({"type": None}, "has no type"),
        ({"type": "woosh.robot.What"}, "'woosh.robot.What' is not a request"),
        ({"type": "woosh.robot.State"}, "is not a request"),
        ({"type": "x" * 50_000}, "is not a request"),
        ({"type": "\ud800"}, "is not a request"),
        ({"type": "woosh.dispatch.robot.Robots"}, "is not a request"),
        ({"type": "woosh.robot.RobotInfo", "sn": "7"}, "sn is '7'; expected a whole number"),
        ({"type": "woosh.robot.RobotInfo", "sn": 1.5}, "sn is 1.5"),
        ({"type": "woosh.robot.RobotInfo", "sn": True}, "sn is true"),
        ({"type": "woosh.robot.RobotInfo", "sn": 10**400}, "sn is a number of more than 64 bits"),
        ({"type": "woosh.robot.RobotInfo", "body": []}, "expected an object"),
        (
            {"type": "woosh.robot.Battery", "body": {"power": "x"}},
            "Battery.power: 'x' given; expected a whole number",
        ),
        ({"type": "woosh.robot.Battery", "body": {"power": 10**400}}, "expected a whole number"),
        ({"type": "woosh.robot.PlanNavPath", "body": {"end": {"x": "NaN"}}}, "finite"),
        ({"type": "woosh.robot.PlanNavPath", "body": {"end": {"x": 1e30}}}, "metres"),
        ({"type": "woosh.robot.PlanNavPath", "body": {"tolerance": "Infinity"}}, "finite"),
        (
            {"type": "woosh.map.SceneData", "body": {"name": "cellar"}},
            "no scene 'cellar'; there is: simulation",
        ),
        ({"type": "woosh.map.mark.storage.Find", "body": {"no": "Z9"}}, "no mark 'Z9'"),
        ({"type": "woosh.robot.PlanPath"}, "is not known here"),
        ({"type": "woosh.Subscription", "body": {"topics": 5}}, "expected an array"),
        (
            {"type": "woosh.Subscription", "body": {"sub": True, "topics": ["/scan"]}},
            "not topics of the Robot API",
        ),
    ],
    ids=itertools.count(),
)
def test_what_cannot_be_answered_is_refused_with_a_sentence(client: ApiClient, frame: Any, says: str) -> None:
    """Hostile, wrong or unknown: an answer each, and the connection goes on."""
    got = client.answer(frame)
    assert says in got["msg"]
    assert (got["ok"], got["body"]) == (False, {})
    assert len(got["type"]) <= 200
    assert client.ask(ROBOT + "RobotState") == {"state": 2, "robotId": 7}


def test_a_message_that_is_too_long_ends_its_connection_only(client: ApiClient, world: World) -> None:
    from websockets.exceptions import ConnectionClosed

    with ApiClient(world.server.url) as hostile, pytest.raises(ConnectionClosed):
        hostile.answer({"type": "x" * 100_000})
    assert client.ask(ROBOT + "RobotState")


@pytest.mark.promise(
    "A change or a WebSocket that is requested by a page of another site is refused by its `Origin`",
    "A `Host` that is neither localhost, an IP address nor a configured name",
)
def test_a_page_of_another_origin_cannot_connect(world: World) -> None:
    """A browser's page somewhere else reads no robot; the vendor's client sends no Origin."""
    from websockets.exceptions import InvalidStatus

    for header in ({"Origin": "https://example.org"}, {"Host": "example.org"}):
        with pytest.raises(InvalidStatus), ApiClient(world.server.url, additional_headers=header):
            pass


def test_it_listens_on_this_computer_only(world: World) -> None:
    assert world.server.host == "127.0.0.1"
    with socket.socket() as other:  # another address of the same computer
        other.settimeout(5.0)
        with pytest.raises(OSError):
            other.connect(("127.0.0.2", world.server.port))


# -- marks and maps ------------------------------------------------------------------------------------------


def test_marks_are_listed_with_names_and_poses(client: ApiClient, world: World) -> None:
    (scene,) = client.ask("woosh.map.SceneList")["scenes"]
    (easy,) = client.ask("woosh.map.SceneDataEasy", {"name": scene["name"]})["maps"]
    assert scene["maps"] == [easy["name"]]
    marks = {mark["identity"]["no"]: mark for kind in easy["storages"].values() for mark in kind}
    assert set(marks) == set(world.sim.marks)
    assert marks["A1"]["pose"]["real"] == pytest.approx({"x": 3.0, "y": 1.0, "theta": 1.5708}, abs=1e-4)
    assert [mark["identity"]["no"] for mark in easy["storages"]["chargers"]] == ["C1"]
    found = client.ask("woosh.map.mark.storage.Find", {"no": "C1"})
    assert found["charger"] == {"parking": False, "robots": []}
    assert found["identity"] == marks["C1"]["identity"]


def test_the_map_is_a_picture_with_the_north_up(client: ApiClient, world: World) -> None:
    (found,) = client.ask("woosh.map.SceneData", {})["maps"]
    grid = world.sim.world.site.grid
    assert (found["resolution"], found["origin"]) == (grid.resolution, {"x": -2.0, "y": -4.0, "theta": 0.0})
    picture = read_png(base64.b64decode(found["mapPng"]))
    assert picture[:, :, 0].tolist() == grid.to_grey().tolist()
    assert len(found["markInfo"]["storages"]) == len(world.sim.marks)


def test_a_path_is_planned_and_nothing_drives(client: ApiClient, world: World) -> None:
    poses = client.ask(ROBOT + "PlanNavPath", {"end": {"x": 3.0, "y": "1"}})["path"]["poses"]
    assert (poses[-1]["x"], poses[-1]["y"]) == pytest.approx((3.0, 1.0), abs=0.2)
    assert world.sim.world.motion is None


# -- states --------------------------------------------------------------------------------------------------


def test_the_emergency_stop_is_a_bit_an_event_and_unresolved(client: ApiClient, world: World) -> None:
    """Also for a client that connects after it was pressed."""
    world.sim.press_emergency_stop()
    with ApiClient(world.server.url) as late:
        asked_until(late, ROBOT + "DeviceState", hardware=EMERGENCY_STOP)
        asked_until(late, ROBOT + "OperationState", robot=0)
        until(lambda: late.ask(COUNT + "AbnormalCodes")["scs"])  # its topic may come later than the state's
        (code,) = late.ask(COUNT + "AbnormalCodes")["scs"]
        assert (code["code"], code["level"]) == ("110201000013", 3)
        assert code["time"].isdecimal()
    world.sim.release_emergency_stop()
    asked_until(client, ROBOT + "DeviceState", hardware=0)
    asked_until(client, COUNT + "AbnormalCodes", scs=[])
    assert "110201000013" in [one["code"] for one in client.ask(COUNT + "StatusCodes")["scs"]]


def test_a_robot_that_is_lost_says_so(client: ApiClient, world: World) -> None:
    world.sim.lose_localization()
    asked_until(client, ROBOT + "DeviceState", software=0)
    asked_until(client, ROBOT + "RobotState", state=1)


def test_a_task_is_pushed_and_kept(client: ApiClient, world: World) -> None:
    """Its states with its id, the path while it drives, the pose at most ten times a second, and its end."""
    client.subscribe(ROBOT + "TaskProc", ROBOT + "PoseSpeed", ROBOT + "NavPath", ROBOT + "RobotState")
    with Chassis(world.sim.master_uri) as chassis:
        began = time.monotonic()
        chassis.go_to_mark("A1").wait(60.0)
    frames, took = client.pushed_within(1.0), time.monotonic() - began
    tasks = [
        one["body"] for one in frames if one["type"] == ROBOT + "TaskProc" and one["body"]["dest"] == "A1"
    ]
    assert tasks[-1]["state"] == 7
    assert 3 in [task["state"] for task in tasks]
    assert len({task["robotTaskId"] for task in tasks}) == 1
    poses = [one["body"]["pose"] for one in frames if one["type"] == ROBOT + "PoseSpeed"]
    assert 3 < len(poses) <= 10 * took + 2
    paths = [one["body"] for one in frames if one["type"] == ROBOT + "NavPath"]
    assert any(path.get("path", {}).get("poses") for path in paths)
    assert paths[-1] == {"robotId": 7}
    assert [one["state"] for one in client.ask(ROBOT + "TaskHistory")["tes"]][-1] == 7


# -- pushes --------------------------------------------------------------------------------------------------


def test_present_values_are_pushed_once_then_only_changes(client: ApiClient, world: World) -> None:
    """A robot that stands is silent; what a test before has left may still change once."""
    topics = sorted(wire.topics() - {COUNT + "StatusCode", ROBOT + "ScannerData"})
    client.subscribe(*topics)
    client.subscribe(*topics)
    silent = {COUNT + name for name in ("Operation", "Task", "Status")}
    silent |= {ROBOT + "BuildMapData", "woosh.ros.Feedbacks", "woosh.device.RfRemoteController"}
    frames = client.pushed_within(1.0)
    until(
        lambda: (
            (frames.extend(client.pushed_within(0.1)), {one["type"] for one in frames})[1]
            == set(topics) - silent
        )
    )
    last: dict[str, Any] = {}
    for frame in frames:
        assert last.get(frame["type"]) != frame["body"]
        last[frame["type"]] = frame["body"]
    client.subscribe(ROBOT + "Mode", sub=False)
    client.subscribe(ROBOT + "Mode")
    assert client.next_push(ROBOT + "Mode") == {"ctrl": 1, "work": 2, "robotId": 7}
    world.sim.set_mode(RobotMode.MANUAL)
    assert client.next_push(ROBOT + "Mode") == {"ctrl": 2, "work": 2, "robotId": 7}


def test_every_spelling_of_a_topic_is_taken_and_an_end_of_it(client: ApiClient, world: World) -> None:
    client.subscribe("robot.count.StatusCode", "woosh.robot.count.AbnormalCode")
    assert client.next_push(COUNT + "AbnormalCodes") == {"scs": [], "robotId": 7}
    world.sim.press_emergency_stop()
    assert client.next_push(COUNT + "StatusCode")["code"] == "110201000013"
    client.subscribe("robot.count.StatusCode", "no.such.topic", "woosh.robot.count.AbnormalCodes", sub=False)
    assert client.ask(ROBOT + "RobotState")
    client.pushes.clear()
    world.sim.release_emergency_stop()
    asked_until(client, COUNT + "AbnormalCodes", scs=[])
    assert client.pushed_within(0.3) == []


def test_scans_are_read_only_while_somebody_wants_them(client: ApiClient, world: World) -> None:
    """At most five a second; the robot's topic is left after the last client."""
    shared = world.server._gateway.shared_subscriptions
    until(lambda: "/scan" not in shared.topics)
    client.subscribe(ROBOT + "ScannerData")
    scan = client.next_push(ROBOT + "ScannerData")
    assert (len(scan["ranges"]), set(scan["pose"]), "offset" in scan) == (360, {"x", "y", "theta"}, False)
    frames = client.pushed_within(1.0)
    assert 1 <= len(frames) <= 6
    client.subscribe(ROBOT + "ScannerData", sub=False)
    until(lambda: "/scan" not in shared.topics)
    assert len(client.ask(ROBOT + "ScannerData")["ranges"]) == 360


def test_clients_that_go_without_a_word_leave_nothing(world: World) -> None:
    with ApiClient(world.server.url) as client:
        client.subscribe(*wire.topics())
        client.next_push(ROBOT + "ScannerData")
    shared = world.server._gateway.shared_subscriptions
    until(lambda: "/scan" not in shared.topics)
    until(lambda: not world.server._gateway._sessions)


def test_what_nobody_tells_is_not_known() -> None:
    """Over a graph without a robot, and without a site: no zeros, and no claim that an emergency stop is released."""
    with (
        Master() as master,
        Node("alone", master_uri=master.uri, rosout=False) as node,
        RobotApiServer(node, port=0) as server,
        ApiClient(server.url) as client,
    ):
        info = client.ask(ROBOT + "RobotInfo")
        assert set(info) == {"robotId", "state", "taskHistory", "statusCodes", "abnormalCodes"}
        assert info["state"] == 0  # undefined
        for kind in (
            "DeviceState",
            "PoseSpeed",
            "Battery",
            "RobotState",
            "Scene",
            "OperationState",
            "HardwareState",
        ):
            got = client.answer({"type": ROBOT + kind})
            assert not got["ok"]
            assert "not known here" in got["msg"]
        assert "no scan was received" in client.answer({"type": ROBOT + "ScannerData"})["msg"]


def test_scans_that_cannot_be_subscribed_are_refused_with_the_reason() -> None:
    """They are subscribed when the first client wants them, and the master may have gone. Asked again, they come."""
    scanner = ROBOT + "ScannerData"
    with (
        Master() as master,
        Node("door", master_uri=master.uri, rosout=False) as node,
        RobotApiServer(node, port=0) as server,
        ApiClient(server.url) as client,
    ):
        port = int(master.uri.rstrip("/").rpartition(":")[2])
        master.close()
        client.subscribe(scanner)
        refused = client.receive()
        assert (refused["type"], refused["ok"], refused["body"]) == ("woosh.Subscription", False, {})
        assert scanner in refused["msg"]
        with (
            Master(port=port),
            Node("laser", master_uri=master.uri, rosout=False) as robot,
            robot.publisher("/scan", "sensor_msgs/LaserScan", latch=True) as publisher,
        ):
            publisher.publish(ranges=[1.0, 2.0])
            client.subscribe(scanner)
            assert client.next_push(scanner)["ranges"] == [1.0, 2.0]


def test_scans_of_another_type_are_refused_with_the_type() -> None:
    with (
        Master() as master,
        Node("laser", master_uri=master.uri, rosout=False) as robot,
        robot.publisher("/scan", "std_msgs/String", latch=True) as publisher,
        Node("door", master_uri=master.uri, rosout=False) as node,
        RobotApiServer(node, port=0) as server,
        ApiClient(server.url) as client,
    ):
        publisher.publish(data="no scan")
        client.subscribe(ROBOT + "ScannerData")
        refused = client.receive()
        assert (refused["type"], refused["ok"]) == ("woosh.Subscription", False)
        assert "std_msgs/String" in refused["msg"]
        until(lambda: not server._gateway._sessions)


def test_an_old_pose_is_not_the_present_one(
    monkeypatch: pytest.MonkeyPatch, client: ApiClient, world: World
) -> None:
    """A robot that falls silent has no pose after some seconds; then it is pushed again."""
    from woosh_pure.api_server import state

    assert client.ask(ROBOT + "PoseSpeed")
    monkeypatch.setattr(state, "MAX_AGE", 0.3)
    world.sim.fall_silent(1.5)
    until(lambda: not client.answer({"type": ROBOT + "PoseSpeed"})["ok"])
    until(lambda: client.answer({"type": ROBOT + "PoseSpeed"})["ok"])


def test_a_server_closes_in_bounded_time() -> None:
    with (
        SimulatedChassis(full_graph=False) as sim,
        Node("api", master_uri=sim.master_uri, rosout=False) as node,
    ):
        server = RobotApiServer(node, port=0)
        with ApiClient(server.url) as client:
            client.subscribe(*wire.topics())
            client.ask(ROBOT + "Mode")
            began = time.monotonic()
            server.close()
            server.close()
            assert time.monotonic() - began < 5.0


@pytest.mark.parametrize("firmware", firmware_names())
def test_a_robot_of_an_older_firmware_is_read_as_well(firmware: str) -> None:
    """Fields that its messages lack have their defaults."""
    with (
        SimulatedChassis(full_graph=False, firmware=firmware) as sim,
        Node("api", master_uri=sim.master_uri, rosout=False) as node,
        RobotApiServer(node, port=0, site=simulated_site(sim)) as server,
        ApiClient(server.url) as client,
    ):
        info = client.ask(ROBOT + "RobotInfo")
        assert (info["state"], info["mode"], info["battery"]["power"]) == (2, {"ctrl": 1, "work": 2}, 87)
        assert {"taskProc", "poseSpeed", "operationState"} <= set(info)


def test_a_publisher_of_another_type_tells_nothing(caplog: pytest.LogCaptureFixture) -> None:
    """It is named once in the log, and what it covers is not known."""
    with (
        Master() as master,
        Node("odd", master_uri=master.uri, rosout=False) as odd,
        Node("api", master_uri=master.uri, rosout=False) as node,
    ):
        publisher = odd.publisher("/battery", "std_msgs/String", latch=True)
        publisher.publish(data="full")
        with RobotApiServer(node, port=0) as server, ApiClient(server.url) as client:
            until(lambda: "/odd publishes std_msgs/String, not woosh_msgs/Battery" in caplog.text)
            assert "not known here" in client.answer({"type": ROBOT + "Battery"})["msg"]


def test_a_fault_that_comes_again_after_its_module_was_cleared_is_a_new_event() -> None:
    """A code that is only repeated is not; the end of a module ends the faults of its submodules."""
    fault, end_of_module = 140201000022, 140200000000
    with (
        Master() as master,
        Node("robot", master_uri=master.uri, rosout=False) as robot,
        Node("api", master_uri=master.uri, rosout=False) as node,
        RobotApiServer(node, port=0) as server,
        ApiClient(server.url) as client,
    ):
        publisher = robot.publisher("/status_code", "std_msgs/UInt64")
        publisher.wait_for_connection()
        for code in (fault, fault, end_of_module, fault):
            publisher.publish(data=code)
        until(lambda: len(client.ask(COUNT + "StatusCodes")["scs"]) >= 3)
        assert [one["code"] for one in client.ask(COUNT + "StatusCodes")["scs"]] == [
            str(fault),
            str(end_of_module),
            str(fault),
        ]
        assert [one["code"] for one in client.ask(COUNT + "AbnormalCodes")["scs"]] == [str(fault)]
