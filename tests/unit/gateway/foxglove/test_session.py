"""One viewer's session: what it asks for in the wrong way, too often, or while the robot does not answer."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from msgdefs.geometry_msgs.msg import Twist, Vector3
from msgdefs.std_msgs.msg import Int32, String
from msgdefs.std_srvs.srv import SetBool
from rosproto.codec import encode
from rosproto.errors import RosTimeout
from rosproto.gateway import Access, GatewayLimits
from rosproto.gateway.foxglove import LocalTopic
from tests.support.foxglove_ground import Ground, until
from tests.support.viewer import Viewer

pytest.importorskip("websockets", reason="websockets is not installed")

DRIVE = Twist(linear=Vector3(x=0.2))


class Slow:
    """A topic that is subscribed as slowly as one of a master that does not answer."""

    def __init__(self) -> None:
        self.asked = threading.Event()
        self.answer = threading.Event()
        self.topic = LocalTopic("/slow", String, self._wanted)

    def _wanted(self, wanted: bool) -> None:
        if wanted:
            self.asked.set()
            assert self.answer.wait(30), "nobody has let it go on"

    def ask(self, viewer: Viewer) -> None:
        viewer.subscribe("/slow")
        assert self.asked.wait(10)


@pytest.fixture
def slow() -> Iterator[Slow]:
    made = Slow()
    yield made
    made.answer.set()


def test_numbers_that_mean_nothing(ground: Ground) -> None:
    """Are answered, and those that mean something are carried out."""
    publisher = ground.robot.publisher("/a", String, latch=True)
    publisher.publish(data="x")
    server = ground.serve()
    viewer = ground.view(server)
    number = viewer.offered("/a")["id"]
    viewer.send("subscribe", subscriptions=[{"id": 1, "channelId": 999}])
    assert "channel 999" in viewer.status("is not advertised")
    viewer.send("unsubscribe", subscriptionIds=[77])
    viewer.send("unadvertise", channelIds=[5])
    viewer.subscribe("/a")
    viewer.message("/a")
    viewer.send("subscribe", subscriptions=[{"id": 50, "channelId": number}])
    viewer.status("/a", "already subscribed to")
    viewer.send("subscribe", subscriptions=[{"id": 1, "channelId": number}])
    viewer.socket.send(b"\x02" + (99).to_bytes(4, "little") + bytes(4) + (4).to_bytes(4, "little") + b"ros1")
    assert viewer.document("serviceCallFailure", serviceId=99)["callId"] == 0
    viewer.send("fetchAsset", uri="package://a/b", requestId=1)
    assert viewer.wait(lambda one: isinstance(one, tuple) and one[0] == "asset")[1:3] == (1, 1)
    assert server.clients[0].subscriptions == ("/a",)


def test_a_number_is_in_use_until_it_is_given_back(ground: Ground) -> None:
    """A subscription's, and a channel's."""
    for topic in ("/a", "/b"):
        ground.robot.publisher(topic, String, latch=True).publish(data=topic)
    heard = ground.robot.subscriber("/say", String)
    viewer = ground.view(ground.serve(access=Access(write=["*"])))
    numbers = [viewer.offered(topic)["id"] for topic in ("/a", "/b")]
    viewer.send("subscribe", subscriptions=[{"id": 9, "channelId": numbers[0]}])
    viewer.send("subscribe", subscriptions=[{"id": 9, "channelId": numbers[1]}])
    viewer.status("/b", "subscription 9 is in use")
    viewer.send("unsubscribe", subscriptionIds=[9])
    viewer.send("subscribe", subscriptions=[{"id": 9, "channelId": numbers[1]}])
    data = encode(String(data="/b"))
    viewer.wait(lambda one: isinstance(one, tuple) and one[0] == "message" and one[2] == data)
    channel = {"id": 3, "topic": "/say", "encoding": "ros1", "schemaName": "std_msgs/String"}
    viewer.send("advertise", channels=[channel, channel])
    viewer.status("channel 3 is already advertised")
    heard.wait_for_connection(5)
    viewer.send("unadvertise", channelIds=[3])
    viewer.send("advertise", channels=[channel])
    viewer.publish(3, encode(String(data="again")))
    assert heard.next(5).data == "again"


def test_a_thousand_wrong_messages(ground: Ground) -> None:
    """They are reported, the same text only once in a while; the viewer is still served."""
    ground.robot.params["/a"] = 1
    viewer = ground.view(ground.serve())
    for number in range(1000):
        viewer.socket.send(("nonsense", b"\x09", '{"op": "x"}', b"")[number % 4])
    viewer.send("getParameters", parameterNames=["/a"], id="last")
    assert viewer.document("parameterValues", id="last")["parameters"] == [{"name": "/a", "value": 1}]
    told = [one["message"] for one in viewer.came if isinstance(one, dict) and one["op"] == "status"]
    assert len(told) == len(set(told)) == 4


@pytest.mark.promise("on an advertised topic does not wait for a master")
def test_a_velocity_does_not_wait_for_the_master(ground: Ground, slow: Slow) -> None:
    """It comes at once on a topic that is open, while something else of the same viewer waits for the robot."""
    heard = ground.robot.subscriber("/cmd_vel", Twist, queue_size=100)
    viewer = ground.view(ground.serve(access=Access(write=["/cmd_vel"]), topics=[slow.topic]))
    channel = viewer.advertise("/cmd_vel", "geometry_msgs/Twist")
    heard.wait_for_connection(5)
    slow.ask(viewer)
    viewer.publish(channel, encode(DRIVE))
    assert heard.next(5) == DRIVE


@pytest.mark.promise("eight requests of the viewer are read ahead")
def test_a_slow_master_holds_up_requests(ground: Ground, slow: Slow) -> None:
    """In their order; behind eight of them nothing is read, so that what waits is bounded."""
    heard = ground.robot.subscriber("/say", String)
    viewer = ground.view(ground.serve(access=Access(write=["/say"]), topics=[slow.topic]))
    channel = viewer.advertise("/say", "std_msgs/String")
    heard.wait_for_connection(5)
    slow.ask(viewer)
    for number in range(8):
        viewer.send("getParameters", parameterNames=[], id=str(number))
    viewer.publish(channel, encode(String(data="behind them")))
    with pytest.raises(RosTimeout):
        heard.next(0.3)
    assert not [one for one in viewer.came if isinstance(one, dict) and one["op"] == "parameterValues"]
    slow.answer.set()
    assert heard.next(5).data == "behind them"
    for number in range(8):
        assert viewer.document("parameterValues")["id"] == str(number)


def test_messages_of_a_topic_that_is_being_opened_keep_their_order(ground: Ground, slow: Slow) -> None:
    """They wait for it, and what comes later waits for them; taken back meanwhile, it is closed again."""
    heard = ground.robot.subscriber("/count", Int32, queue_size=100)
    viewer = ground.view(ground.serve(access=Access(write=["*"]), topics=[slow.topic]))
    slow.ask(viewer)
    channel = viewer.advertise("/count", "std_msgs/Int32")
    for number in range(30):
        viewer.publish(channel, encode(Int32(data=number)))
    other = viewer.advertise("/other", "std_msgs/Int32")
    viewer.send("unadvertise", channelIds=[other])
    slow.answer.set()
    assert [heard.next(5).data for _ in range(30)] == list(range(30))


def test_a_viewer_that_goes_while_its_request_waits(ground: Ground, slow: Slow) -> None:
    """What it had asked for is closed as soon as it is there."""
    ground.robot.publisher("/a", String)
    server = ground.serve(topics=[slow.topic], limits=GatewayLimits(linger_seconds=0.05))
    with ground.view(server) as viewer:
        viewer.subscribe("/a")
        slow.ask(viewer)
    slow.answer.set()
    with ground.view(server):
        until(lambda: server.stats().clients == 1, "the first viewer has not gone")
    until(lambda: slow.topic.receivers == 0 and ground.subscribers("/a") == [], "it is still followed")


def test_calls_that_wait_are_counted(ground: Ground) -> None:
    """One more than may is answered at once, and a call that has ended makes room."""
    begun, answer = threading.Event(), threading.Event()

    def handle(request: Any) -> dict[str, Any]:
        begun.set()
        assert answer.wait(30)
        return {"success": True}

    ground.robot.service_server("/set", SetBool, handle)
    viewer = ground.view(ground.serve(access=Access(write=["*"]), limits=GatewayLimits(calls_per_client=1)))
    data = encode(SetBool.Request(data=True))
    viewer.call("/set", data, call=1)
    assert begun.wait(10)
    viewer.call("/set", data, call=2)
    assert "1 calls of this client" in viewer.document("serviceCallFailure", callId=2)["message"]
    answer.set()
    assert viewer.wait(lambda one: isinstance(one, tuple) and one[0] == "response")[1] == 1
    viewer.call("/set", data, call=3)
    assert viewer.wait(lambda one: isinstance(one, tuple) and one[0] == "response")[1] == 3


@pytest.mark.promise("each is read only when it is sent")
def test_files_are_read_one_by_one(ground: Ground, tmp_path: Path) -> None:
    """A robot of many large meshes, asked for at once, is more than may wait for a viewer as answers."""
    (tmp_path / "big").mkdir()
    for number in range(4):
        (tmp_path / "big" / f"{number}.stl").write_bytes(bytes([number]) * 2_000_000)
    limits = GatewayLimits(answer_bytes=1_000_000)
    viewer = ground.view(ground.serve(assets=[tmp_path], limits=limits))
    for number in range(4):
        viewer.send("fetchAsset", uri=f"package://big/{number}.stl", requestId=number)
    for number in range(4):
        answer = viewer.wait(lambda one: isinstance(one, tuple) and one[0] == "asset")
        assert answer[1:4] == (number, 0, "")
        assert answer[4] == bytes([number]) * 2_000_000


def test_an_answer_that_is_too_long_is_a_sentence(ground: Ground) -> None:
    """And not the end of the connection."""
    answers = iter(["x" * 100_000, "short"])
    ground.robot.service_server("/set", SetBool, lambda request: {"success": True, "message": next(answers)})
    viewer = ground.view(ground.serve(access=Access(write=["*"]), limits=GatewayLimits(answer_bytes=100_000)))
    viewer.call("/set", encode(SetBool.Request()), call=1)
    assert "too large" in viewer.document("serviceCallFailure", callId=1)["message"]
    viewer.call("/set", encode(SetBool.Request()), call=2)
    assert viewer.wait(lambda one: isinstance(one, tuple) and one[0] == "response")[1] == 2


def test_parameters_are_followed_and_left(ground: Ground) -> None:
    """A deleted parameter has no value; without names, all are unsubscribed."""
    ground.robot.params["/speed"] = 1.5
    viewer = ground.view(ground.serve())
    viewer.send("subscribeParameterUpdates", parameterNames=["/speed"])
    assert viewer.document("parameterValues")["parameters"][0]["value"] == 1.5
    ground.robot.params["/speed"] = 2.5
    assert viewer.document("parameterValues")["parameters"][0]["value"] == 2.5
    viewer.send("unsubscribeParameterUpdates", parameterNames=[])
    viewer.send("getParameters", parameterNames=["/none"], id="left")
    viewer.document("parameterValues", id="left")
    ground.robot.params["/speed"] = 3.5
    viewer.send("getParameters", parameterNames=["/speed"], id="end")
    assert viewer.document("parameterValues")["id"] == "end"
