"""A rosbridge server over real sockets: topics, services and actions both ways, and refusals."""

from __future__ import annotations

import hashlib
import json
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import pytest

from rosproto.codec import message_class, service_class
from rosproto.errors import ServiceError
from rosproto.gateway import Access, GatewayLimits
from rosproto.gateway.gateway_server import LONG_CALLS
from rosproto.gateway.rosbridge.png import publish_png
from rosproto.gateway.rosbridge.session import RosbridgeSession
from tests.support.doors import held
from tests.unit.gateway.conftest import Graph

String = message_class("std_msgs/String")
Twist = message_class("geometry_msgs/Twist")
SetBool = service_class("std_srvs/SetBool")
Serve = Callable[..., Any]


def until(holds: Callable[[], bool], seconds: float = 10.0) -> None:
    deadline = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < deadline, "it did not become true"
        threading.Event().wait(0.01)


def test_a_topic_is_subscribed_while_somebody_wants_it(graph: Graph, serve: Serve, connect: Serve) -> None:
    """Messages as JSON, by the name that the client gave; and nothing stays at the robot."""
    publisher = graph.robot.publisher("/chat", String)
    bridge = serve()
    first, second = connect(bridge), connect(bridge)
    first.send(op="subscribe", topic="/chat", type="std_msgs/String", id="s")
    second.send(op="subscribe", topic="chat")
    publisher.wait_for_connection(10)
    until(lambda: sum(len(c.subscriptions) for c in bridge.clients) == 2)
    publisher.publish(data="hello")
    assert first.get() == {"op": "publish", "topic": "/chat", "msg": {"data": "hello"}}
    assert second.get() == {"op": "publish", "topic": "chat", "msg": {"data": "hello"}}
    assert publisher.connections == 1
    first.send(op="unsubscribe", topic="/chat")
    second.close()
    until(lambda: publisher.connections == 0)
    assert bridge.stats().topics == ()


def test_latched_messages_come_to_who_subscribes_later(graph: Graph, serve: Serve, connect: Serve) -> None:
    """Also to the second client, for whom nothing is connected anew."""
    publisher = graph.robot.publisher("/map", String, latch=True)
    publisher.publish(data="map")
    bridge = serve()
    for _ in range(2):
        client = connect(bridge)
        client.send(op="subscribe", topic="/map", type="std_msgs/String")
        assert client.op("publish")["msg"] == {"data": "map"}


def test_compressions(graph: Graph, serve: Serve, connect: Serve) -> None:
    """png, cbor, cbor-raw and fragments: the same message."""
    cbor2 = pytest.importorskip("cbor2", reason='cbor2 is not installed: pip install ".[bridge]"')
    publisher = graph.robot.publisher("/chat", String, latch=True)
    publisher.publish(data="hello")
    bridge = serve()
    client = connect(bridge)
    client.send(op="subscribe", topic="/chat", compression="cbor")
    assert cbor2.loads(client.raw()) == {"op": "publish", "topic": "/chat", "msg": {"data": "hello"}}
    client = connect(bridge)
    client.send(op="subscribe", topic="/chat", compression="cbor-raw")
    assert cbor2.loads(client.raw())["msg"]["bytes"] == b"\x05\0\0\0hello"
    client = connect(bridge)
    client.send(op="subscribe", topic="/chat", compression="png")
    assert client.get()["op"] == "png"
    client = connect(bridge)
    client.send(op="subscribe", topic="/chat", fragment_size=20)
    pieces = [client.get() for _ in range(3)]
    assert "".join(p["data"] for p in pieces) == '{"op":"publish","topic":"/chat","msg":{"data":"hello"}}'


@pytest.mark.promise("A gateway is read only until a pattern allows")
def test_a_client_publishes_what_a_pattern_opens(graph: Graph, serve: Serve, connect: Serve) -> None:
    """And nothing else; the refusal names the option."""
    got = graph.robot.subscriber("/chat", String)
    client = connect(serve(write=["topic:/chat"]))
    client.send(op="advertise", topic="/chat", type="std_msgs/String", id="a")
    client.send(op="publish", topic="/chat", msg={"data": "hello"})
    assert got.next(10).data == "hello"
    client.send(op="advertise", topic="/cmd_vel", type="geometry_msgs/Twist", id="b")
    refused = client.op("status")
    assert (refused["level"], refused["id"]) == ("error", "b")
    assert "--allow-write topic:/cmd_vel" in refused["msg"]
    client.send(op="publish", topic="/cmd_vel", msg={"linear": {"x": 1.0}}, id="c")
    assert client.op("status")["id"] == "c"
    assert "/cmd_vel" not in graph.node.master.get_system_state().publishers
    client.send(op="publish", topic="/chat", msg={"data": 7}, id="d")
    assert "data" in client.op("status")["msg"]


def test_a_message_published_right_after_advertising_arrives(
    graph: Graph, serve: Serve, connect: Serve
) -> None:
    """A page that advertises, publishes once and is done: subscribers need a moment to connect."""
    got = graph.robot.subscriber("/chat", String)
    bridge = serve(write=["*"])
    for i in range(3):
        client = connect(bridge)
        client.send(op="advertise", topic="/chat", type="std_msgs/String")
        client.send(op="publish", topic="/chat", msg={"data": f"{i}"})
        assert got.next(10).data == f"{i}"
        client.send(op="unadvertise", topic="/chat")
        client.close()
        if i < 2:  # the next one's publisher is a new one
            until(lambda: got.connections == 0)


@pytest.mark.promise("leaves or is silent for half a second, the gateway sends zero")
def test_zero_follows_when_a_driving_client_goes(graph: Graph, serve: Serve, connect: Serve) -> None:
    """At once when it leaves, after half a second when it is silent."""
    velocities: list[tuple[float, Any]] = []
    got = graph.robot.subscriber("/cmd_vel", Twist, lambda m: velocities.append((time.monotonic(), m)))
    bridge = serve(write=["topic:/cmd_vel"])
    client = connect(bridge)
    client.send(op="advertise", topic="/cmd_vel", type="geometry_msgs/Twist")
    got.wait_for_connection(10)
    client.send(op="publish", topic="/cmd_vel", msg={"linear": {"x": 0.5}})
    until(lambda: len(velocities) >= 6)
    assert [m.linear.x for _, m in velocities[:6]] == [0.5, 0, 0, 0, 0, 0]
    assert 0.3 < velocities[1][0] - velocities[0][0] < 3.0
    velocities.clear()
    client.send(op="publish", topic="/cmd_vel", msg={"linear": {"x": 0.5}})
    until(lambda: len(velocities) >= 1)
    client.abort()
    gone = time.monotonic()
    until(lambda: len(velocities) >= 6)
    assert velocities[1][0] - gone < 0.4
    until(lambda: bridge.stats().zeros == 10)


@pytest.mark.promise("does not publish a velocity with a number that is not finite")
@pytest.mark.parametrize("number", ["NaN", "Infinity", "-Infinity", "1e999", "1e308"])
def test_a_velocity_that_is_none_reaches_no_robot(
    graph: Graph, serve: Serve, connect: Serve, number: str
) -> None:
    """As text, in UTF-8, in fragments and as a picture: refused with a sentence; the next one is published."""
    heard = graph.robot.subscriber("/cmd_vel", Twist, queue_size=100)
    client = connect(serve(write=["topic:/cmd_vel"]))
    client.send(op="advertise", topic="/cmd_vel", type="geometry_msgs/Twist")
    heard.wait_for_connection(10)
    text = f'{{"op": "publish", "topic": "/cmd_vel", "msg": {{"angular": {{"z": {number}}}}}}}'
    client.send_raw(text)
    assert "a velocity for /cmd_vel is not published" in client.op("status")["msg"]
    client.send_raw(text.encode())
    assert "a velocity for /cmd_vel is not published" in client.op("status")["msg"]
    for num in (0, 1):
        client.send(op="fragment", id="f", num=num, total=2, data=text[40 * num : 40 + 999 * num])
    assert "a velocity for /cmd_vel is not published" in client.op("status")["msg"]
    client.send_raw(publish_png(text))
    assert "a velocity for /cmd_vel is not published" in client.op("status")["msg"]
    client.send(op="publish", topic="/cmd_vel", msg={"angular": {"z": 0.25}})
    assert heard.next(10).angular.z == 0.25


@pytest.mark.promise(
    "does not publish a velocity with a number that is not finite",
    "leaves or is silent for half a second, the gateway sends zero",
)
@pytest.mark.parametrize("encoded", [str, str.encode, publish_png])
def test_a_velocity_by_another_name_is_one(
    graph: Graph, serve: Serve, connect: Serve, encoded: Callable[[str], str | bytes]
) -> None:
    """Advertised before the robot's topic is in the graph, it is guarded, and zero follows when its client has gone."""
    client = connect(serve(write=["topic:/base_cmd_vel"]))

    def send(**message: Any) -> None:
        client.send_raw(encoded(json.dumps(message)))

    send(op="advertise", topic="/base_cmd_vel", type="geometry_msgs/Accel")
    until(lambda: "/base_cmd_vel" in graph.node.master.get_system_state().publishers)
    heard = graph.robot.subscriber("/base_cmd_vel", Twist, queue_size=100)
    heard.wait_for_connection(10)
    for number in (float("nan"), 1001.0):
        send(op="publish", topic="/base_cmd_vel", msg={"linear": {"x": number}})
        assert "a velocity for /base_cmd_vel is not published" in client.op("status")["msg"]
    send(op="publish", topic="/base_cmd_vel", msg={"linear": {"x": 0.25}})
    assert heard.next(10).linear.x == 0.25
    client.abort()
    assert [heard.next(10).linear.x for _ in range(5)] == [0.0] * 5


@pytest.mark.promise("A gateway is read only until a pattern allows")
def test_services(graph: Graph, serve: Serve, connect: Serve) -> None:
    """Called where a pattern opens it; what fails is answered, too."""

    def handler(request: Any) -> Any:
        if not request.data:
            raise ServiceError("/lamp", "it is broken")
        return True, "on"

    graph.robot.service_server("/lamp", SetBool, handler)
    graph.robot.service_server("/motor", SetBool, handler)
    client = connect(serve(write=["service:/lamp"]))
    answer = client.call("/lamp", {"data": True})
    assert (answer["result"], answer["values"]) == (True, {"success": True, "message": "on"})
    assert client.call("/lamp", [True])["result"] is True
    answer = client.call("/lamp", {"data": False})
    assert not answer["result"]
    assert "it is broken" in answer["values"]
    answer = client.call("/motor", {"data": True})
    assert not answer["result"]
    assert "--allow-write service:/motor" in answer["values"]
    assert not client.call("/nobody")["result"]
    assert "data" in client.call("/lamp", {"data": "x"})["values"]
    assert "/chatter" not in client.call("/rosapi/topics")["values"]["topics"]
    assert client.call("/robot/get_loggers")["result"] is True  # it only answers


def test_a_client_provides_a_service(graph: Graph, serve: Serve, connect: Serve) -> None:
    """Calls of ROS programs go to it; and fail when it goes."""
    bridge = serve(write=["service:/lamp"])
    client = connect(bridge)
    client.send(op="advertise_service", service="/lamp", type="std_srvs/SetBool")
    graph.robot.wait_for_service("/lamp")
    answers: list[Any] = []

    def call() -> None:
        try:
            answers.append(graph.robot.service_client("/lamp", SetBool).call(data=True, timeout=20))
        except Exception as error:
            answers.append(error)

    for values, result in [
        ({"success": True, "message": "on"}, True),
        ("broken", False),
        ({"success": 7}, True),
    ]:
        thread = threading.Thread(target=call)
        thread.start()
        asked = client.op("call_service")
        assert (asked["service"], asked["args"]) == ("/lamp", {"data": True})
        client.send(op="service_response", service="/lamp", id=asked["id"], values=values, result=result)
        thread.join(20)
    assert (answers[0].success, answers[0].message) == (True, "on")
    assert "broken" in str(answers[1])
    assert "does not fit" in str(answers[2])
    assert client.op("status")["msg"].startswith("service_response: /lamp: ")
    thread = threading.Thread(target=call)
    thread.start()
    asked = client.op("call_service")
    client.send(op="service_response", service="/lamp", id=asked["id"], values={}, result="yes")
    assert client.op("status")["id"] == asked["id"]
    thread.join(5)
    assert "field result is 'yes'" in str(answers[3]), "the caller is told at once"
    thread = threading.Thread(target=call)
    thread.start()
    client.op("call_service")
    client.close()
    thread.join(20)
    assert isinstance(answers[4], ServiceError)
    until(lambda: "/lamp" not in graph.node.master.get_system_state().services)


@pytest.mark.promise("A gateway is read only until a pattern allows")
def test_goals(graph: Graph, serve: Serve, connect: Serve) -> None:
    """Goals are sent, give feedback, end, are cancelled and refused."""
    from rosproto import ActionServer

    heard, begun = threading.Event(), threading.Event()

    def execute(goal: Any) -> None:
        begun.set()
        if goal.goal.goal < 5:
            for i in range(goal.goal.goal):
                goal.publish_feedback({"feedback": i})
            heard.wait(10)  # a result overtakes feedback, which is then of no use
            goal.succeed({"result": goal.goal.goal})
            return
        deadline = time.monotonic() + 20
        while not goal.cancel_requested and time.monotonic() < deadline:
            threading.Event().wait(0.01)
        goal.preempted()

    with ActionServer(graph.robot, "/test", "actionlib/TestAction", execute):
        client = connect(serve(write=["action:/test"]))
        goal = {"op": "send_action_goal", "action": "/test", "action_type": "actionlib/TestAction"}
        client.send(**goal, id="one", args={"goal": 2}, feedback=True)
        assert [client.op("action_feedback")["values"] for _ in range(2)] == [
            {"feedback": 0},
            {"feedback": 1},
        ]
        heard.set()
        done = client.op("action_result")
        assert (done["id"], done["values"], done["status"], done["result"]) == ("one", {"result": 2}, 4, True)
        client.send(**goal, id="two", args={"goal": 9})
        client.send(op="cancel_action_goal", action="/test", id="two")
        done = client.op("action_result")
        assert (done["id"], done["status"]) == ("two", 5) or "cancelled" in done["values"]
        client.send(**goal, id="three", args={"goal": "x"})
        assert client.op("action_result")["result"] is False
        client.send(**{**goal, "action": "/move_base"}, id="four", args={})
        assert "--allow-write action:/move_base" in client.op("action_result")["values"]
        client.send(op="cancel_action_goal", action="/test", id="nine")
        assert client.op("status")["id"] == "nine"
        begun.clear()
        client.send(**goal, id="ten", args={"goal": 9})
        assert begun.wait(10)
        client.send(op="call_service", service="/test/_action/cancel_goal", args={}, id="all")  # by roslib
        answers = {m["op"]: m for m in (client.get(), client.get())}
        assert answers["service_response"]["result"] is True
        assert (answers["action_result"]["id"], answers["action_result"]["status"]) == ("ten", 5)
        assert "--allow-write" in client.call("/other/_action/cancel_goal", {})["values"]


def test_a_client_provides_an_action(graph: Graph, serve: Serve, connect: Serve) -> None:
    """Several goals at once: done, given up, failed, with a result that does not fit; and when it leaves."""
    from rosproto import ActionClient
    from rosproto.action import GoalStatus

    bridge = serve(write=["action:/page"])
    page, other = connect(bridge), connect(bridge)
    page.send(op="advertise_action", action="/stairs", type="actionlib/Test", id="a")
    assert "--allow-write action:/stairs" in page.op("status")["msg"]
    page.send(op="advertise_action", action="/page", type="actionlib/action/Test")
    with ActionClient(graph.robot, "/page", "actionlib/Test") as robot:
        robot.wait_for_server(10)
        other.send(op="advertise_action", action="/page", type="actionlib/Test")
        assert "another client" in other.op("status")["msg"]
        heard: list[int] = []
        sent = [
            robot.send_goal({"goal": i}, feedback=lambda _, f: heard.append(f.feedback)) for i in range(5)
        ]
        goals = sorted((page.op("send_action_goal") for _ in sent), key=lambda g: g["args"]["goal"])
        assert [goal["args"] for goal in goals] == [{"goal": i} for i in range(5)]
        assert {(g["action"], g["action_type"]) for g in goals} == {("/page", "actionlib/action/Test")}
        ids = [goal["id"] for goal in goals]
        page.send(op="action_feedback", action="/page", id=ids[0], values={"feedback": 7})
        until(lambda: heard == [7])
        end = {"op": "action_result", "action": "/page", "result": True}
        page.send(**end, id=ids[0], status=4, values={"result": 1})
        page.send(**end, id=ids[1], status=6, values={"result": 2})
        page.send(op="action_result", action="/page", result=False, id=ids[2], status=6)
        page.send(**end, id=ids[3], status=4, values={"result": "x"})
        assert "result" in page.op("status")["msg"]
        assert (sent[0].wait(10).result, sent[1].wait(10).result) == (1, 2)
        assert [handle.wait(10) and handle.status for handle in sent[:4]] == [
            GoalStatus.SUCCEEDED,
            *[GoalStatus.ABORTED] * 3,
        ]
        sent[4].cancel()
        cancel = page.op("cancel_action_goal")
        assert (cancel["id"], cancel["action"]) == (ids[4], "/page")
        page.send(**end, id=ids[4], status=5, values={"result": 3})
        assert (sent[4].wait(10).result, sent[4].status) == (3, GoalStatus.PREEMPTED)
        page.send(op="action_feedback", action="/page", id=ids[4], values={"feedback": 8})
        assert ids[4] in page.op("status")["msg"]
        odd = robot.send_goal({"goal": 8})
        page.send(**end, id=page.op("send_action_goal")["id"], status="done", values={"result": 4})
        assert "field status" in page.op("status")["msg"]
        odd.wait(10)
        assert (odd.status, "field status is 'done'" in odd.text) == (GoalStatus.ABORTED, True)
        last = robot.send_goal({"goal": 9})
        page.op("send_action_goal")
        page.close()
        last.wait(10)
        assert (last.status, last.text) == (GoalStatus.ABORTED, "the client that provides it has gone")
    until(lambda: "/page/status" not in graph.node.master.get_system_state().publishers)
    other.send(op="advertise_action", action="/page", type="actionlib/Test")
    until(lambda: "/page/status" in graph.node.master.get_system_state().publishers)
    other.send(op="unadvertise_action", action="/page")
    until(lambda: "/page/status" not in graph.node.master.get_system_state().publishers)


def test_credentials_of_rosauth_are_refused(serve: Serve, connect: Serve) -> None:
    """The refusal says how a client authenticates here."""
    client = connect(serve())
    client.send(op="auth", mac="x", client="c", dest="d", rand="r", t=1, level="admin", end=2, id="a")
    refused = client.op("status")
    assert (refused["id"], "?token=" in refused["msg"]) == ("a", True)


@pytest.mark.promise("are neither read, nor written, nor listed")
def test_what_is_denied_is_neither_read_nor_listed(graph: Graph, serve: Serve, connect: Serve) -> None:
    """By whatever spelling."""
    graph.robot.publisher("/secret", String)
    client = connect(serve(access=Access(deny=["/secret"], write=["*"])))
    for topic in ("/secret", "secret"):
        client.send(op="subscribe", topic=topic, id=topic)
        assert client.op("status")["id"] == topic
        client.send(op="advertise", topic=topic, type="std_msgs/String", id=topic)
        assert client.op("status")["id"] == topic
    assert "/secret" not in client.call("/rosapi/topics")["values"]["topics"]


def test_another_type_than_the_topics(graph: Graph, serve: Serve, connect: Serve) -> None:
    """It is reported, and not decoded as the other type."""
    graph.robot.publisher("/chat", String)
    client = connect(serve(write=["*"]))
    client.send(op="subscribe", topic="/chat", type="geometry_msgs/Twist", id="s")
    assert "std_msgs/String" in client.op("status")["msg"]
    client.send(op="advertise", topic="/chat", type="geometry_msgs/Twist", id="a")
    assert "std_msgs/String" in client.op("status")["msg"]
    client.send(op="advertise", topic="/new", type="no_such/Type", id="n")
    assert client.op("status")["id"] == "n"
    client.send(op="publish", topic="/unknown", msg={}, id="p")
    assert "advertise it first" in client.op("status")["msg"]


@pytest.mark.promise("gets no message of another one: a status, and the subscription is ended")
@pytest.mark.parametrize("compression", ["none", "png", "cbor", "cbor-raw"])
def test_a_topic_that_appears_later_with_another_type(
    graph: Graph, serve: Serve, connect: Serve, compression: str
) -> None:
    """The subscription is ended with a status, and no value arrives; then the client may subscribe anew."""
    bridge = serve()
    client = connect(bridge)
    client.send(op="subscribe", topic="/later", type="geometry_msgs/Twist", id="s", compression=compression)
    until(lambda: bridge.stats().topics == ("/later",))
    publisher = graph.robot.publisher("/later", String)
    publisher.wait_for_connection(10)
    publisher.publish(data="1234567890" * 10)
    told = client.get()
    assert (told["op"], told["level"]) == ("status", "error")
    assert "/later is of type std_msgs/String, not geometry_msgs/Twist" in told["msg"]
    until(lambda: publisher.connections == 0)
    client.send(op="subscribe", topic="/later", type="std_msgs/String", id="t")
    publisher.wait_for_connection(10)
    publisher.publish(data="right")
    assert client.get() == {"op": "publish", "topic": "/later", "msg": {"data": "right"}}


def test_another_client_keeps_its_subscription(graph: Graph, serve: Serve, connect: Serve) -> None:
    """It ends the subscription with that type, and not the one of another client."""
    bridge = serve()
    other = connect(bridge)
    other.send(op="subscribe", topic="/later")
    first = connect(bridge)
    first.send(op="subscribe", topic="/later", type="geometry_msgs/Twist")
    until(lambda: sum(len(c.subscriptions) for c in bridge.clients) == 2)
    publisher = graph.robot.publisher("/later", String, latch=True)
    publisher.publish(data="kept")
    assert other.op("publish")["msg"] == {"data": "kept"}
    assert "/later is of type std_msgs/String" in first.op("status")["msg"]
    until(lambda: sum(len(c.subscriptions) for c in bridge.clients) == 1)


def test_a_second_type_of_one_subscription(graph: Graph, serve: Serve, connect: Serve) -> None:
    """Two subscriptions of a topic by one client have one type, known to the graph or not."""
    client = connect(serve())
    client.send(op="subscribe", topic="/none", type="geometry_msgs/Twist", id="a")
    client.send(op="subscribe", topic="/none", type="std_msgs/String", id="b")
    told = client.op("status")
    assert (told["id"], "geometry_msgs/Twist" in told["msg"]) == ("b", True)


def test_a_client_has_limits(graph: Graph, serve: Serve, connect: Serve) -> None:
    """In topics, services and calls; beyond them a sentence."""
    limits = GatewayLimits(
        subscriptions_per_client=2, advertised_per_client=1, calls_per_client=1, linger_seconds=0.05
    )
    client = connect(serve(write=["*"], limits=limits))
    for i in range(3):
        client.send(op="subscribe", topic=f"/t{i}", id=f"s{i}")
    assert client.op("status")["id"] == "s2"
    for i in range(2):
        client.send(op="subscribe", topic="/t0", id=f"again{i}")
    assert client.op("status")["id"] == "again1"
    for i in range(2):
        client.send(op="advertise", topic=f"/a{i}", type="std_msgs/String", id=f"a{i}")
    assert client.op("status")["id"] == "a1"
    for i in range(2):
        client.send(op="advertise_service", service=f"/s{i}", type="std_srvs/SetBool", id=f"p{i}")
    assert client.op("status")["id"] == "p1"
    client.send(op="call_service", service="/s0", args={"data": True}, id="c0")
    client.op("call_service")
    assert "limit" in client.call("/s0", id="c1")["values"]


def test_a_call_ends_in_time(graph: Graph, serve: Serve, connect: Serve) -> None:
    """By the client's time, by the gateway's where that is less; also when the client itself does not answer."""
    bridge = serve(write=["*"], limits=GatewayLimits(call_seconds=0.4, linger_seconds=0.05))
    over = threading.Event()
    graph.robot.service_server("/slow", SetBool, lambda _: over.wait(20) and None)
    client = connect(bridge)
    began = time.monotonic()
    for timeout in (0.2, 60, None):
        client.send(op="call_service", service="/slow", args={"data": True}, timeout=timeout, id=f"{timeout}")
        assert client.op("service_response")["result"] is False
    assert time.monotonic() - began < 10
    over.set()
    client.send(op="advertise_service", service="/mine", type="std_srvs/SetBool")
    graph.robot.wait_for_service("/mine")
    with pytest.raises(ServiceError, match="has not answered"):
        graph.robot.service_client("/mine", SetBool).call(data=True, timeout=20)


@pytest.mark.promise("of all clients' long messages one is decoded at a time")
def test_long_calls_are_limited(graph: Graph, serve: Serve, connect: Serve) -> None:
    """Of all clients together: each takes memory until it is answered. Short ones go on."""
    over = threading.Event()
    entered = threading.Semaphore(0)

    def slow(_: Any) -> dict[str, Any]:
        entered.release()
        over.wait(20)
        return {}

    graph.robot.service_server("/slow", "roscpp/SetLoggerLevel", slow)
    bridge = serve(write=["*"])
    clients = [connect(bridge), connect(bridge)]
    for i in range(LONG_CALLS):
        args = {"logger": "x" * 20_000}
        clients[i % 2].send(op="call_service", service="/slow", args=args, id=f"{i}")
    for _ in range(LONG_CALLS):
        assert entered.acquire(timeout=20)
    clients[0].send(op="call_service", service="/slow", args={"logger": "x" * 20_000}, id="one more")
    refused = clients[0].op("service_response")
    assert (refused["id"], refused["result"]) == ("one more", False)
    assert "with long arguments" in refused["values"]
    clients[0].send(op="call_service", service="/slow", args={"logger": "x"}, id="a short one")
    assert entered.acquire(timeout=20)
    over.set()
    answered = {clients[0].op("service_response")["id"] for _ in range(LONG_CALLS // 2 + 1)}
    assert "a short one" in answered
    long = clients[0].call("/slow", {"logger": "x" * 20_000}, id="again")
    assert long["result"] is True


def test_goals_are_limited(graph: Graph, serve: Serve, connect: Serve) -> None:
    """Of one client at a time."""
    client = connect(serve(write=["*"], limits=GatewayLimits(goals_per_client=1, linger_seconds=0.05)))
    goal = {"op": "send_action_goal", "action": "/nobody", "action_type": "actionlib/TestAction"}
    client.send(**goal, id="one")
    client.send(**goal, id="two")
    refused = client.op("action_result")
    assert (refused["id"], refused["result"]) == ("two", False)
    assert "limit" in refused["values"]


def test_throttle_and_queue(graph: Graph, serve: Serve, connect: Serve) -> None:
    """At most one message in an interval; a queue keeps the newest for later."""
    publisher = graph.robot.publisher("/chat", String, queue_size=100)
    bridge = serve()
    plain, queued = connect(bridge), connect(bridge)
    plain.send(op="subscribe", topic="/chat", throttle_rate=60_000)
    queued.send(op="subscribe", topic="/chat", throttle_rate=100, queue_length=2)
    publisher.wait_for_connection(10)
    until(lambda: sum(len(c.subscriptions) for c in bridge.clients) == 2)
    for i in range(10):
        publisher.publish(data=f"{i}")
    assert [queued.get()["msg"]["data"] for _ in range(3)] == ["0", "8", "9"]
    assert plain.get()["msg"]["data"] == "0"
    with pytest.raises(TimeoutError):
        plain.get(0.2)


def test_the_server_says_where_it_is_and_ends(graph: Graph, serve: Serve, connect: Serve) -> None:
    """Clients are notified; closing twice, or by closing the node, works."""
    bridge = serve()
    client = connect(bridge)
    assert bridge.url == f"ws://127.0.0.1:{bridge.port}"
    until(lambda: len(bridge.clients) == 1)
    bridge.close()
    bridge.close()
    assert bridge.closed
    with pytest.raises(Exception, match="1001"):
        client.get()
    another = serve()
    graph.node.close()
    assert another.closed
    until(lambda: not [t for t in threading.enumerate() if t.name == "rosproto:rosbridge"])


# -- credentials of rosauth ----------------------------------------------------------------------------------


def rosauth(graph: Graph, secret: str = "secret") -> list[Any]:
    """The service that rosauth provides, on the robot's node; returns the requests it has had."""
    asked: list[Any] = []

    def authenticate(request: Any) -> dict[str, bool]:
        asked.append(request)
        words = (request.client, request.dest, request.rand, request.t.secs, request.level, request.end.secs)
        expected = hashlib.sha512((secret + "".join(map(str, words))).encode()).hexdigest()
        return {"authenticated": request.mac == expected}

    graph.robot.service_server("/authenticate", "rosauth/Authentication", authenticate)
    return asked


def credentials(secret: str = "secret") -> dict[str, Any]:
    given = {
        "client": "10.0.0.9",
        "dest": "10.0.0.7",
        "rand": "xyz",
        "t": 1000,
        "level": "admin",
        "end": 2000,
    }
    return {**given, "mac": hashlib.sha512((secret + "".join(map(str, given.values()))).encode()).hexdigest()}


@pytest.mark.promise("With `--authenticate` a rosbridge client is served only after the service")
def test_a_client_is_served_after_its_credentials_are_accepted(
    graph: Graph, serve: Serve, connect: Serve
) -> None:
    """The service gets them as they were sent; the client gets no answer to them, as from the original."""
    asked = rosauth(graph)
    client = connect(serve(authenticate=True))
    client.send(op="auth", **credentials())
    assert client.call("/rosapi/topics")["result"]
    (request,) = asked
    assert (request.client, request.dest, request.level) == ("10.0.0.9", "10.0.0.7", "admin")
    assert (request.t.to_sec(), request.end.to_sec()) == (1000.0, 2000.0)
    client.send(op="auth", **credentials("other"), id="again")
    assert "already" in client.op("status")["msg"]
    assert len(asked) == 1


@pytest.mark.promise("With `--authenticate` a rosbridge client is served only after the service")
@pytest.mark.parametrize(
    ("first", "why"),
    [
        ({"op": "auth", **credentials("another secret")}, "not accepted"),
        ({"op": "auth", **credentials(), "t": -1}, "seconds"),
        ({"op": "auth", "client": "no mac"}, "before anything else"),
        ({"op": "subscribe", "topic": "/chat", "type": "std_msgs/String"}, "before anything else"),
        ({"op": "publish", "topic": "/chat", "msg": {"data": "x"}}, "before anything else"),
        ({"op": "set_level", "level": "none"}, "before anything else"),
        ({"no": "op"}, "before anything else"),
    ],
)
def test_anything_else_ends_the_connection(
    graph: Graph, serve: Serve, connect: Serve, first: dict[str, Any], why: str
) -> None:
    """And nothing of it, or of what follows, is carried out."""
    exceptions = pytest.importorskip(
        "websockets.exceptions", reason='websockets is not installed: pip install ".[bridge]"'
    )
    rosauth(graph)
    bridge = serve(write=["*"], authenticate=True)
    client = connect(bridge)
    client.send(**first)
    with suppress(exceptions.ConnectionClosed):
        client.send(op="advertise", topic="/chat", type="std_msgs/String")
    code, reason = client.closed()
    assert (code, why in reason) == (1008, True)
    until(lambda: not bridge.clients)
    assert "/chat" not in graph.robot.master.get_topic_types()


@pytest.mark.promise("With `--authenticate` a rosbridge client is served only after the service")
def test_without_the_service_nobody_is_served(graph: Graph, serve: Serve, connect: Serve) -> None:
    """The original passes such a message on, and leaves the connection open."""
    client = connect(serve(authenticate=True))
    client.send(op="auth", **credentials())
    code, reason = client.closed()
    assert (code, "/authenticate" in reason) == (1008, True)


@pytest.mark.promise("With `--authenticate` a rosbridge client is served only after the service")
def test_credentials_have_to_come_in_time(graph: Graph, serve: Serve, connect: Serve) -> None:
    """A client that says nothing does not take the place of another."""
    client = connect(serve(authenticate=True, limits=GatewayLimits(handshake_seconds=0.3)))
    code, reason = client.closed()
    assert (code, "in time" in reason) == (1008, True)


def test_a_velocity_that_waits_is_not_published_after_another_client_s_zero(
    graph: Graph, serve: Serve, connect: Serve, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first velocity of a topic waits while the topic is opened; the next one is published."""
    velocities: list[float] = []
    got = graph.robot.subscriber("/cmd_vel", Twist, lambda message: velocities.append(message.linear.x))
    bridge = serve(write=["topic:/cmd_vel"])
    driver, other = connect(bridge), connect(bridge)
    other.send(op="advertise", topic="/cmd_vel", type="geometry_msgs/Twist")
    got.wait_for_connection(10)
    with held(monkeypatch, RosbridgeSession, "_open") as (came, go_on):
        driver.send(op="publish", topic="/cmd_vel", msg={"linear": {"x": 0.5}})
        assert came.wait(10)
        other.send(op="publish", topic="/cmd_vel", msg={"linear": {"x": 0.0}})
        until(lambda: len(velocities) == 1)
        go_on.set()
        assert "a zero was received while it waited" in driver.op("status")["msg"]
    assert velocities == [0.0]
    driver.send(op="publish", topic="/cmd_vel", msg={"linear": {"x": 0.25}})
    until(lambda: len(velocities) >= 2)
    assert velocities[:2] == [0.0, 0.25]
