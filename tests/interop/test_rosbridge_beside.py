"""Beside the original: the same requests to rosbridge_suite (branch ros1) and to ours, the same answers, field by field.

Both serve one graph with a robot of rospy. What differs on purpose is in `DIFFERENT`, which says what each answers;
docs/rosbridge.md lists it. The original is run unchanged on Debian's rospy, and on our own layer.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from rosproto.errors import ServiceError
from rosproto.master import Master
from tests.interop.rosbridge_world import World, our_bridge, world
from tests.support import ros
from tests.support.victim import eventually

cbor2 = pytest.importorskip("cbor2", reason='cbor2 is not installed: pip install ".[bridge]"')
websockets = pytest.importorskip(
    "websockets.sync.client", reason='websockets is not installed: pip install ".[bridge]"'
)

SECONDS = 20


class Beside(NamedTuple):
    """Both, with a connection to each."""

    world: World
    original: Any
    ours: Any
    urls: tuple[str, str]


@pytest.fixture(scope="module")
def beside(genpy_packages: Path, built_rosbridge: Path) -> Iterator[Beside]:
    """The original on Debian's rospy, and ours, at one master."""
    with ExitStack() as stack:
        uri = stack.enter_context(ros.start_real_master())
        made = stack.enter_context(world("original", uri, genpy_packages, built_rosbridge))
        url = stack.enter_context(our_bridge(uri, "/our_bridge"))
        original, ours = (stack.enter_context(websockets.connect(u, max_size=None)) for u in (made.url, url))
        yield Beside(made, original, ours, (made.url, url))


def answer(client: Any, request: dict[str, Any]) -> dict[str, Any]:
    """What it answers to a call of a service."""
    client.send(json.dumps({"op": "call_service", "id": "asked", **request}))
    while True:
        came = json.loads(client.recv(timeout=SECONDS))
        if came["op"] == "service_response":
            return dict(came)


def normal(value: Any) -> Any:
    """Lists of names in one order: each has its own."""
    if isinstance(value, dict):
        if {"topics", "types"} <= value.keys():  # columns that belong together
            return sorted(zip(value["topics"], value["types"], strict=True))
        return {key: normal(item) for key, item in value.items()}
    if isinstance(value, list):
        return sorted(value) if all(isinstance(item, str) for item in value) else list(map(normal, value))
    return value


DETAILS = (
    "std_msgs/String", "std_msgs/Byte", "std_msgs/Duration", "std_msgs/UInt8MultiArray", "nav_msgs/Odometry",
    "actionlib_msgs/GoalStatusArray", "sensor_msgs/NavSatFix", "sensor_msgs/PointCloud2", "visualization_msgs/Marker",
    "diagnostic_msgs/DiagnosticArray", "rosgraph_msgs/Log", "shape_msgs/SolidPrimitive", "tf2_msgs/TFMessage",
    "woosh_msgs/RobotStatus", "woosh_msgs/StepControlActionGoal", "geometry_msgs/TransformStamped", "time", "duration",
    "int32", "string",
)  # fmt: skip
SAME: list[tuple[str, Any]] = [
    ("topics", {}),
    ("topics_for_type", {"type": "std_msgs/String"}),
    ("topics_for_type", {"type": "none/None"}),
    ("topic_type", {"topic": "/chatter"}),
    ("topic_type", {"topic": "/to_robot"}),
    ("topic_type", {"topic": "/none"}),
    ("topic_type", ["/chatter"]),
    ("topic_type", ["/chatter", "more"]),
    ("topic_type", []),
    ("topic_type", {}),
    ("topic_type", None),
    ("publishers", {"topic": "/chatter"}),
    ("publishers", {"topic": "/none"}),
    ("subscribers", {"topic": "/to_robot"}),
    ("subscribers", {"topic": "/none"}),
    ("services_for_type", {"type": "std_srvs/SetBool"}),
    ("services_for_type", {"type": "none/None"}),
    ("service_type", {"service": "/lamp"}),
    ("service_type", {"service": "/none"}),
    ("service_type", {"service": "/rosapi/topics"}),
    ("service_node", {"service": "/lamp"}),
    ("service_node", {"service": "/none"}),
    ("service_host", {"service": "/lamp"}),
    ("service_host", {"service": "/none"}),
    ("service_providers", {"service": "std_srvs/SetBool"}),
    ("service_providers", {"service": "none/None"}),
    ("nodes", {}),
    ("node_details", {"node": "/robot"}),
    ("node_details", {"node": "/none"}),
    ("action_servers", {}),
    *(("message_details", {"type": name}) for name in DETAILS),
    ("service_request_details", {"type": "std_srvs/SetBool"}),
    ("service_request_details", {"type": "std_srvs/Empty"}),
    ("service_request_details", {"type": "nav_msgs/GetPlan"}),
    ("service_response_details", {"type": "std_srvs/SetBool"}),
    ("service_response_details", {"type": "nav_msgs/GetPlan"}),
    ("service_response_details", {"type": "rosapi/MessageDetails"}),
    ("get_param", {"name": "/speed"}),
    ("get_param", {"name": "speed"}),
    ("get_param", {"name": "/robot"}),
    ("get_param", {"name": "/robot/size"}),
    ("get_param", {"name": "/rosdistro"}),
    ("get_param", {"name": "/none"}),
    ("get_param", {"name": "/none", "default": "5"}),
    ("get_param", {"name": "/none", "default": "text"}),
    ("has_param", {"name": "/robot"}),
    ("has_param", {"name": "/none"}),
    ("search_param", {"name": "speed"}),
    ("search_param", {"name": "none"}),
    ("get_param_names", {}),
    ("set_param", {"name": "/written", "value": '[1, 2.5, "ö", true, {"a": []}]'}),
    ("get_param", {"name": "/written"}),
    ("delete_param", {"name": "/written"}),
    ("delete_param", {"name": "/written"}),
    ("get_param", {"name": "/written"}),
]


@pytest.mark.parametrize(("service", "args"), SAME, ids=lambda value: json.dumps(value)[:40])
def test_the_same_answer(beside: Beside, service: str, args: Any) -> None:
    """Every service of /rosapi, with arguments in each form."""
    request = {"service": f"/rosapi/{service}", "args": args}
    end = time.monotonic() + 10.0
    while True:  # what another test has closed goes off the master between the two answers
        ours, original = (answer(client, request) for client in (beside.ours, beside.original))
        if normal(ours) == normal(original) or time.monotonic() > end:
            break
    assert original["result"], original
    assert normal(ours) == normal(original)


NOT_ANSWERED: list[tuple[str, dict[str, Any]]] = [
    ("/rosapi/get_ros_version", {}),
    ("/none", {}),
    ("/rosapi/topic_type", {"topic": 5}),
    ("/rosapi/topic_type", {"topik": "/chatter"}),
    ("/rosapi/message_details", {"type": "none/None"}),
    ("/rosapi/message_details", {"type": "bad"}),
    ("/rosapi/message_details", {"type": ""}),
    ("/rosapi/service_request_details", {"type": "none/None"}),
    ("/rosapi/set_param", {"name": "/written", "value": "no JSON"}),
    ("/rosapi/set_param", {"name": "/written", "value": "null"}),
    ("/lamp", {"data": False}),
    ("/lamp", {"data": "text"}),
    ("/lamp", {"data": 5}),
    ("/lamp", {"dota": True}),
]


@pytest.mark.parametrize(("service", "args"), NOT_ANSWERED, ids=lambda value: json.dumps(value)[:40])
def test_the_same_refusal(beside: Beside, service: str, args: dict[str, Any]) -> None:
    """What the original refuses is refused, in the same form; the sentence is another one."""
    request = {"service": service, "args": args}
    ours, original = (answer(client, request) for client in (beside.ours, beside.original))
    assert original["result"] is ours["result"] is False
    assert isinstance(ours["values"], str)
    assert {**ours, "values": ""} == {**original, "values": ""}


DIFFERENT: list[tuple[str, dict[str, Any], Any, Any]] = [
    # A relative name is resolved, as everywhere in ROS.
    ("topic_type", {"topic": "chatter"}, {"type": ""}, {"type": "std_msgs/String"}),
    ("subscribers", {"topic": "to_robot"}, {"subscribers": []}, {"subscribers": ["/robot"]}),
    # The name of a field behind that of a topic is not a topic.
    ("topic_type", {"topic": "/scan/ranges"}, {"type": "sensor_msgs/LaserScan"}, {"type": ""}),
    # NaN is not JSON: JSON.parse of the page fails.
    ("get_param", {"name": "/odd"}, {"value": "[NaN, Infinity]"}, {"value": "[null, null]"}),
    # An empty name is nobody's parameter; the original gives the parameters below its own name.
    ("get_param", {"name": ""}, True, False),
    # A type with a field of type char, and ROS 2's way to write a type, are answered.
    ("message_details", {"type": "std_msgs/Char"}, False, True),
    ("message_details", {"type": "std_msgs/msg/String"}, False, True),
]  # fmt: skip


@pytest.mark.parametrize(("service", "args", "theirs", "own"), DIFFERENT)
def test_what_differs_on_purpose(
    beside: Beside, service: str, args: dict[str, Any], theirs: Any, own: Any
) -> None:
    """Each difference, from both sides."""
    beside.world.node.params["/odd"] = [float("nan"), float("inf")]
    request = {"service": f"/rosapi/{service}", "args": args}
    for client, expected in ((beside.original, theirs), (beside.ours, own)):
        got = answer(client, request)
        assert (got["result"] if isinstance(expected, bool) else got["values"]) == expected
    del beside.world.node.params["/odd"]


def test_topics_for_type_names_no_topic_that_is_gone(beside: Beside) -> None:
    """The master remembers a topic's type after its last publisher has left; the original lists such topics."""
    asked = {"service": "/rosapi/topics_for_type", "args": {"type": "std_msgs/Empty"}}
    with beside.world.node.publisher("/passing", "std_msgs/Empty"):
        for client in (beside.original, beside.ours):
            assert "/passing" in answer(client, asked)["values"]["topics"]
    eventually(lambda: "/passing" not in answer(beside.ours, asked)["values"]["topics"], SECONDS)
    assert "/passing" in answer(beside.original, asked)["values"]["topics"]


def test_an_action_with_other_topics_below_its_name(beside: Beside) -> None:
    """move_base is one: the original does not list it."""
    node = beside.world.node
    topics = ("cancel", "feedback", "global_costmap/costmap", "goal", "result", "status")
    with ExitStack() as stack:
        for name in topics:
            stack.enter_context(node.publisher(f"/navigate/{name}", "std_msgs/Empty"))
        found = [
            answer(client, {"service": "/rosapi/action_servers"})["values"]["action_servers"]
            for client in (beside.original, beside.ours)
        ]
    assert "/navigate" not in found[0]
    assert found[1] == ["/navigate", "/walk"]


@pytest.mark.parametrize(
    "request_",
    [
        {"service": "/lamp", "args": {"data": True}},
        {"service": "/lamp", "args": [True]},
        {"service": "/lamp", "args": {"data": True}, "id": None},
        {"service": "/lamp#7", "args": {"data": True}, "id": None},
        {"service": "lamp", "args": {"data": True}},
        {"service": "/ask"},
        {"service": "/lamp", "args": {"data": True}, "id": 1.5},
        {"service": "/lamp", "args": {"data": True}, "id": True},
        {"service": "/lamp", "args": {"data": True}, "timeout": "5", "type": 5},
    ],
    ids=lambda value: json.dumps(value)[:60],
)
def test_calls_are_answered_alike(beside: Beside, request_: dict[str, Any]) -> None:
    """With and without an id, the id behind the name, arguments by position, a relative name, no arguments, an
    odd id, and fields of ROS 2 that make no sense."""
    request = {key: value for key, value in request_.items() if value is not None}
    drop = "id" in request_ and request_["id"] is None
    both = []
    for client in (beside.original, beside.ours):
        client.send(json.dumps({"op": "call_service", **({} if drop else {"id": "asked"}), **request}))
        both.append(json.loads(client.recv(timeout=SECONDS)))
    assert both[0] == both[1]


def test_arguments_that_are_none_are_answered(beside: Beside) -> None:
    """The original calls the service without any; ours refuses them, in the same form."""
    original, ours = (
        answer(client, {"service": "/ask", "args": "x"}) for client in (beside.original, beside.ours)
    )
    assert (original["result"], ours["result"]) == (True, False)
    assert "field args" in ours["values"]
    assert {**original, "values": "", "result": None} == {**ours, "values": "", "result": None}


def messages(client: Any, topic: str, type_name: str, count: int | None = 1, **options: Any) -> list[Any]:
    """What comes first of a subscription, text as JSON has it; without a count as many as the first says."""
    client.send(json.dumps({"op": "subscribe", "id": "s", "topic": topic, "type": type_name, **options}))
    came = []
    while len(came) < (count or (came[0]["total"] if came else 1)):
        data = client.recv(timeout=SECONDS)
        came.append(json.loads(data) if isinstance(data, str) else data)
    client.send(json.dumps({"op": "unsubscribe", "id": "s", "topic": topic}))
    client.send(json.dumps({"op": "call_service", "id": "last", "service": "/rosapi/get_time"}))
    while True:  # what was under way
        data = client.recv(timeout=SECONDS)
        if isinstance(data, str) and json.loads(data).get("id") == "last":
            return came


TOPICS = [
    ("/kept", "std_msgs/String"), ("/chatter", "std_msgs/String"), ("/picture", "sensor_msgs/Image"),
    ("/scan", "sensor_msgs/LaserScan"), ("/walk/status", "actionlib_msgs/GoalStatusArray"),
]  # fmt: skip
MOVING = {"seq", "stamp", "secs", "nsecs"}


def still(value: Any) -> Any:
    """Without what differs from message to message."""
    if isinstance(value, dict):
        return {key: "..." if key in MOVING else still(item) for key, item in value.items()}
    return [still(item) for item in value] if isinstance(value, list) else value


@pytest.mark.parametrize(("topic", "type_name"), TOPICS)
def test_messages_are_alike_as_json(beside: Beside, topic: str, type_name: str) -> None:
    """Latched text, NaN and infinity, bytes, nested stamps."""
    original, ours = (messages(client, topic, type_name)[0] for client in (beside.original, beside.ours))
    assert still(ours) == still(original)


@pytest.mark.parametrize(("topic", "type_name"), TOPICS)
def test_messages_are_alike_as_cbor(beside: Beside, topic: str, type_name: str) -> None:
    """The same values, and the same bytes where nothing in them moves: tags of typed arrays included."""
    original, ours = (
        messages(client, topic, type_name, compression="cbor")[0] for client in (beside.original, beside.ours)
    )
    assert repr(still(cbor2.loads(ours))) == repr(still(cbor2.loads(original)))
    if topic in ("/kept", "/chatter"):
        assert ours == original


def test_raw_messages_are_alike(beside: Beside) -> None:
    """cbor-raw: the message's own bytes and the time it came, under the same names."""
    original, ours = (
        cbor2.loads(messages(client, "/kept", "std_msgs/String", compression="cbor-raw")[0])
        for client in (beside.original, beside.ours)
    )
    assert ours.keys() == original.keys()
    assert ours["msg"].keys() == original["msg"].keys()
    assert ours["msg"]["bytes"] == original["msg"]["bytes"]


def test_pictures_of_messages_are_alike(beside: Beside) -> None:
    """png: pixels that are the same text."""
    from rosproto.gateway.rosbridge.png import unpack

    texts = []
    for client in (beside.original, beside.ours):
        (came,) = messages(client, "/kept", "std_msgs/String", compression="png")
        assert came.keys() == {"op", "data"}
        texts.append(json.loads(unpack(came["data"])))
    assert texts[0] == texts[1]


def test_fragments_are_alike(beside: Beside) -> None:
    """As many, with the same fields; joined they are the same message.

    The original's `total` is not a whole number (5.3), and its first id is 0, which roslib takes for none.
    """
    both = []
    for url in beside.urls:  # the original cuts everything of a connection from here on
        with websockets.connect(url) as client:
            asked = {"op": "subscribe", "topic": "/kept", "type": "std_msgs/String", "fragment_size": 20}
            client.send(json.dumps(asked))
            parts = [json.loads(client.recv(timeout=SECONDS))]
            while len(parts) < int(parts[0]["total"]):
                parts.append(json.loads(client.recv(timeout=SECONDS)))
        assert [part["num"] for part in parts] == list(range(len(parts)))
        assert all(part["op"] == "fragment" and int(part["total"]) == len(parts) for part in parts)
        assert all(part.keys() == {"op", "id", "data", "num", "total"} for part in parts)
        both.append(json.loads("".join(part["data"] for part in parts)))
    assert both[0] == both[1]


def test_a_page_hears_what_another_one_publishes(beside: Beside) -> None:
    """From either to either: advertised, published with defaults for what is left out, and a stamp in the header."""
    for number, (mouth, ear) in enumerate(
        [(beside.original, beside.ours), (beside.ours, beside.original), (beside.ours, beside.ours)]
    ):
        topic = f"/said_{number}"
        mouth.send(
            json.dumps(
                {"op": "advertise", "topic": topic, "type": "geometry_msgs/PoseStamped", "latch": True}
            )
        )
        message = {"header": {"frame_id": "map"}, "pose": {"position": {"x": 1}}}
        mouth.send(json.dumps({"op": "publish", "topic": topic, "msg": message}))
        (came,) = messages(ear, topic, "geometry_msgs/PoseStamped")
        assert came["msg"]["pose"] == {
            "position": {"x": 1.0, "y": 0.0, "z": 0.0},
            "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 0.0},
        }
        assert came["msg"]["header"]["frame_id"] == "map"
        assert came["msg"]["header"]["stamp"]["secs"] > 1_000_000_000
        mouth.send(json.dumps({"op": "unadvertise", "topic": topic}))


def test_a_service_of_a_page_is_called_alike(beside: Beside) -> None:
    """What a page gets for a call, and that its answer arrives; its failure, too.

    A failure with a text, as roslib's `advertiseAsync` sends it, the original leaves unanswered for ever.
    """
    for page, name in ((beside.original, "/page_original"), (beside.ours, "/page_ours")):
        page.send(json.dumps({"op": "advertise_service", "service": name, "type": "std_srvs/SetBool"}))
        beside.world.node.wait_for_service(name, timeout=SECONDS)
        client = beside.world.node.service_client(name, "std_srvs/SetBool")
        for result in (True, False) if page is beside.ours else (True,):
            with ThreadPoolExecutor(1) as pool:
                called = pool.submit(client.call, data=True, timeout=SECONDS)
                request = json.loads(page.recv(timeout=SECONDS))
                assert request.keys() == {"op", "id", "service", "args"}
                assert (request["op"], request["service"]) == ("call_service", name)
                assert request["args"] == {"data": True}
                answer = {"op": "service_response", "id": request["id"], "service": name, "result": result}
                values = {"success": True, "message": "by a page"} if result else "it is broken"
                page.send(json.dumps({**answer, "values": values}))
                if result:
                    assert called.result(SECONDS).message == "by a page"
                else:
                    with pytest.raises(ServiceError):
                        called.result(SECONDS)
        page.send(json.dumps({"op": "unadvertise_service", "service": name}))
        eventually(partial(_is_gone, beside, name), SECONDS)


def _is_gone(beside: Beside, service: str) -> bool:
    return service not in beside.world.node.master.get_system_state().services


def test_the_original_runs_on_our_own_rospy(genpy_packages: Path, built_rosbridge: Path) -> None:
    """rosbridge_suite unchanged under `rosproto run`, at our master: it answers what it answers on Debian's."""
    with (
        Master() as ours,
        ros.start_real_master() as debian,
        world("original", ours.uri, genpy_packages, built_rosbridge, layer=True) as layered,
        world("original", debian, genpy_packages, built_rosbridge) as real,
        websockets.connect(layered.url, max_size=None) as one,
        websockets.connect(real.url, max_size=None) as other,
    ):
        for made in (layered, real):
            made.node.params["/rosdistro"] = "noetic\n"
            made.node.params["/rosversion"] = "1.16.0\n"
            made.node.params["/run_id"] = "the same"
        differ = []
        asked = [*((f"/rosapi/{service}", args) for service, args in SAME), *NOT_ANSWERED, ("/lamp", [True])]
        for service, args in asked:
            request = {"service": service, "args": args}
            answers = [normal(answer(client, request)) for client in (one, other)]
            if not answers[0]["result"]:  # the sentences name programs and files
                answers = [{**found, "values": ""} for found in answers]
            if answers[0] != answers[1]:
                differ.append((service, args, *answers))
        assert differ == [], json.dumps(differ, indent=1)
        for topic, type_name in TOPICS:
            for compression in ("none", "cbor", "png"):
                first, second = (
                    messages(client, topic, type_name, compression=compression)[0] for client in (one, other)
                )
                if compression == "none" or topic == "/kept":
                    assert still(first) == still(second)
                assert type(first) is type(second)
