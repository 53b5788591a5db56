"""Commands through the Robot API of a simulated chassis: what is done, what is refused, and what stops it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import pytest

from rosproto import Node
from rosproto.gateway import Access
from tests.support.api_driver import ApiDriver
from tests.support.driving_commands import moving
from tests.support.extras import needs
from tests.support.proxy import FaultProxy
from tests.support.robot_api import ApiClient
from tests.support.waiting import until
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.api_server import RobotApiServer, commands, simulated_site
from woosh_pure.enums import RobotMode
from woosh_pure.lease import ChassisLease
from woosh_pure.robot_api import wire

needs("api")

ROBOT = "woosh.robot."
TWIST, CALL, STEP = ROBOT + "Twist", "woosh.ros.CallAction", "woosh.ros.action.StepControl"
DONE, CANCELLED, FAILED, RUNNING = 1, -2, -1, 2
SLOW = {"steps": [{"mode": 1, "value": 3.0, "speed": 0.1}], "action": 1}


class World(NamedTuple):
    sim: SimulatedChassis
    server: RobotApiServer


@contextmanager
def serving(sim: SimulatedChassis, *write: str, **more: Any) -> Iterator[RobotApiServer]:
    """A server on a node of its own."""
    with (
        Node("robot_api", master_uri=sim.master_uri, rosout=False, anonymous=True) as node,
        RobotApiServer(node, port=0, access=Access(write=write), site=simulated_site(sim), **more) as server,
    ):
        yield server


@pytest.fixture(scope="module")
def running() -> Iterator[World]:
    with SimulatedChassis(full_graph=False) as sim, serving(sim, "api:*") as server:
        yield World(sim, server)


@pytest.fixture
def world(running: World) -> World:
    commands = running.server._gateway.commands
    driving, goals = commands._driving, commands._goals  # type: ignore[attr-defined]
    until(lambda: all(time.monotonic() - last > 0.5 for last in list(driving.values())))
    running.sim.reset()
    running.sim.speed = 1.0
    until(lambda: not goals, what="the end of the actions of the test before")
    return running


@pytest.fixture
def client(world: World) -> Iterator[ApiClient]:
    with ApiClient(world.server.url) as client:
        until(lambda: client.ask(ROBOT + "OperationState")["robot"] == 1)
        yield client


def refused(client: ApiClient, kind: str, body: dict[str, Any]) -> str:
    got = client.answer({"type": kind, "body": body})
    assert (got["ok"], got["body"]) == (False, {})
    text: str = got["msg"]
    return text


def stands(sim: SimulatedChassis, within: float = 20.0) -> None:
    until(lambda: not moving(sim), within, "the robot stands")


def begins(sim: SimulatedChassis) -> None:
    until(lambda: moving(sim), what="the robot moves")


def feedback(client: ApiClient) -> list[dict[str, Any]]:
    """The feedbacks of one action to its end."""
    found: list[dict[str, Any]] = []
    while not found or found[-1]["state"] == RUNNING:
        found += client.next_push("woosh.ros.Feedbacks", 60.0)["fbs"]
    return found


def task_until(client: ApiClient, state: int, task_id: str) -> None:
    def is_so() -> bool:
        task = client.ask(ROBOT + "TaskProc")
        return (task["state"], task["robotTaskId"]) == (state, task_id)

    until(is_so, 60.0, lambda: client.ask(ROBOT + "TaskProc"))


# -- velocities ----------------------------------------------------------------------------------------------


def test_a_velocity_is_obeyed_until_a_zero(world: World, client: ApiClient) -> None:
    """The answer is an empty body; a zero of no fields ends the drive at once, and no further zeros are due."""
    watchdog = world.server._gateway.velocity_watchdog
    until(lambda: client.ask(TWIST, {"linear": 0.3}) == {} and moving(world.sim))
    assert client.ask(TWIST, {}) == {}
    zeros = watchdog.zeros  # a busy computer may have been silent for too long before
    stands(world.sim)
    time.sleep(0.6)
    assert watchdog.zeros == zeros


@pytest.mark.promise("a client of the Robot API drives while the robot is not idle")
def test_a_zero_that_is_the_first_velocity_of_a_server_reaches_the_robot(world: World) -> None:
    """Its topic is opened for it, and the robot connects to that a moment later."""
    with (
        Node("driver", master_uri=world.sim.master_uri, rosout=False) as node,
        node.publisher("/smooth_cmd_vel", "geometry_msgs/Twist") as publisher,
    ):
        publisher.wait_for_connection(5.0)
        velocity = publisher.message_class()
        velocity.angular.z = 0.3
        # Again and again: a zero of the test before may still be on its way.
        until(lambda: publisher.publish(velocity) or moving(world.sim), what="the robot moves")
    with serving(world.sim, "api:*") as server, ApiClient(server.url) as client:
        assert client.ask(TWIST, {}) == {}
        stands(world.sim, 5.0)


@pytest.mark.promise("a client of the Robot API drives while the robot is not idle")
def test_a_zero_does_not_wait_for_the_scans_that_its_client_subscribes(
    world: World, client: ApiClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They are subscribed at the master, which may be slow."""
    shared = world.server._gateway.shared_subscriptions
    asked, go_on, real = threading.Event(), threading.Event(), shared.open

    def slow(*args: Any) -> Any:
        asked.set()
        go_on.wait(30.0)
        return real(*args)

    monkeypatch.setattr(shared, "open", slow)
    try:
        client.subscribe(ROBOT + "ScannerData")
        assert asked.wait(10.0)
        assert client.answer({"type": TWIST}, 5.0)["ok"]
    finally:
        go_on.set()
    assert client.next_push(ROBOT + "ScannerData")["ranges"]
    client.subscribe(ROBOT + "ScannerData", sub=False)


def test_of_two_clients_that_begin_at_the_same_instant_one_drives(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    both = threading.Barrier(2)
    monkeypatch.setattr(commands, "other_drivers", lambda node: [both.wait(10.0)][:0])
    answers: list[dict[str, Any]] = []

    def begin() -> None:
        with ApiClient(world.server.url) as client:
            answers.append(client.answer({"type": TWIST, "body": {"linear": 0.1}}))
            everybody.wait(10.0)  # a client that goes does not drive any more

    everybody = threading.Barrier(2)
    threads = [threading.Thread(target=begin) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(20.0)
    assert sorted(answer["ok"] for answer in answers) == [False, True]
    assert "another client drives the robot" in "".join(answer["msg"] for answer in answers)


WAYS: dict[str, Callable[[ApiDriver, FaultProxy], object]] = {
    "silent": lambda driver, proxy: driver.fall_silent(),
    "gone": lambda driver, proxy: driver.client.close_socket(),
    "reset": lambda driver, proxy: proxy.reset(),
    "cut off": lambda driver, proxy: proxy.stall(),
}


@pytest.mark.promise("a client of the Robot API that drives falls silent, goes, is killed")
@pytest.mark.parametrize("way", WAYS)
def test_zero_follows_a_client_that_is_not_heard_any_more(world: World, way: str) -> None:
    """The simulated chassis drives on by itself, so that only a zero can have ended it."""
    watchdog = world.server._gateway.velocity_watchdog
    with (
        FaultProxy("127.0.0.1", world.server.port) as proxy,
        ApiDriver(f"ws://127.0.0.1:{proxy.port}") as driver,
    ):
        begins(world.sim)
        before = watchdog.zeros
        began = time.monotonic()
        WAYS[way](driver, proxy)
        until(lambda: watchdog.zeros > before)
        assert time.monotonic() - began < 1.5  # 0.5 s, on a busy computer
        until(lambda: watchdog.zeros >= before + 5)  # they begin anew if a velocity that waited came between
        stands(world.sim)
        proxy.close()


@pytest.mark.skipif(os.name != "posix", reason="needs SIGKILL and SIGSTOP")
@pytest.mark.promise("a client of the Robot API that drives falls silent, goes, is killed")
@pytest.mark.parametrize("how", ["SIGKILL", "SIGSTOP"])
def test_zero_follows_a_client_that_is_killed_or_stopped(world: World, how: str) -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "tests.support.api_driver", world.server.url, "0.2"],
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == "driving\n"
        begins(world.sim)
        process.send_signal(getattr(signal, how))
        stands(world.sim)
    finally:
        process.kill()
        process.communicate(timeout=10)


@pytest.mark.promise("a velocity through the Robot API that is not finite")
@pytest.mark.parametrize(
    ("body", "says"),
    [
        ({"linear": "NaN"}, "finite"),
        ({"angular": "-Infinity"}, "finite"),
        ({"linear": 1001.0}, "more than the limit"),
        ({"linear": 1.1}, "more than the limit of 1.0 m/s"),
        ({"linear": 0.9, "linearY": 0.9}, "more than the limit of 1.0 m/s"),
        ({"angular": -1.2}, "more than the limit of 1.0 rad/s"),
        ({"linear": {"x": 1}}, "expected"),
        ({"linear": 10**400}, "expected"),
    ],
)
def test_a_velocity_that_the_chassis_may_not_have_is_refused(
    world: World, client: ApiClient, body: dict[str, Any], says: str
) -> None:
    """Not clamped; neither does it keep a drive alive."""
    assert says in refused(client, TWIST, body)
    assert not moving(world.sim)


@pytest.mark.promise("a client of the Robot API drives while the robot is not idle")
@pytest.mark.parametrize("state", ["manual", "emergency stop", "task", "action"])
def test_a_velocity_is_refused_unless_automatic_and_idle(world: World, client: ApiClient, state: str) -> None:
    if state == "manual":
        world.sim.set_mode(RobotMode.MANUAL)
        until(lambda: client.ask(ROBOT + "Mode")["ctrl"] == 2)
    elif state == "emergency stop":
        world.sim.press_emergency_stop()
        until(lambda: client.ask(ROBOT + "RobotState")["state"] != 2)
    elif state == "task":
        client.ask(ROBOT + "ExecTask", {"taskId": 7, "type": 1, "markNo": "B1"})
        until(lambda: client.ask(ROBOT + "RobotState")["state"] == 4)
    else:
        client.ask(CALL, {"stepControl": SLOW})
        begins(world.sim)
    assert "so it is not driven" in refused(client, TWIST, {"linear": 0.2})
    assert client.ask(TWIST, {}) == {}  # but never a zero
    client.answer({"type": CALL, "body": {"stepControl": {"action": 0}}})
    client.answer({"type": ROBOT + "ActionOrder", "body": {"order": 4}})


def test_a_robot_that_does_not_know_where_it_is_can_be_driven(world: World, client: ApiClient) -> None:
    world.sim.lose_localization()
    until(lambda: client.ask(ROBOT + "RobotState")["state"] == 1)
    until(lambda: client.ask(TWIST, {"linear": 0.2}) == {} and moving(world.sim))
    client.ask(TWIST)
    stands(world.sim)


@pytest.mark.promise("a client of the Robot API drives, and another one sends a velocity")
def test_one_client_drives_at_a_time(world: World, client: ApiClient) -> None:
    """The other is told where the first one is; its zero is obeyed all the same."""
    with ApiDriver(world.server.url, angular=0.3, linear=0.0) as driver:
        until(lambda: driver.accepted > 3)
        assert "another client drives the robot: 127.0.0.1" in refused(client, TWIST, {"linear": 0.2})
        assert "another client drives" in refused(client, CALL, {"stepControl": SLOW})
        assert client.ask(TWIST) == {}
        driver.fall_silent()
    until(lambda: client.answer({"type": TWIST, "body": {"linear": 0.2}})["ok"])
    client.ask(TWIST)


def test_a_server_that_shares_obeys_the_last_one(world: World) -> None:
    with (
        serving(world.sim, "api:*", share=True) as server,
        ApiDriver(server.url, angular=0.3, linear=0.0),
        ApiClient(server.url) as client,
    ):
        begins(world.sim)
        assert client.ask(TWIST, {"linear": 0.1}) == {}


def test_another_program_that_can_drive_is_named(world: World, client: ApiClient) -> None:
    with Node("joystick", master_uri=world.sim.master_uri, rosout=False) as node:
        node.publisher("/smooth_cmd_vel", "geometry_msgs/Twist")
        said = refused(client, TWIST, {"linear": 0.2})
        assert "/joystick" in said
        assert "can also send velocities" in said
        assert client.ask(TWIST) == {}


def test_nobody_takes_a_server_for_a_driver_after_a_drive(
    world: World, client: ApiClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(commands, "IDLE_SECONDS", 0.1)
    client.ask(TWIST, {"linear": 0.1})
    client.ask(TWIST)
    node = world.server.node
    until(lambda: node.name not in node.master.get_system_state().publishers.get("/smooth_cmd_vel", ()))
    assert client.ask(TWIST) == {}  # the topic is opened again


# -- tasks ---------------------------------------------------------------------------------------------------


def test_a_task_has_the_clients_own_number_and_ends_done(world: World, client: ApiClient) -> None:
    world.sim.speed = 4.0
    client.subscribe(ROBOT + "TaskProc")
    assert client.ask(ROBOT + "ExecTask", {"task_id": "66666", "type": 1, "mark_no": "A1"}) == {}
    states = []
    while 7 not in states:
        task = client.next_push(ROBOT + "TaskProc", 60.0)
        if task["robotTaskId"] == "66666":
            states.append(task["state"])
    assert 3 in states


def test_orders_go_to_the_task_under_way(world: World, client: ApiClient) -> None:
    client.ask(ROBOT + "ExecTask", {"taskId": 5, "type": 1, "pose": {"x": 3.0, "y": 0.5}})
    task_until(client, 3, "5")
    for order, state in ((2, 4), (3, 3), (4, 8)):
        client.ask(ROBOT + "ActionOrder", {"order": order})
        task_until(client, state, "5")
    stands(world.sim)
    assert "no task to cancel" in refused(client, ROBOT + "ActionOrder", {"order": 4})
    for order in (0, 1, 9):
        assert "expected 2 to 8" in refused(client, ROBOT + "ActionOrder", {"order": order})


def test_an_order_ends_a_task_that_somebody_else_gave(world: World, client: ApiClient) -> None:
    """As on a robot: an order names no task."""
    with Chassis(world.sim.master_uri) as chassis:
        handle = chassis.go_to_mark("B1")
        begins(world.sim)
        until(lambda: client.ask(ROBOT + "TaskProc")["state"] == 3)
        client.ask(ROBOT + "ActionOrder", {"order": 4})
        handle.done.wait(20.0) if hasattr(handle.done, "wait") else until(lambda: handle.done)


def test_a_task_that_the_robot_refuses_is_refused_in_its_words(world: World, client: ApiClient) -> None:
    assert "this mark is not known" in refused(client, ROBOT + "ExecTask", {"taskId": 1, "markNo": "Z9"})
    assert "exactly one" in refused(client, ROBOT + "ExecTask", {"taskId": 1})
    world.sim.set_mode(RobotMode.MANUAL)
    assert "automatic" in refused(client, ROBOT + "ExecTask", {"taskId": 1, "type": 1, "markNo": "A1"})


@pytest.mark.promise("a cancel through the Robot API comes while the task it means is still being sent")
def test_a_stop_does_not_wait_for_a_slow_robot_and_is_not_overtaken(world: World, client: ApiClient) -> None:
    """Zero is answered at once, and no task goes on: it is refused unsent, or cancelled when it is answered."""
    world.sim.reply_delay = 1.5
    try:
        client.send({"type": ROBOT + "ExecTask", "body": {"taskId": 8, "type": 1, "markNo": "B1"}, "sn": 1})
        began = time.monotonic()
        client.send({"type": TWIST, "sn": 2})
        client.send({"type": ROBOT + "ActionOrder", "body": {"order": 4}, "sn": 3})
        answers = {}
        for _ in range(3):
            got = client.receive()
            answers[got["sn"]] = (got["ok"], time.monotonic() - began)
        assert answers[2][0]
        assert answers[2][1] < 1.2  # before the robot answers
        assert not answers[1][0]
    finally:
        world.sim.reply_delay = 0.0
    until(lambda: client.ask(ROBOT + "TaskProc")["state"] in (0, 8))
    stands(world.sim)


# -- actions -------------------------------------------------------------------------------------------------


def test_a_step_is_reported_to_its_end(world: World, client: ApiClient) -> None:
    client.subscribe("woosh.ros.Feedbacks")
    world.sim.speed = 4.0
    step = {"steps": [{"mode": 1, "value": 0.5, "speed": 0.25}], "action": 1}
    assert client.ask(CALL, {"stepControl": step}) == {}
    told = feedback(client)
    assert [(one["action"], one["state"]) for one in told] == [(STEP, RUNNING), (STEP, DONE)]
    where = client.ask(ROBOT + "PoseSpeed")["pose"]
    assert abs(where["x"]) + abs(where["y"]) > 0.3


def test_a_cancelled_step_is_reported_and_a_second_one_waits_for_it(world: World, client: ApiClient) -> None:
    client.subscribe("woosh.ros.Feedbacks")
    client.ask(CALL, {"stepControl": SLOW})
    begins(world.sim)
    assert "under way: cancel it first" in refused(client, CALL, {"stepControl": SLOW})
    assert "neither pauses" in refused(client, CALL, {"stepControl": {**SLOW, "action": 2}})
    assert client.ask(CALL, {"stepControl": {}}) == {}  # an absent action is 0, a cancel
    assert feedback(client)[-1]["state"] == CANCELLED
    stands(world.sim)


def test_a_goal_that_fails_is_reported_with_the_robots_words(world: World, client: ApiClient) -> None:
    client.subscribe("woosh.ros.Feedbacks")
    client.ask(CALL, {"moveBase": {"targetPose": {"x": 500.0}, "action": 1}})
    end = feedback(client)[-1]
    assert (end["action"], end["state"]) == ("woosh.ros.action.MoveBase", FAILED)
    assert "status code 130101000021" in end["msg"]


def test_the_mode_of_the_navigation_is_set(world: World, client: ApiClient) -> None:
    client.subscribe("woosh.ros.Feedbacks")
    client.ask(CALL, {"navMode": {"mode": 2, "maxSpeed": 0.4}})
    assert feedback(client)[-1]["state"] == DONE
    with world.sim.lock:
        assert world.sim.world.navigation.max_speed == pytest.approx(0.4)


@pytest.mark.parametrize("member", ["chargeControl", "anyAction"])
def test_an_action_without_counterpart_is_refused(world: World, client: ApiClient, member: str) -> None:
    assert "no counterpart" in refused(client, CALL, {member: {}})
    assert "is empty" in refused(client, CALL, {})


@pytest.mark.parametrize(
    ("steps", "says"),
    [
        ([], "no steps"),
        ([{"mode": 1, "value": 11.0}], "10.0 m one step may have"),
        ([{"mode": 9, "value": 0.5}], "not known"),
        ([{"mode": 1, "value": "NaN"}], "finite"),
    ],
)
def test_a_step_beyond_the_limits_of_the_interface_is_refused(
    world: World, client: ApiClient, steps: list[dict[str, Any]], says: str
) -> None:
    assert says in refused(client, CALL, {"stepControl": {"steps": steps, "action": 1}})


# -- the rest ------------------------------------------------------------------------------------------------


def test_a_robot_is_told_where_it_is(world: World, client: ApiClient) -> None:
    pose = {"x": 1.0, "y": 0.5, "theta": 0.25}
    world.sim.teleport(1.0, 0.5, 0.25)
    client.ask(ROBOT + "SetRobotPose", {"pose": pose})
    until(lambda: abs(client.ask(ROBOT + "PoseSpeed")["pose"]["x"] - 1.0) < 0.05)
    world.sim.teleport(2.0, 0.5, 0.0)
    client.ask(ROBOT + "InitRobot", {"pose": {"x": 2.0, "y": 0.5}})
    until(lambda: abs(client.ask(ROBOT + "PoseSpeed")["pose"]["x"] - 2.0) < 0.05)
    client.ask(ROBOT + "InitRobot", {"isRecord": True})
    assert "finite" in refused(client, ROBOT + "SetRobotPose", {"pose": {"x": "NaN"}})


def test_it_speaks_and_shines(world: World, client: ApiClient) -> None:
    """Asked again: the server waits for the robot to listen, and our listener may come after it."""
    spoken: list[Any] = []
    lit: list[Any] = []
    with Node("listener", master_uri=world.sim.master_uri, rosout=False) as node:
        node.subscriber("/voice_synthesis", "std_msgs/String", callback=spoken.append)
        node.subscriber("/rgbled", "woosh_msgs/LED", callback=lit.append)
        until(lambda: client.ask(ROBOT + "Speak", {"text": "你好"}) is not None and spoken)
        until(lambda: client.ask(ROBOT + "LED", {"normal": 0xA3, "color": 0xFF}) is not None and lit)
        assert (spoken[0].data, lit[0].normal, lit[0].color) == ("你好", 0xA3, 0xFF)


def test_the_map_and_modes_in_use_may_be_asked_for_again(world: World, client: ApiClient) -> None:
    """Programs do that before they begin; another one is refused."""
    client.ask(ROBOT + "SwitchMap", {"sceneName": "simulation"})
    assert client.ask(ROBOT + "SwitchControlMode", {"mode": 1})["ctrl"] == 1
    assert client.ask(ROBOT + "SwitchWorkMode", {"mode": 2})["work"] == 2
    for kind, body in (
        ("SwitchMap", {"sceneName": "cellar"}),
        ("SwitchControlMode", {"mode": 2}),
        ("SwitchWorkMode", {"mode": 1}),
    ):
        assert "neither the map nor the mode" in refused(client, ROBOT + kind, body)


UNDONE = {
    name
    for name, request in wire.requests().items()
    if request.kind != "read"
} - {
    TWIST, CALL, *(ROBOT + n for n in (
        "ExecTask", "ExecPreTask", "ActionOrder", "SetRobotPose", "InitRobot", "Speak", "LED", "SwitchMap", "SwitchControlMode",
        "SwitchWorkMode",
    )),
}  # fmt: skip


@pytest.mark.promise("Uploads, deletes, Wi-Fi and settings are refused always")
@pytest.mark.parametrize("kind", sorted(UNDONE))
def test_uploads_settings_and_the_like_are_not_done(world: World, client: ApiClient, kind: str) -> None:
    assert "this server does not do it, and nothing was done" in refused(client, kind, {})


# -- who may -------------------------------------------------------------------------------------------------


@pytest.mark.promise(
    "a client of the Robot API asks for a motion or a change that is not opened",
    "The server of the Robot API carries out no command until a pattern",
)
@pytest.mark.parametrize("kind", ["Twist", "ExecTask", "ActionOrder", "Speak", "CallAction"])
def test_a_closed_door_names_the_option_that_opens_it(world: World, kind: str) -> None:
    body: dict[str, Any] = (
        {"linear": 0.2} if kind == "Twist" else {"stepControl": SLOW} if kind == "CallAction" else {}
    )
    with serving(world.sim) as server, ApiClient(server.url) as client:
        full = CALL if kind == "CallAction" else ROBOT + kind
        assert f"start it with --allow-write api:{kind}" in refused(client, full, body)
        assert not moving(world.sim)


def test_only_what_was_opened_is_done_and_a_stop_always(world: World) -> None:
    """A zero and a cancel are open to whoever may move the robot in any way."""
    with serving(world.sim, "api:ExecTask") as server, ApiClient(server.url) as client:
        assert "api:Twist" in refused(client, TWIST, {"linear": 0.2})
        assert "api:Speak" in refused(client, ROBOT + "Speak", {"text": "a"})
        client.ask(ROBOT + "ExecTask", {"taskId": 9, "type": 1, "markNo": "B1"})
        assert "api:ActionOrder" in refused(client, ROBOT + "ActionOrder", {"order": 3})
        client.ask(ROBOT + "ActionOrder", {"order": 4})
        assert client.ask(TWIST) == {}
        assert client.ask(CALL, {"stepControl": {"action": 0}}) == {}
    stands(world.sim)


@pytest.mark.promise("a client of the Robot API commands while somebody else has the lease")
def test_a_command_acquires_the_lease_and_a_stop_needs_none(world: World) -> None:
    lease = ChassisLease()
    with serving(world.sim, "api:*", lease=lease, share=True) as server, ApiClient(server.url) as client:
        client.ask(TWIST, {"angular": 0.3})
        assert lease.holder == "robot-api 127.0.0.1"
        lease.release("robot-api 127.0.0.1")
        lease.acquire("Ann")
        assert "Ann has the lease" in refused(client, TWIST, {"angular": 0.3})
        assert "Ann has the lease" in refused(client, ROBOT + "ExecTask", {"markNo": "A1"})
        assert client.ask(TWIST) == {}
        assert client.ask(CALL, {"stepControl": {"action": 0}}) == {}
        client.answer({"type": ROBOT + "ActionOrder", "body": {"order": 4}})
        assert lease.holder == "Ann"
    stands(world.sim)


@pytest.mark.promise("a client of the Robot API floods the server")
def test_a_stop_comes_through_beside_a_client_that_floods(world: World, client: ApiClient) -> None:
    """Velocities, tasks and cancels that nobody waits for, on another connection."""
    with ApiClient(world.server.url) as flooder:
        until(lambda: client.ask(TWIST, {"linear": 0.2}) == {} and moving(world.sim))
        for number in range(150):
            flooder.send({"type": TWIST, "body": {"linear": 0.2}, "sn": number})
            flooder.send({"type": ROBOT + "ExecTask", "body": {"markNo": "Z9"}, "sn": number})
        began = time.monotonic()
        assert client.ask(TWIST) == {}
        assert time.monotonic() - began < 2.0
        stands(world.sim)
        flooder.close_socket()  # it has read nothing


def test_a_server_that_closes_stops_the_robot(world: World) -> None:
    with serving(world.sim, "api:*", share=True) as server, ApiClient(server.url) as client:
        until(lambda: client.ask(TWIST, {"linear": 0.2}) == {} and moving(world.sim))
        server.close()
        stands(world.sim)
