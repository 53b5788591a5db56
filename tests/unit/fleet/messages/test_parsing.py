"""Messages of a fleet manager: valid ones are read, the wrong field of others is named by its path."""

from __future__ import annotations

import json
import time
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.fleet import action, instant, order_json
from woosh_pure.fleet.messages.parsing import (
    MAX_MESSAGE_BYTES,
    Invalid,
    check_header,
    parse,
    read_instant_actions,
    read_order,
    timestamp,
)
from woosh_pure.fleet.published_messages import MessageHeaders


def changed(path: str, value: Any) -> dict[str, Any]:
    """An order with one field changed, or taken out where the value is ..."""
    data = order_json(nodes="ab", node_actions={"a": [action("x", times=1)]})
    *way, last = path.split(".")
    at: Any = data
    for step in way:
        at = at[int(step)] if step.isdigit() else at[step]
    key: Any = int(last) if last.isdigit() else last
    if value is ...:
        del at[key]
    else:
        at[key] = value
    return data


def test_an_order_is_read_with_all_its_parts() -> None:
    """Nodes, edges, actions and their parameters."""
    order = read_order(
        order_json(nodes="ab", update=4, node_actions={"b": [action("x", "pick", "HARD", height=1.5)]})
    )
    assert (order.id, order.update, order.header) == ("o", 4, 7)
    assert [node.sequence for node in order.nodes] == [0, 2]
    assert order.edges[0].start == "a"
    (found,) = order.nodes[1].actions
    assert (found.id, found.type, found.blocking, dict(found.parameters)) == (
        "x",
        "pick",
        "HARD",
        {"height": 1.5},
    )


@pytest.mark.parametrize("name", ["allowedDeviationXY", "allowedDeviationXy"])
def test_both_spellings_of_the_range_are_read(name: str) -> None:
    """The schema of 2.0 writes it differently from its text, and from 2.1."""
    data = order_json(nodes="a")
    del data["nodes"][0]["nodePosition"]["allowedDeviationXY"]
    data["nodes"][0]["nodePosition"][name] = 0.7
    position = read_order(data).nodes[0].position
    assert position is not None
    assert position.deviation_xy == 0.7


@pytest.mark.parametrize(
    ("path", "value", "where"),
    [
        ("orderId", ..., "orderId"),
        ("orderId", 7, "orderId"),
        ("orderId", "x" * 300, "orderId"),
        ("orderUpdateId", -1, "orderUpdateId"),
        ("orderUpdateId", 1.5, "orderUpdateId"),
        ("orderUpdateId", 2**32, "orderUpdateId"),
        ("orderUpdateId", True, "orderUpdateId"),
        ("headerId", None, "headerId"),
        ("timestamp", ..., "timestamp"),
        ("nodes", {}, "nodes"),
        ("nodes", [], "nodes"),
        ("nodes.0", "a", "nodes[0]"),
        ("nodes.0.released", 1, "nodes[0].released"),
        ("nodes.0.released", False, "nodes[0].released"),
        ("nodes.1.sequenceId", 3, "nodes[1].sequenceId"),
        ("nodes.1.released", False, "edges[0].released"),
        ("edges.0.released", False, "nodes[1].released"),
        ("edges.0.endNodeId", "q", "edges[0]"),
        ("edges", [], "edges"),
        ("nodes.0.nodePosition.x", "1", "nodes[0].nodePosition.x"),
        ("nodes.0.nodePosition.x", float("inf"), "nodes[0].nodePosition.x"),
        ("nodes.0.nodePosition.x", 10**400, "nodes[0].nodePosition.x"),
        ("nodes.0.nodePosition.theta", 4.0, "nodes[0].nodePosition.theta"),
        ("nodes.0.nodePosition.mapId", ..., "nodes[0].nodePosition.mapId"),
        ("nodes.0.nodePosition.allowedDeviationXY", -0.1, "nodes[0].nodePosition.allowedDeviationXY"),
        ("nodes.0.actions", ..., "nodes[0].actions"),
        ("nodes.0.actions.0.blockingType", "soft", "nodes[0].actions[0].blockingType"),
        ("nodes.0.actions.0.blockingType", ["SOFT"], "nodes[0].actions[0].blockingType"),
        ("nodes.0.actions.0.actionParameters.0.value", None, "nodes[0].actions[0].actionParameters[0].value"),
        ("nodes.1.actions", [action("x")], "actions"),
    ],
)
def test_what_does_not_fit_is_named(path: str, value: Any, where: str) -> None:
    """Path, what was expected and what came."""
    with pytest.raises(Invalid) as caught:
        read_order(changed(path, value))
    assert caught.value.path == where
    assert caught.value.expected


@pytest.mark.promise("64 messages that stop, 32 of other instant actions, 8 orders, 8 invalid")
@pytest.mark.parametrize(
    "text",
    [
        b"",
        b"[]",
        b"3",
        b'{"a": NaN}',
        b"\xff{}",
        b"{" * 50_000,
        b'{"a": ' * 5000,
        b"{" + b" " * MAX_MESSAGE_BYTES + b"}",
    ],
)
def test_what_is_no_object_of_json_is_invalid(text: bytes) -> None:
    """Of no length, of any depth, in any encoding: an error, never a crash."""
    with pytest.raises(Invalid):
        parse(text)


@pytest.mark.promise("serial number or major version, or with a key twice, is refused")
def test_a_key_that_comes_twice_is_invalid() -> None:
    """The last one would decide: `"released": false, "released": true` would drive."""
    text = json.dumps(order_json(nodes="ab", released=1))
    parse(text)
    twice = text.replace('"released": false', '"released": false, "released": true', 1)
    with pytest.raises(Invalid, match="'released' comes twice"):
        parse(twice)


def test_a_long_object_with_a_key_twice_is_refused_in_its_turn() -> None:
    """The search for the key takes a time that grows with the number of keys, and not with its square."""
    pairs = ",".join(f'"k{n}": 0' for n in range(50_000))
    with pytest.raises(Invalid, match="'k0' comes twice"):
        parse(f'{{{pairs}, "k0": 1}}')


def test_a_parameter_that_comes_twice_is_invalid() -> None:
    """As a key of the object would be."""
    data = instant(action("x", "beep", times=1))
    given = data["actions"][0]["actionParameters"]
    given.append({"key": "times", "value": 2})
    with pytest.raises(Invalid, match="times more than once") as caught:
        read_instant_actions(data)
    assert caught.value.path == "actions[0].actionParameters"


@pytest.mark.promise("serial number or major version, or with a key twice, is refused")
@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("manufacturer", "Other"),
        ("manufacturer", "w"),
        ("serialNumber", "2"),
        ("version", "3.0.0"),
        ("version", "1.1"),
        ("version", "20.1.0"),
        ("version", ""),
        ("version", "newest"),
    ],
)
def test_a_message_for_somebody_else_is_invalid(field: str, value: str) -> None:
    """Another manufacturer, serial number or major version; the field is named."""
    ours = {"version": "2.1.0", "manufacturer": "W", "serial": "1"}
    check_header({**order_json(), "version": "2.0.0"}, **ours)
    with pytest.raises(Invalid) as caught:
        check_header({**order_json(), field: value}, **ours)
    assert caught.value.path == field


@pytest.mark.promise("64 messages that stop, 32 of other instant actions, 8 orders, 8 invalid")
def test_an_order_of_too_many_nodes_is_invalid() -> None:
    """The factsheet has these limits."""
    data = order_json(nodes="a")
    data["nodes"] *= 1001
    with pytest.raises(Invalid, match="at most 1000"):
        read_order(data)


def test_unknown_fields_are_let_pass() -> None:
    """As the schemas of the standard do."""
    assert read_order({**order_json(), "vendor": {"x": 1}}).id == "o"


def test_instant_actions_are_read() -> None:
    """Under the name of version 2, and of version 1."""
    data = instant(action("x", "startPause"))
    assert read_instant_actions(data).actions[0].type == "startPause"
    data["instantActions"] = data.pop("actions")
    assert read_instant_actions(data).actions[0].type == "startPause"
    with pytest.raises(Invalid, match="actions"):
        read_instant_actions({**data, "instantActions": "x"})


values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=8,
)
PATHS = ["orderId", "orderUpdateId", "nodes", "edges", "nodes.0", "edges.0", "nodes.0.nodePosition", "nodes.0.actions",
         "nodes.0.actions.0", "nodes.0.actions.0.actionParameters", "edges.0.orientation", "zoneSetId"]  # fmt: skip


@pytest.mark.promise("is answered with `validationError` and changes nothing")
@settings(max_examples=100, deadline=None)
@given(st.sampled_from(PATHS), values)
def test_any_value_at_any_place_is_read_or_invalid(path: str, value: Any) -> None:
    """Nothing else is raised."""
    try:
        order = read_order(changed(path, value))
    except Invalid:
        return
    assert json.dumps([node.to_json() for node in order.nodes])


def test_header_ids_count_for_each_topic() -> None:
    """By one with each message, and begin anew behind a uint32."""
    headers = MessageHeaders("2.1.0", "Woosh", "A-17")
    assert [headers.header("state")["headerId"] for _ in range(3)] == [0, 1, 2]
    before = timestamp(time.time())
    first = headers.header("connection")
    assert before <= first.pop("timestamp") <= timestamp(time.time())
    assert first == {
        "headerId": 0, "version": "2.1.0", "manufacturer": "Woosh", "serialNumber": "A-17",
    }  # fmt: skip
    headers._next["state"] = 2**32 - 1
    assert headers.header("state")["headerId"] == 2**32 - 1
    assert headers.header("state")["headerId"] == 0
    assert timestamp(1492256403.1299) == "2017-04-15T11:40:03.12Z"
