"""What `--deny` covers is hidden in both gateways, however a client spells it: every operation that takes a name."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any, NamedTuple

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rosproto import Master, Node
from rosproto.codec import message_class, service_class
from rosproto.gateway import Access, GatewayLimits
from rosproto.names import canonicalize
from tests.support.rosbridge_client import RosbridgeClient

pytest.importorskip("websockets", reason='websockets is not installed: pip install ".[bridge]"')

from rosproto.gateway import Rosbridge
from rosproto.gateway.foxglove import Foxglove
from tests.support.viewer import Viewer

String = message_class("std_msgs/String")
SetBool = service_class("std_srvs/SetBool")

HIDDEN = "s3cret"
NAMES = ("/secret", "/secret/key", "/walk", "/walk/goal", "/walk/status", "/walk/deep/inside")
DENIED = ("/secret", "//walk/")


def spellings(name: str) -> st.SearchStrategy[str]:
    """Texts that mean the same name to a master, and some that do not mean a name at all."""
    parts = name.strip("/").split("/")
    slashes = st.sampled_from(["/", "//", "///", "/////"])
    inner = st.tuples(*[slashes] * (len(parts) - 1)).map(
        lambda between: "".join(p + s for p, s in zip(parts, (*between, ""), strict=True))
    )
    whole = st.tuples(st.sampled_from(["", "/", "//", "////"]), inner, st.sampled_from(["", "/", "//"]))
    same = whole.map("".join)
    odd = st.tuples(
        same, st.sampled_from(["\u200b", " ", "\0", "\u2044x", "~", "/..", ":", "\n", "%2f", "/\u0301"])
    ).map("".join)
    return same | odd | same.map(lambda text: f"~{text}")


TRIED = st.sampled_from(NAMES).flatmap(spellings)


@given(TRIED, st.sampled_from(["topic", "service", "parameter", "action", "node"]))
def test_a_rule_holds_for_every_spelling(name: str, kind: Any) -> None:
    """The rule itself brings a name into its canonical form: no caller can forget it."""
    access = Access(deny=DENIED, write=["*"])
    meant = canonicalize(f"/{name}")
    denied = any(meant == root or meant.startswith(f"{root}/") for root in ("/secret", "/walk"))
    assert (access.may_read(kind, name) is not None) is denied
    assert (access.may_write(kind, name) is not None) is denied


class World(NamedTuple):
    robot: Node
    client: RosbridgeClient
    viewer: Viewer


@pytest.fixture(scope="module")
def world() -> Iterator[World]:
    with ExitStack() as stack:
        enter = stack.enter_context
        master = enter(Master())
        robot = enter(Node("/robot", master_uri=master.uri, rosout=False, intraprocess=False))
        bridge_node = enter(Node("/bridge", master_uri=master.uri, rosout=False, intraprocess=False))
        viewer_node = enter(Node("/viewer", master_uri=master.uri, rosout=False, intraprocess=False))
        for name in ("/secret/key", "/walk/goal", "/walk/status", "/walk/deep/inside"):
            robot.publisher(f"{name}", String, latch=True).publish(data=HIDDEN)
            robot.service_server(
                f"{name}_call".replace("_call", "/call"), SetBool, lambda request: (True, HIDDEN)
            )
            robot.params[f"{name}"] = HIDDEN
        robot.params["/open"] = 1
        access = Access(deny=DENIED, write=["*"])
        limits = GatewayLimits(linger_seconds=0.0, advertised_per_client=2000)
        bridge = enter(Rosbridge(bridge_node, port=0, access=access, limits=limits))
        foxglove = enter(Foxglove(viewer_node, port=0, access=access, limits=limits))
        yield World(robot, enter(RosbridgeClient(bridge.url)), enter(Viewer(foxglove.url)))


def answers(client: RosbridgeClient, request: dict[str, Any]) -> list[Any]:
    """All messages of the server until it has answered what came before."""
    client.send(**request)
    client.send(op="call_service", service="/rosapi/get_time", id="after")
    found: list[Any] = []
    while not found or found[-1].get("id") != "after":
        found.append(client.get())
    return found[:-1]


ROSAPI = (
    "topic_type",
    "publishers",
    "subscribers",
    "service_type",
    "service_node",
    "service_host",
    "node_details",
    "get_param",
    "set_param",
    "has_param",
    "search_param",
    "delete_param",
)
FIELD = {
    "topic_type": "topic",
    "publishers": "topic",
    "subscribers": "topic",
    "node_details": "node",
} | dict.fromkeys(("service_type", "service_node", "service_host"), "service")


def requests(name: str) -> Iterator[dict[str, Any]]:
    """Every operation of rosbridge that takes a name."""
    goal = {"action": name, "action_type": "actionlib/Test"}
    yield {"op": "subscribe", "topic": name, "id": "s"}
    yield {"op": "subscribe", "topic": name, "id": "s", "compression": "cbor-raw"}
    yield {"op": "advertise", "topic": name, "type": "std_msgs/String", "id": "a"}
    yield {"op": "publish", "topic": name, "msg": {"data": "x"}, "id": "p"}
    yield {"op": "call_service", "service": name, "args": {"data": True}, "id": "c"}
    yield {"op": "call_service", "service": f"{name}/call", "args": {"data": True}, "id": "c"}
    yield {"op": "advertise_service", "service": name, "type": "std_srvs/SetBool", "id": "v"}
    yield {"op": "send_action_goal", **goal, "args": {"goal": 1}, "id": "g"}
    yield {"op": "cancel_action_goal", "action": name, "id": "g"}
    yield {"op": "advertise_action", "action": name, "type": "actionlib/Test", "id": "t"}
    yield {"op": "call_service", "service": f"{name}/_action/cancel_goal", "id": "k"}
    for call in ROSAPI:
        yield {
            "op": "call_service",
            "service": f"/rosapi/{call}",
            "args": {FIELD.get(call, "name"): name, **({"value": "1"} if call == "set_param" else {})},
            "id": "r",
        }


SLOW = settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def graph_of(robot: Node) -> tuple[Any, ...]:
    state = robot.master.get_system_state()
    kept = ("/secret", "/walk")
    tables = (state.publishers, state.subscribers, state.services)
    return (
        [{name: nodes for name, nodes in table.items() if name.startswith(kept)} for table in tables],
        [robot.params["/secret"], robot.params["/walk"], robot.params["/open"]],
    )


def denied(name: str) -> bool:
    meant = canonicalize(f"/{name}")
    return any(meant == root or meant.startswith(f"{root}/") for root in ("/secret", "/walk"))


@pytest.mark.slow
@pytest.mark.promise("are neither read, nor written, nor listed")
@SLOW
@given(TRIED.filter(denied))
def test_rosbridge(world: World, name: str) -> None:
    """Nothing hidden is in an answer, or changed, and each operation gives an answer that shows nothing."""
    before = graph_of(world.robot)
    for request in requests(name):
        found = answers(world.client, request)
        told = json.dumps([{key: one[key] for key in one if key != "msg"} for one in found])
        assert HIDDEN not in json.dumps(found), (request, found)
        assert '"exists": true' not in told, (request, found)
        for one in found:
            values = one.get("values")
            if isinstance(values, dict):  # an answer of /rosapi
                assert not any(values.values()), (request, found)
            else:
                assert one["op"] in ("status", "service_response", "action_result"), (request, found)
                assert one.get("level", "error") == "error", (request, found)
                assert not one.get("result"), (request, found)
    assert graph_of(world.robot) == before


@pytest.mark.slow
@pytest.mark.promise("are neither read, nor written, nor listed")
@SLOW
@given(TRIED.filter(denied), st.sampled_from(["std_msgs/String", "my/Own"]))
def test_foxglove(world: World, name: str, kind: str) -> None:
    """Parameters by every spelling, one by one and below a namespace; topics are not published."""
    before, viewer = graph_of(world.robot), world.viewer
    for value in (1, None, {"key": 2}):
        parameter = {"name": name, "value": value} if value is not None else {"name": name}
        viewer.send("setParameters", parameters=[parameter], id="set")
        assert viewer.document("parameterValues", id="set")["parameters"] == []
    viewer.send("setParameters", parameters=[{"name": "/", "value": {"open": 1}}], id="root")
    viewer.document("parameterValues", id="root")
    viewer.send("subscribeParameterUpdates", parameterNames=[name])
    viewer.send("getParameters", parameterNames=[name], id="get")
    assert viewer.document("parameterValues", id="get")["parameters"] == []
    channel = viewer.advertise(name, kind, "string data")
    viewer.publish(channel, b"\x01\0\0\0x")
    viewer.send("unadvertise", channelIds=[channel])
    viewer.send("getParameters", parameterNames=[], id="all")
    told = viewer.document("parameterValues", id="all")["parameters"]
    assert [one["name"] for one in told if denied(one["name"])] == []
    assert not [topic for topic in (*viewer.channels, *viewer.services) if denied(topic)]
    assert not [one for one in viewer.came if HIDDEN in str(one)]
    assert graph_of(world.robot) == before
