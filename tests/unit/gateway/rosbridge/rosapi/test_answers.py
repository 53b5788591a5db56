"""What /rosapi says about a graph, and what it keeps to itself."""

from __future__ import annotations

import socket
from collections.abc import Iterator

import pytest

from rosproto.codec import service_class
from rosproto.gateway import topic_type
from rosproto.gateway.access import Access
from rosproto.gateway.rosbridge.rosapi import Rosapi, RosapiError, provide
from rosproto.gateway.rosbridge.rosapi.graph import action_servers
from rosproto.master import Master
from rosproto.msg import bundled
from rosproto.node import Node
from tests.support.victim import eventually

MD5SUMS = {  # as genpy gives them for the files of rosbridge_suite, branch ros1
    "DeleteParam": "c1f3d28f1b044c871e6eff2e9fc3c667", "GetActionServers": "46807ba271844ac5ba4730a47556b236",
    "GetParam": "e36fd90759dbac1c5159140a7fa8c644", "GetParamNames": "dc7ae3609524b18034e49294a4ce670e",
    "GetTime": "556a4fb76023a469987922359d08a844", "HasParam": "ed3df286bd6dff9b961770f577454ea9",
    "MessageDetails": "f9c88144f6f6bd888dd99d4e0411905d", "NodeDetails": "e1d0ced5ab8d5edb5fc09c98eb1d46f6",
    "Nodes": "3d07bfda1268b4f76b16b7ba8a82665d", "Publishers": "cb37f09944e7ba1fc08ee38f7a94291d",
    "SearchParam": "dfadc39f113c1cc6d7759508d8461d5a", "ServiceHost": "a1b60006f8ee69637c856c94dd192f5a",
    "ServiceNode": "bd2a0a45fd7a73a86c8d6051d5a6db8a", "ServiceProviders": "f30b41d5e347454ae5483ee95eef5cc6",
    "ServiceRequestDetails": "f9c88144f6f6bd888dd99d4e0411905d",
    "ServiceResponseDetails": "f9c88144f6f6bd888dd99d4e0411905d",
    "ServiceType": "0e24a2dcdf70e483afc092a35a1f15f7", "Services": "e44a7e7bcb900acadbcc28b132378f0c",
    "ServicesForType": "93e9fe8ae5a9136008e260fe510bd2b0", "SetParam": "bc6ccc4a57f61779c8eaae61e9f422e0",
    "Subscribers": "cb387b68f5b29bc1456398ee8476b973", "TopicType": "0d30b3f53a0fd5036523a7141e524ddf",
    "Topics": "d966d98fc333fa1f3135af765eac1ba8", "TopicsAndRawTypes": "e1432466c8f64316723276ba07c59d12",
    "TopicsForType": "56f77ff6da756dd27c1ed16ec721072a",
}  # fmt: skip


@pytest.fixture
def nodes() -> Iterator[tuple[Node, Node]]:
    """A robot with a topic, a secret topic, a service and an action; and the gateway's node."""
    with (
        Master() as master,
        Node("/robot", master_uri=master.uri, rosout=False, intraprocess=False) as robot,
        Node("/gateway", master_uri=master.uri, rosout=False, intraprocess=False) as gateway,
    ):
        with robot.batch():
            robot.publisher("/chatter", "std_msgs/String")
            robot.publisher("/secret/odom", "nav_msgs/Odometry")
            robot.subscriber("/cmd", "geometry_msgs/Twist")
            robot.service_server("/lamp", "std_srvs/SetBool", lambda _: {"success": True})
            for part in ("status", "feedback", "result", "global_costmap/costmap"):
                robot.publisher(f"/move_base/{part}", "std_msgs/String")
            for part in ("goal", "cancel"):
                robot.subscriber(f"/move_base/{part}", "std_msgs/String")
        yield robot, gateway


def test_every_definition_is_the_one_of_the_original() -> None:
    """Names and md5sums of all 25 services."""
    found = {n.partition("/")[2]: bundled().md5sum(n, kind="srv") for n in bundled().services("rosapi")}
    assert found == MD5SUMS
    assert bundled().md5sum("tf2_web_republisher/TFSubscriptionAction") == "15787ffd6a2492c0022abe990c898794"


def test_topics_and_their_types(nodes: tuple[Node, Node]) -> None:
    """Published and subscribed ones, by name, by type, with definitions; "" for unknown names."""
    rosapi = Rosapi(nodes[1], Access())
    answer = rosapi.call("/rosapi/topics")
    types = dict(zip(answer["topics"], answer["types"], strict=True))  # type: ignore[call-overload]
    assert types["/chatter"] == "std_msgs/String"
    assert types["/cmd"] == "geometry_msgs/Twist"
    assert rosapi.call("rosapi/topic_type", {"topic": "/chatter"}) == {"type": "std_msgs/String"}
    assert rosapi.call("/rosapi/topic_type", ["chatter"]) == {"type": "std_msgs/String"}
    assert rosapi.call("/rosapi/topic_type", {"topic": "/nobody"}) == {"type": ""}
    assert rosapi.call("/rosapi/topics_for_type", {"type": "nav_msgs/Odometry"}) == {
        "topics": ["/secret/odom"]
    }
    assert rosapi.call("/rosapi/publishers", {"topic": "/chatter"}) == {"publishers": ["/robot"]}
    assert rosapi.call("/rosapi/subscribers", {"topic": "/cmd"}) == {"subscribers": ["/robot"]}
    assert rosapi.call("/rosapi/subscribers", {"topic": "/chatter"}) == {"subscribers": []}
    raw = rosapi.call("/rosapi/topics_and_raw_types")
    texts = dict(zip(raw["topics"], raw["typedefs_full_text"], strict=True))  # type: ignore[call-overload]
    assert "MSG: geometry_msgs/Vector3" in texts["/cmd"]


def test_services_nodes_and_actions(nodes: tuple[Node, Node]) -> None:
    """Providers, hosts and types of services, what each node does, and which names are actions."""
    rosapi = Rosapi(nodes[1], Access())
    services = rosapi.call("/rosapi/services")["services"]
    assert isinstance(services, list)
    assert {"/lamp", "/rosapi/topics"} <= set(services)
    assert rosapi.call("/rosapi/service_type", {"service": "/lamp"}) == {"type": "std_srvs/SetBool"}
    assert rosapi.call("/rosapi/service_type", {"service": "/rosapi/nodes"}) == {"type": "rosapi/Nodes"}
    assert rosapi.call("/rosapi/service_type", {"service": "/none"}) == {"type": ""}
    assert rosapi.call("/rosapi/service_node", {"service": "/lamp"}) == {"node": "/robot"}
    assert rosapi.call("/rosapi/service_node", {"service": "/rosapi/topics"}) == {"node": "/gateway"}
    assert rosapi.call("/rosapi/service_host", {"service": "/lamp"})["host"] == nodes[0].tcpros_address[0]
    assert rosapi.call("/rosapi/service_host", {"service": "/none"}) == {"host": ""}
    assert rosapi.call("/rosapi/services_for_type", {"type": "std_srvs/SetBool"}) == {"services": ["/lamp"]}
    assert rosapi.call("/rosapi/service_providers", {"service": "std_srvs/SetBool"}) == {
        "providers": ["/robot"]
    }
    assert rosapi.call("/rosapi/service_providers", {"service": "rosapi/Nodes"}) == {
        "providers": ["/gateway"]
    }
    assert rosapi.call("/rosapi/nodes") == {"nodes": ["/robot"]}
    details = rosapi.call("/rosapi/node_details", {"node": "/robot"})
    assert details["subscribing"] == ["/cmd", "/move_base/cancel", "/move_base/goal"]
    assert "/lamp" in details["services"]  # type: ignore[operator]
    assert "/rosapi/topics" in rosapi.call("/rosapi/node_details", {"node": "/gateway"})["services"]  # type: ignore[operator]
    assert rosapi.call("/rosapi/action_servers") == {"action_servers": ["/move_base"]}


def test_an_action_needs_all_five_topics_and_is_told_once() -> None:
    """Topics that sort between those of an action neither hide it nor double it."""
    five = [f"/a/{part}" for part in ("cancel", "feedback", "goal", "result", "status")]
    assert action_servers([*five, "/a/global/goal", "/a/zzz", "/tf", "/b/goal", "goal"]) == ["/a"]
    assert action_servers(five[:4]) == []
    assert action_servers(["/cancel", "/feedback", "/goal", "/result", "/status"]) == []


@pytest.mark.promise("No answer of `/rosapi` contains a name that `Access` hides")
def test_what_is_denied_is_in_no_list(nodes: tuple[Node, Node]) -> None:
    """Hidden topics, services, nodes and actions are in no answer, by whatever spelling."""
    rosapi = Rosapi(nodes[1], Access(deny=("/secret/*", "service:/lamp", "node:/robot", "action:/move_base")))
    assert "/secret/odom" not in rosapi.call("/rosapi/topics")["topics"]  # type: ignore[operator]
    assert "/secret/odom" not in rosapi.call("/rosapi/topics_and_raw_types")["topics"]  # type: ignore[operator]
    assert rosapi.call("/rosapi/topics_for_type", {"type": "nav_msgs/Odometry"}) == {"topics": []}
    for spelling in ("/secret/odom", "secret/odom", "//secret//odom", "/secret/odom/"):
        assert rosapi.call("/rosapi/topic_type", {"topic": spelling}) == {"type": ""}
        assert rosapi.call("/rosapi/publishers", {"topic": spelling}) == {"publishers": []}
    assert "/lamp" not in rosapi.call("/rosapi/services")["services"]  # type: ignore[operator]
    for spelling in ("/lamp", "lamp", "//lamp"):
        assert rosapi.call("/rosapi/service_type", {"service": spelling}) == {"type": ""}
        assert rosapi.call("/rosapi/service_host", {"service": spelling}) == {"host": ""}
    assert rosapi.call("/rosapi/services_for_type", {"type": "std_srvs/SetBool"}) == {"services": []}
    assert rosapi.call("/rosapi/nodes") == {"nodes": []}
    assert rosapi.call("/rosapi/publishers", {"topic": "/chatter"}) == {"publishers": []}
    assert rosapi.call("/rosapi/node_details", {"node": "/robot"})["services"] == []
    assert rosapi.call("/rosapi/action_servers") == {"action_servers": []}


@pytest.mark.promise("a million characters at most, a parameter's value 32 levels, an answer 300 types")
@pytest.mark.parametrize(
    ("service", "args", "text"),
    [
        ("/rosapi/nothing", {}, "is not one of /rosapi"),
        ("/rosapi/get_ros_version", {}, "is not one of /rosapi"),
        ("/rosapi/topic_type", {"topik": "/a"}, "has no field 'topik'"),
        ("/rosapi/topic_type", {"topic": 5}, "expected a string, got a int"),
        ("/rosapi/topic_type", {"topic": None}, "expected a string"),
        ("/rosapi/topic_type", "text", "expected an object or a list"),
        ("/rosapi/set_param", {"name": "/a", "value": "x" * (1 << 21)}, "expected at most"),
        ("/rosapi/topic_type", {"topic": "a b"}, "/rosapi/topic_type"),
        ("/rosapi/message_details", {"type": "Nothing"}, "not a type"),
        ("/rosapi/message_details", {"type": "no_msgs/Nothing"}, "not known here"),
        ("/rosapi/service_request_details", {"type": "no_msgs/Nothing"}, "not known here"),
        ("/rosapi/service_request_details", {"type": "std_msgs/String"}, "not known here"),
    ],
)
def test_what_cannot_be_answered_is_a_sentence(
    nodes: tuple[Node, Node], service: str, args: object, text: str
) -> None:
    """An unknown service, wrong or huge fields, unknown types: one documented error."""
    with pytest.raises(RosapiError, match=text):
        Rosapi(nodes[1], Access()).call(service, args)


@pytest.mark.promise("a million characters at most, a parameter's value 32 levels, an answer 300 types")
def test_a_master_that_is_gone_is_a_sentence() -> None:
    """A failure is a RosapiError, and no other exception."""
    with Master() as master, Node("/gateway", master_uri=master.uri, rosout=False) as node:
        rosapi = Rosapi(node, Access(), timeout=1.0)
        master.close()
        with pytest.raises(RosapiError, match="/rosapi/topics"):
            rosapi.call("/rosapi/topics")


def test_the_time_is_the_node_s(nodes: tuple[Node, Node]) -> None:
    """Seconds and nanoseconds of the ROS clock."""
    before = nodes[1].clock.now()
    time = Rosapi(nodes[1], Access()).call("/rosapi/get_time")["time"]
    assert isinstance(time, dict)
    assert (time["secs"], time["nsecs"]) >= (before.secs, before.nsecs)


def test_a_type_that_only_the_robot_knows_is_told_by_its_publisher(nodes: tuple[Node, Node]) -> None:
    """A definition is learned from a publisher's header, unless its topic is hidden."""
    from rosproto.codec import define

    own = define("my_msgs/Lamp", "uint8 OFF=0\nfloat32[3] colour\nmy_msgs/Part part\n" + "=" * 80
                 + "\nMSG: my_msgs/Part\nstring name\n")  # fmt: skip
    nodes[0].publisher("/lamp_state", own)
    with pytest.raises(RosapiError, match="no publisher of a visible topic"):
        Rosapi(nodes[1], Access(deny=("/lamp_state",))).call(
            "/rosapi/message_details", {"type": "my_msgs/Lamp"}
        )
    rosapi = Rosapi(nodes[1], Access())
    first, second = rosapi.call("/rosapi/message_details", {"type": "my_msgs/Lamp"})["typedefs"]  # type: ignore[misc]
    assert (first["fieldnames"], first["fieldarraylen"]) == (["colour", "part"], [3, -1])
    assert second["type"] == "my_msgs/Part"
    texts = rosapi.call("/rosapi/topics_and_raw_types")["typedefs_full_text"]
    assert any("MSG: my_msgs/Part" in text for text in texts)  # type: ignore[union-attr, attr-defined]


def test_the_same_answers_as_ros_services(nodes: tuple[Node, Node]) -> None:
    """Registered on demand, once in a graph, and taken back; nested and time fields have their types."""
    robot, gateway = nodes
    rosapi = Rosapi(gateway, Access())
    with provide(gateway, rosapi):
        details = robot.service_client("/rosapi/message_details", "rosapi/MessageDetails")
        (typedef,) = details.call(type="std_msgs/String", timeout=5).typedefs
        assert (typedef.type, list(typedef.fieldnames), list(typedef.fieldarraylen)) == (
            "std_msgs/String", ["data"], [-1],
        )  # fmt: skip
        time = robot.service_client("/rosapi/get_time", service_class("rosapi/GetTime")).call(timeout=5).time
        assert time.secs > 0
        with pytest.raises(Exception, match="already provides it"):
            provide(robot, Rosapi(robot, Access()))
    eventually(lambda: "/rosapi/topics" not in robot.master.get_system_state().services)


@pytest.mark.promise("a million characters at most, a parameter's value 32 levels, an answer 300 types")
def test_a_provider_that_is_silent_holds_up_nobody_for_long(
    nodes: tuple[Node, Node], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A provider that never answers: its type is unknown, it is probed once, and the others are listed."""
    monkeypatch.setattr(topic_type, "PROBE_SECONDS", 0.2)
    robot, gateway = nodes
    with socket.create_server(("127.0.0.1", 0)) as silent:
        uri = f"rosrpc://127.0.0.1:{silent.getsockname()[1]}"
        robot.master.register_service("/aaa", uri, robot.uri)
        rosapi = Rosapi(gateway, Access(), timeout=4.0)
        for _ in range(2):
            answer = rosapi.call("/rosapi/services_for_type", {"type": "std_srvs/SetBool"})
            assert answer == {"services": ["/lamp"]}
        assert rosapi.call("/rosapi/service_type", {"service": "/aaa"}) == {"type": ""}
        silent.settimeout(0.0)
        silent.accept()[0].close()
        with pytest.raises(BlockingIOError):
            silent.accept()
