"""The messages of the Foxglove protocol: reading valid and invalid ones, and writing."""

from __future__ import annotations

import json
import math
import struct
from datetime import datetime
from typing import Any

import pytest

from msgdefs.std_srvs.srv import SetBool
from rosproto.gateway.foxglove import messages
from rosproto.gateway.foxglove.advertised_channels import AdvertisedChannel, AdvertisedService, TopicSchema
from rosproto.gateway.foxglove.graph import ConnectionGraph
from rosproto.gateway.foxglove.messages import ClientAdvertisement, Level, MessageError
from rosproto.json_text import JsonReader

READER = JsonReader(1000, 10)


def read(op: str, **fields: Any) -> messages.Request:
    return messages.read(json.dumps({"op": op, **fields}), READER)


CHANNEL = {"id": 4, "topic": "/cmd_vel", "encoding": "json", "schemaName": "geometry_msgs/Twist"}
READ: tuple[tuple[str, dict[str, Any], messages.Request], ...] = (
    ("subscribe", {"subscriptions": [{"id": 1, "channelId": 7}]}, messages.Subscribe(((1, 7),))),
    ("unsubscribe", {"subscriptionIds": [1, 0xFFFFFFFF]}, messages.Unsubscribe((1, 0xFFFFFFFF))),
    (
        "advertise",
        {"channels": [CHANNEL, {**CHANNEL, "schema": "string data", "schemaEncoding": "ros1msg"}]},
        messages.Advertise(
            (
                ClientAdvertisement(4, "/cmd_vel", "json", "geometry_msgs/Twist"),
                ClientAdvertisement(4, "/cmd_vel", "json", "geometry_msgs/Twist", "string data", "ros1msg"),
            )
        ),
    ),
    ("unadvertise", {"channelIds": [4]}, messages.Unadvertise((4,))),
    ("getParameters", {"parameterNames": []}, messages.GetParameters(())),
    ("getParameters", {"parameterNames": ["/a"], "id": "x"}, messages.GetParameters(("/a",), "x")),
    ("subscribeParameterUpdates", {"parameterNames": ["/a"]}, messages.FollowParameters(("/a",))),
    ("unsubscribeParameterUpdates", {"parameterNames": []}, messages.LeaveParameters(())),
    ("subscribeConnectionGraph", {}, messages.WantGraph(True)),
    ("unsubscribeConnectionGraph", {}, messages.WantGraph(False)),
    ("fetchAsset", {"uri": "package://a/b", "requestId": 3}, messages.FetchAsset("package://a/b", 3)),
)


@pytest.mark.parametrize(("op", "fields", "request_"), READ)
def test_documents(op: str, fields: dict[str, Any], request_: messages.Request) -> None:
    """Each kind with its fields; what it has besides is left unread."""
    assert read(op, **fields) == request_
    assert read(op, **fields, more=1) == request_


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ({"value": 3}, 3),
        ({"value": [1, "a"]}, [1, "a"]),
        ({"value": {"a": True}}, {"a": True}),
        ({}, None),
        ({"value": None, "type": "float64"}, None),
        ({"value": "QUJDRA==", "type": "byte_array"}, b"ABCD"),
        ({"value": 3, "type": "float64"}, 3.0),
        ({"value": [1, 2.5], "type": "float64_array"}, [1.0, 2.5]),
    ],
)
def test_values_of_parameters(field: dict[str, Any], value: object) -> None:
    """As their type says: a whole number that is meant as a decimal one is no int."""
    asked = read("setParameters", parameters=[{"name": "/a", **field}], id="s")
    assert asked == messages.SetParameters((("/a", value),), "s")
    assert isinstance(asked, messages.SetParameters)
    assert type(asked.parameters[0][1]) is type(value)


WRONG: tuple[tuple[str, str], ...] = (
    ("", "not a JSON object"),
    ("x", "not JSON"),
    ("[]", "not a JSON object"),
    ("{}", "op is missing"),
    ('{"op": 5}', "op is 5"),
    ('{"op": ["subscribe"]}', "op is"),
    ('{"op": "nonsense"}', "expected one of subscribe"),
    ('{"op": "subscribe"}', "subscriptions is missing; expected a list"),
    ('{"op": "subscribe", "subscriptions": [1]}', r"subscriptions\[0\] is 1; expected an object"),
    ('{"op": "subscribe", "subscriptions": [{"id": 1}]}', r"subscriptions\[0\].channelId is missing"),
    ('{"op": "subscribe", "subscriptions": [{"id": true, "channelId": 1}]}', r"subscriptions\[0\].id is true; expected"),
    ('{"op": "subscribe", "subscriptions": [{"id": -1, "channelId": 1}]}', "id is -1"),
    ('{"op": "subscribe", "subscriptions": [{"id": 4294967296, "channelId": 1}]}', "32 bits"),
    ('{"op": "unsubscribe", "subscriptionIds": [1.5]}', r"subscriptionIds\[0\] is 1.5"),
    ('{"op": "advertise", "channels": [{"id": 1, "topic": "/a"}]}', r"channels\[0\].encoding is missing; expected a text"),
    ('{"op": "getParameters", "parameterNames": [1]}', r"parameterNames\[0\] is 1; expected a text"),
    ('{"op": "getParameters", "parameterNames": [], "id": 7}', "id is 7"),
    ('{"op": "fetchAsset", "uri": 1, "requestId": 1}', "uri is 1; expected a text"),
    ('{"op": "setParameters", "parameters": [{"name": "/a", "value": "%", "type": "byte_array"}]}', "no 'byte"),
    ('{"op": "setParameters", "parameters": [{"name": "/a", "value": "1", "type": "float64"}]}', "'float64'"),
    ('{"op": "setParameters", "parameters": [{"name": "/a", "value": [[]], "type": "float64_array"}]}', "'float"),
    ('{"op": "setParameters", "parameters": [{"name": "/a", "value": 1, "type": "int"}]}', "'int'"),
    ('{"op": "a", "x": ' + "[" * 20 + "]" * 20 + "}", "inside one another"),
    ("[" + "1," * 1000 + "1]", "values and keys"),
)  # fmt: skip


@pytest.mark.promise("with its required fields")
@pytest.mark.parametrize(("text", "words"), WRONG)
def test_wrong_documents(text: str, words: str) -> None:
    """A sentence that says what was expected, of bounded length."""
    with pytest.raises(MessageError, match=words) as problem:
        messages.read(text, READER)
    assert len(str(problem.value)) < 400


def test_binary_messages() -> None:
    """A published message, and a call."""
    assert messages.read(b"\x01\x07\0\0\0data", READER) == messages.Publish(7, b"data")
    call = b"\x02" + struct.pack("<III", 1, 0xFFFFFFFF, 4) + b"ros1data"
    assert messages.read(call, READER) == messages.Call(1, 0xFFFFFFFF, "ros1", b"data")


@pytest.mark.promise("with its required fields")
@pytest.mark.parametrize("whole", [b"\x01\x07\0\0\0", b"\x02" + struct.pack("<III", 1, 2, 4) + b"ros1"])
def test_every_beginning_of_a_binary_message(whole: bytes) -> None:
    """Is none."""
    messages.read(whole, READER)
    for end in range(len(whole)):
        with pytest.raises(MessageError, match="begins with None" if end == 0 else "ends too early"):
            messages.read(whole[:end], READER)


def test_a_binary_message_of_another_kind() -> None:
    """The kinds of the server's are no client's."""
    for kind in (0, 3, 255):
        with pytest.raises(MessageError, match=f"begins with {kind}"):
            messages.read(bytes([kind]) + bytes(50), READER)


# -- what a client is told -----------------------------------------------------------------------------------


def test_offers() -> None:
    """Channels and services with their definitions."""
    channel = AdvertisedChannel(3, "/a", TopicSchema("my_pkg/A", "md5", "int32 x"))
    assert json.loads(messages.advertise([channel])) == {
        "op": "advertise",
        "channels": [
            {
                "id": 3, "topic": "/a", "encoding": "ros1",
                "schemaName": "my_pkg/A", "schemaEncoding": "ros1msg", "schema": "int32 x",
            }
        ],
    }  # fmt: skip
    (service,) = json.loads(messages.advertise_services([AdvertisedService(4, "/set", SetBool)]))["services"]
    assert (service["id"], service["name"], service["type"]) == (4, "/set", "std_srvs/SetBool")
    assert service["request"] == {
        "encoding": "ros1",
        "schemaName": "std_srvs/SetBool_Request",
        "schemaEncoding": "ros1msg",
        "schema": SetBool.Request._full_text,
    }
    assert service["response"]["schema"] == SetBool.Response._full_text
    assert json.loads(messages.unadvertise([3])) == {"op": "unadvertise", "channelIds": [3]}
    assert json.loads(messages.unadvertise_services([4])) == {"op": "unadvertiseServices", "serviceIds": [4]}


def test_server_and_status() -> None:
    """Unknown values are left out."""
    assert json.loads(messages.server_info("me", ["time"], "s1")) == {
        "op": "serverInfo",
        "name": "me",
        "capabilities": ["time"],
        "supportedEncodings": ["json", "ros1"],
        "sessionId": "s1",
    }
    assert json.loads(messages.status("text", Level.ERROR)) == {"op": "status", "level": 2, "message": "text"}
    assert json.loads(messages.status("text", Level.INFO, "m"))["id"] == "m"
    assert json.loads(messages.remove_status("m")) == {"op": "removeStatus", "statusIds": ["m"]}


@pytest.mark.parametrize(
    ("value", "told"),
    [
        (None, {}),
        (5, {"value": 5}),
        (True, {"value": True}),
        (2.0, {"value": 2.0, "type": "float64"}),
        (math.nan, {"value": None, "type": "float64"}),
        ([1.5, math.inf], {"value": [1.5, None], "type": "float64_array"}),
        ([1.5, 2], {"value": [1.5, 2]}),
        ([], {"value": []}),
        (b"ABCD", {"value": "QUJDRA==", "type": "byte_array"}),
        (datetime(2020, 1, 2), {"value": "2020-01-02 00:00:00"}),
        ({"a": [b"b", {"c": math.nan}]}, {"value": {"a": ["b", {"c": None}]}}),
    ],
)
def test_parameters(value: object, told: dict[str, Any]) -> None:
    """With a type where JSON would lose it; NaN has no JSON form."""
    text = messages.parameter_values([("/a", value)], "x")
    assert json.loads(text, parse_constant=lambda word: pytest.fail(word)) == {
        "op": "parameterValues",
        "parameters": [{"name": "/a", **told}],
        "id": "x",
    }
    assert "id" not in json.loads(messages.parameter_values([]))


def test_the_graph() -> None:
    """The whole graph first, then changed and removed entries."""
    first = ConnectionGraph({"/a": ["/n"], "/b": ["/n"]}, {"/b": ["/m"], "/c": ["/m"]}, {"/s": ["/n"]})
    whole = json.loads(messages.graph_update(ConnectionGraph(), first))
    assert whole["publishedTopics"] == [
        {"name": "/a", "publisherIds": ["/n"]},
        {"name": "/b", "publisherIds": ["/n"]},
    ]
    assert whole["advertisedServices"] == [{"name": "/s", "providerIds": ["/n"]}]
    assert (whole["removedTopics"], whole["removedServices"]) == ([], [])
    later = ConnectionGraph({"/a": ["/n", "/m"]}, {"/b": ["/m"]}, {})
    assert json.loads(messages.graph_update(first, later)) == {
        "op": "connectionGraphUpdate",
        "publishedTopics": [
            {"name": "/a", "publisherIds": ["/n", "/m"]},
            {"name": "/b", "publisherIds": []},  # somebody subscribes it still
        ],
        "subscribedTopics": [],
        "advertisedServices": [],
        "removedTopics": ["/c"],
        "removedServices": ["/s"],
    }


def test_binary_answers() -> None:
    """Byte for byte."""
    assert messages.message_head(2, 0x0102030405060708) == bytes.fromhex("01 02000000 0807060504030201")
    assert messages.time(3) == bytes.fromhex("02 0300000000000000")
    asked = messages.Call(5, 6, "ros1", b"")
    answer = bytes.fromhex("03 05000000 06000000 04000000") + b"ros1data"
    assert messages.service_response(asked, b"data") == answer
    failure = {"op": "serviceCallFailure", "serviceId": 5, "callId": 6, "message": "why"}
    assert json.loads(messages.service_failure(asked, "why")) == failure
    assert messages.asset_head(7) == bytes.fromhex("04 07000000 00 00000000")
    assert messages.asset_failure(7, "why") == bytes.fromhex("04 07000000 01 03000000") + b"why"
