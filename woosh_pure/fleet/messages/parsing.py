"""Parse orders and instant actions from JSON. Pure.

The tables list the fields of chapters 6.6.6 and 6.9 with the kind of their values; `!` marks required fields.
Unknown fields are ignored, as by the schemas of the standard. Version 2.1 only adds fields to 2.0, so one
table serves both.

A message that does not fit its table raises `Invalid` with the field, the expected and the received value. So
does an order with a wrong structure (6.6.1, 6.6.2): there must be one edge fewer than nodes, each between its
two nodes; sequence ids count up by one over nodes and edges; the first node is released, and nothing after an
unreleased element is; each actionId is unique. `order/rejection.py` rejects well-formed orders that cannot be
obeyed.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping
from datetime import datetime, timezone
from typing import Any

from rosproto.text import printable, short
from woosh_pure.fleet.messages.elements import Action, Edge, InstantActions, Node, NodePosition, Order

MOST_BYTES = 1_000_000
"""Largest message; `msgLen` of the factsheet."""
MOST_NODES = 1000
MOST_ACTIONS = 100  # of a node, an edge, or a message of instant actions
MOST_PARAMETERS = 100
LONGEST_ID = 256
_LONGEST_TEXT = 4096
_UINT32 = 2**32 - 1
_PI = math.pi + 1e-6


class Invalid(ValueError):
    """A message does not fit its schema.

    Attributes:
        path: The field, such as "nodes[1].nodePosition.x"; "" for the message itself.
        expected: The expected value.
        got: The received value, shortened.
    """

    def __init__(self, path: str, expected: str, got: object) -> None:
        self.path, self.expected = path, expected
        self.got = short(printable(got if isinstance(got, str) else repr(got)), 120)
        super().__init__(f"{path or 'the message'}: expected {expected}, got {self.got}")


ACTION = {
    "actionType": "id!", "actionId": "id!", "actionDescription": "text", "blockingType": "blocking!",
    "actionParameters": "parameters",
}  # fmt: skip
POSITION = {
    "x": "number!", "y": "number!", "theta": "angle", "allowedDeviationXY": "positive",
    "allowedDeviationXy": "positive", "allowedDeviationTheta": "angle", "mapId": "id!",
    "mapDescription": "text",
}  # fmt: skip
NODE = {
    "nodeId": "id!", "sequenceId": "whole!", "nodeDescription": "text", "released": "flag!",
    "nodePosition": "position", "actions": "actions!",
}  # fmt: skip
EDGE = {
    "edgeId": "id!", "sequenceId": "whole!", "edgeDescription": "text", "released": "flag!",
    "startNodeId": "id!", "endNodeId": "id!", "maxSpeed": "number", "maxHeight": "number",
    "minHeight": "number", "orientation": "angle", "orientationType": "orientation type", "direction":
    "text", "rotationAllowed": "flag", "maxRotationSpeed": "number", "length": "number", "trajectory":
    "object", "corridor": "object", "actions": "actions!",
}  # fmt: skip
HEADER = {
    "headerId": "whole!", "timestamp": "text!", "version": "text!", "manufacturer": "text!",
    "serialNumber": "text!",
}  # fmt: skip
ORDER = {
    **HEADER, "orderId": "id!", "orderUpdateId": "whole!", "zoneSetId": "text", "nodes": "list!",
    "edges": "list!",
}  # fmt: skip
INSTANT_ACTIONS = {**HEADER, "actions": "list!"}
PARAMETER = {"key": "id!", "value": "value!"}


def check(raw: Any, table: Mapping[str, str], path: str) -> None:
    """Raise `Invalid` for the first field that does not fit."""
    if not isinstance(raw, dict):
        raise Invalid(path, "an object", raw)
    for key, kind in table.items():
        if key not in raw and not kind.endswith("!"):
            continue
        where = f"{path}.{key}" if path else key
        fits, words = _KINDS[kind.rstrip("!")]
        require(key in raw and fits(raw[key]), where, words, raw.get(key, "nothing"))
        if kind == "position":
            check(raw[key], POSITION, where)
        elif kind == "parameters":
            for n, each in enumerate(raw[key]):
                check(each, PARAMETER, f"{where}[{n}]")


def require(fits: bool, path: str, expected: str, got: object) -> None:
    """Raise `Invalid` unless `fits`."""
    if not fits:
        raise Invalid(path, expected, got)


def _is_number(value: Any) -> bool:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return abs(value) <= 1e300 and math.isfinite(value)


_KINDS: dict[str, tuple[Callable[[Any], bool], str]] = {
    "id": (
        lambda v: isinstance(v, str) and len(v) <= LONGEST_ID,
        f"a text of at most {LONGEST_ID} characters",
    ),
    "text": (
        lambda v: isinstance(v, str) and len(v) <= _LONGEST_TEXT,
        f"a text of at most {_LONGEST_TEXT} characters",
    ),
    "number": (_is_number, "a number"),
    "positive": (lambda v: _is_number(v) and v >= 0.0, "a number of at least 0"),
    "angle": (lambda v: _is_number(v) and abs(v) <= _PI, "an angle of -pi to pi"),
    "whole": (
        lambda v: _is_number(v) and float(v).is_integer() and 0 <= v <= _UINT32,
        f"a whole number of 0 to {_UINT32}",
    ),
    "flag": (lambda v: isinstance(v, bool), "true or false"),
    "list": (lambda v: isinstance(v, list), "a list"),
    "actions": (lambda v: isinstance(v, list), "a list of actions"),
    "parameters": (lambda v: isinstance(v, list) and len(v) <= MOST_PARAMETERS, "a list of parameters"),
    "object": (lambda v: isinstance(v, dict), "an object"),
    "position": (lambda v: isinstance(v, dict), "an object"),
    "value": (
        lambda v: isinstance(v, (bool, str, list, dict)) or _is_number(v),
        "a list, an object, a text, a number, true or false",
    ),
    "blocking": (lambda v: v in ("NONE", "SOFT", "HARD"), "NONE, SOFT or HARD"),
    "orientation type": (lambda v: v in ("GLOBAL", "TANGENTIAL"), "GLOBAL or TANGENTIAL"),
}
"""By the kind of a field: a check of its value, and the expected value in words."""


def check_header(data: Mapping[str, Any], *, version: str, manufacturer: str, serial: str) -> None:
    """Check that a message is for this vehicle and has a supported version.

    Args:
        data: The message.
        version: The vehicle's version of the protocol; messages may have any version with the same major
            number.
        manufacturer, serial: The vehicle.

    Raises:
        Invalid: The message is for another vehicle or has another major version; the path names the field.
    """
    check(data, HEADER, "")
    major = version.partition(".")[0]
    given = data["version"]
    require(given.partition(".")[0] == major, "version", f"a version {major}", given)
    for key, ours in (("manufacturer", manufacturer), ("serialNumber", serial)):
        require(data[key] == ours, key, f"{ours}: this vehicle", data[key])


def timestamp(seconds: float) -> str:
    """Format seconds since 1970 for a message: ISO 8601, UTC, with hundredths and a Z."""
    return datetime.fromtimestamp(seconds, timezone.utc).isoformat(timespec="milliseconds")[:22] + "Z"


# -- reading -------------------------------------------------------------------------------------------------


def parse(payload: bytes | str) -> dict[str, Any]:
    """The JSON object of a message; raises `Invalid` for anything else."""
    if len(payload) > MOST_BYTES:
        raise Invalid("", f"at most {MOST_BYTES} bytes", f"{len(payload)} bytes")
    try:
        found = json.loads(payload, parse_constant=_no_constant, object_pairs_hook=_each_key_once)
    except (ValueError, RecursionError) as error:
        raise Invalid("", "a JSON object in UTF-8", str(error) or type(error).__name__) from None
    if not isinstance(found, dict):
        raise Invalid("", "a JSON object", found)
    return found


def _each_key_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A JSON object; repeated keys are an error, because it is not clear which value is meant."""
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError(f"the key {_first_repeated(key for key, _ in pairs)!r} comes twice in one object")
    return found


def _first_repeated(keys: Iterable[str]) -> str | None:
    """The first key that repeats an earlier one; None if all differ."""
    seen: set[str] = set()
    for key in keys:
        if key in seen:
            return key
        seen.add(key)
    return None


def _no_constant(text: str) -> float:
    raise ValueError(f"{text} is no number of JSON")


def read_order(data: Mapping[str, Any]) -> Order:
    """Read an order.

    Raises:
        Invalid: The object does not fit the table, or has the wrong structure.
    """
    check(data, ORDER, "")
    nodes = tuple(
        read_node(raw, f"nodes[{n}]") for n, raw in enumerate(_bounded(data, "nodes", MOST_NODES, ""))
    )
    edges = tuple(
        read_edge(raw, f"edges[{n}]") for n, raw in enumerate(_bounded(data, "edges", MOST_NODES, ""))
    )
    order = Order(
        data["orderId"],
        int(data["orderUpdateId"]),
        nodes,
        edges,
        data.get("zoneSetId", ""),
        int(data["headerId"]),
    )
    _require_shape(order)
    return order


def read_instant_actions(data: Mapping[str, Any]) -> InstantActions:
    """Read instant actions; the name of version 1 is accepted, too.

    Raises:
        Invalid: The object does not fit the table.
    """
    if "actions" not in data and "instantActions" in data:
        data = {**data, "actions": data["instantActions"]}
    check(data, INSTANT_ACTIONS, "")
    raw = _bounded(data, "actions", MOST_ACTIONS, "")
    return InstantActions(
        tuple(read_action(each, f"actions[{n}]") for n, each in enumerate(raw)), int(data["headerId"])
    )


def read_node(raw: Any, path: str) -> Node:
    """Read a node; `path` is its place in the message, for errors."""
    check(raw, NODE, path)
    position = raw.get("nodePosition")
    return Node(
        raw["nodeId"],
        int(raw["sequenceId"]),
        raw["released"],
        None if position is None else _position(position),
        _actions(raw, path),
        raw.get("nodeDescription", ""),
    )


def _position(raw: Mapping[str, Any]) -> NodePosition:
    radius = raw.get("allowedDeviationXY", raw.get("allowedDeviationXy", 0.0))
    turn, theta = raw.get("allowedDeviationTheta"), raw.get("theta")
    return NodePosition(
        float(raw["x"]),
        float(raw["y"]),
        None if theta is None else float(theta),
        raw["mapId"],
        float(radius),
        None if turn is None else abs(float(turn)),
    )


_PLAIN = ("edgeId", "sequenceId", "released", "startNodeId", "endNodeId", "actions")


def read_edge(raw: Any, path: str) -> Edge:
    """Read an edge; `path` is its place in the message, for errors."""
    check(raw, EDGE, path)
    options = {key: raw[key] for key in EDGE if key in raw and key not in _PLAIN}
    return Edge(
        raw["edgeId"], int(raw["sequenceId"]), raw["released"], raw["startNodeId"], raw["endNodeId"], options,
        _actions(raw, path),
    )  # fmt: skip


def _actions(raw: Mapping[str, Any], path: str) -> tuple[Action, ...]:
    found = _bounded(raw, "actions", MOST_ACTIONS, path)
    return tuple(read_action(each, f"{path}.actions[{n}]") for n, each in enumerate(found))


def read_action(raw: Any, path: str) -> Action:
    """Read an action; `path` is its place in the message, for errors."""
    check(raw, ACTION, path)
    given = raw.get("actionParameters", ())
    parameters = {each["key"]: each["value"] for each in given}
    if len(parameters) < len(given):
        twice = _first_repeated(each["key"] for each in given)
        raise Invalid(f"{path}.actionParameters", "each key once", f"{twice} more than once")
    return Action(
        raw["actionId"], raw["actionType"], raw["blockingType"], parameters, raw.get("actionDescription", "")
    )


def _bounded(raw: Mapping[str, Any], key: str, most: int, path: str) -> list[Any]:
    found: list[Any] = raw[key]
    if len(found) > most:
        raise Invalid(f"{path}.{key}".lstrip("."), f"at most {most} of them", f"{len(found)}")
    return found


def _require_shape(order: Order) -> None:
    nodes, edges = order.nodes, order.edges
    require(bool(nodes), "nodes", "at least one node", "none")
    require(
        len(edges) == len(nodes) - 1, "edges", f"{len(nodes) - 1} edges for {len(nodes)} nodes", len(edges)
    )
    require(nodes[0].released, "nodes[0].released", "true: the first node is part of the base", False)
    before: Node | Edge = nodes[0]
    for n, (edge, node) in enumerate(zip(edges, nodes[1:], strict=True)):
        ends = (edge.start, edge.end)
        require(ends == (nodes[n].id, node.id), f"edges[{n}]", f"from {nodes[n].id} to {node.id}", ends)
        elements: tuple[tuple[str, Node | Edge], ...] = ((f"edges[{n}]", edge), (f"nodes[{n + 1}]", node))
        for path, each in elements:
            wanted = before.sequence + 1
            require(each.sequence == wanted, f"{path}.sequenceId", f"{wanted}: it counts on", each.sequence)
            behind = f"{path}.released"
            require(before.released or not each.released, behind, "false behind what is not released", True)
            before = each
        # An edge is released with both of its nodes (6.6.1), and a node is reached over its edge.
        require(
            edge.released == node.released, f"edges[{n}].released", "as that of its end node", edge.released
        )
    repeated = _first_repeated(action.id for action in order.actions())
    require(repeated is None, "actions", "each actionId once", repeated)
