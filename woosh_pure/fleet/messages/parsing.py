"""What a fleet manager sends, as values: orders and instant actions, checked by our own table of fields.
Pure.

The tables name each field of chapters 6.6.6 and 6.9 with its type; `!` marks those that must be there. A
message that does not fit raises `Invalid`, which says where, what was expected and what came. Fields that
the table does not know are let pass, as the standard's schemas do. Versions 2.0 and 2.1 differ by what the
later one added: both are read by one table, and what the vehicle cannot obey is for `order` to reject.

Besides types, the shape of an order is checked here, because an order that breaks it is malformed (6.6.1,
6.6.2): one edge fewer than nodes, each between its nodes; sequence ids that count up by one over nodes and
edges; the first node released; nothing released behind what is not; no action twice.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from rosproto.text import printable

__all__ = [
    "Action",
    "Edge",
    "InstantActions",
    "Invalid",
    "Node",
    "Order",
    "Position",
    "parse",
    "read_edge",
    "read_instant_actions",
    "read_node",
    "read_order",
]

MOST_BYTES = 1_000_000
"""Of one message; told in the factsheet as `msgLen`."""
MOST_NODES = 1000
MOST_ACTIONS = 100  # of one node or edge, or of one message of instant actions
MOST_PARAMETERS = 100
LONGEST_ID = 256
_LONGEST_TEXT = 4096
_UINT32 = 2**32 - 1
_PI = math.pi + 1e-6


class Invalid(ValueError):
    """A message does not fit its schema.

    Attributes:
        path: Where, such as "nodes[1].nodePosition.x"; "" for the message itself.
        expected: What belongs there.
        got: What came, shortened.
    """

    def __init__(self, path: str, expected: str, got: object) -> None:
        self.path, self.expected = path, expected
        self.got = printable(got if isinstance(got, str) else repr(got))[:120]
        super().__init__(f"{path or 'the message'}: expected {expected}, got {self.got}")


MISSING = "nothing"

# -- the tables: kind of the value; "!" it must be there -----------------------------------------------------

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


@dataclass(frozen=True, slots=True)
class Action:
    """An action of a node, an edge, or an instant one.

    Attributes:
        id, type: `actionId`, `actionType`.
        blocking: NONE, SOFT or HARD.
        parameters: By key.
        description: Free text.
    """

    id: str
    type: str
    blocking: str = "NONE"
    parameters: Mapping[str, Any] = field(default_factory=dict)
    description: str = ""

    def to_json(self) -> dict[str, Any]:
        """As an order has it."""
        found: dict[str, Any] = {"actionType": self.type, "actionId": self.id, "blockingType": self.blocking}
        if self.description:
            found["actionDescription"] = self.description
        found["actionParameters"] = [{"key": key, "value": value} for key, value in self.parameters.items()]
        return found


@dataclass(frozen=True, slots=True)
class Position:
    """Where a node is: m and rad in the map.

    Attributes:
        deviation_xy: Radius in m within which the node counts as reached; 0 is the vehicle's own tolerance.
        deviation_theta: rad; None is the vehicle's own tolerance.
    """

    x: float
    y: float
    theta: float | None
    map_id: str
    deviation_xy: float = 0.0
    deviation_theta: float | None = None

    def to_json(self) -> dict[str, Any]:
        """As an order has it."""
        found: dict[str, Any] = {"x": self.x, "y": self.y, "mapId": self.map_id}
        if self.theta is not None:
            found["theta"] = self.theta
        if self.deviation_xy:
            found["allowedDeviationXY"] = self.deviation_xy
        if self.deviation_theta is not None:
            found["allowedDeviationTheta"] = self.deviation_theta
        return found


@dataclass(frozen=True, slots=True)
class Node:
    """A place to drive to."""

    id: str
    sequence: int
    released: bool
    position: Position | None = None
    actions: tuple[Action, ...] = ()
    description: str = ""

    def to_json(self) -> dict[str, Any]:
        """As an order has it."""
        found: dict[str, Any] = {"nodeId": self.id, "sequenceId": self.sequence, "released": self.released}
        if self.description:
            found["nodeDescription"] = self.description
        if self.position is not None:
            found["nodePosition"] = self.position.to_json()
        found["actions"] = [action.to_json() for action in self.actions]
        return found


@dataclass(frozen=True, slots=True)
class Edge:
    """The way between two nodes.

    Attributes:
        options: What else was given of it (maxSpeed, orientation, trajectory ...), by the names of the
            standard.
    """

    id: str
    sequence: int
    released: bool
    start: str
    end: str
    options: Mapping[str, Any] = field(default_factory=dict)
    actions: tuple[Action, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """As an order has it."""
        return {
            "edgeId": self.id, "sequenceId": self.sequence, "released": self.released,
            "startNodeId": self.start, "endNodeId": self.end, **self.options,
            "actions": [action.to_json() for action in self.actions],
        }  # fmt: skip


@dataclass(frozen=True, slots=True)
class Order:
    """An order or an update of one; well formed."""

    id: str
    update: int
    nodes: tuple[Node, ...]
    edges: tuple[Edge, ...] = ()
    zone_set: str = ""
    header: int = 0

    def actions(self) -> Iterator[Action]:
        """Of all nodes and edges."""
        elements: tuple[Node | Edge, ...] = (*self.nodes, *self.edges)
        for element in elements:
            yield from element.actions


@dataclass(frozen=True, slots=True)
class InstantActions:
    """Actions to be done at once."""

    actions: tuple[Action, ...]
    header: int = 0


def parse(payload: bytes | str) -> dict[str, Any]:
    """A message's JSON object; anything else is `Invalid`."""
    if len(payload) > MOST_BYTES:
        raise Invalid("", f"at most {MOST_BYTES} bytes", f"{len(payload)} bytes")
    try:
        found = json.loads(payload, parse_constant=_no_constant)
    except (ValueError, RecursionError) as error:
        raise Invalid("", "a JSON object in UTF-8", str(error) or type(error).__name__) from None
    if not isinstance(found, dict):
        raise Invalid("", "a JSON object", found)
    return found


def _no_constant(text: str) -> float:
    raise ValueError(f"{text} is no number of JSON")


def read_order(data: Mapping[str, Any]) -> Order:
    """An order out of its JSON object.

    Raises:
        Invalid: It does not fit the table, or the shape of an order.
    """
    _check(data, ORDER, "")
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
    """Instant actions out of their JSON object; also under the name that version 1 gave them.

    Raises:
        Invalid: It does not fit the table.
    """
    if "actions" not in data and "instantActions" in data:
        data = {**data, "actions": data["instantActions"]}
    _check(data, INSTANT_ACTIONS, "")
    raw = _bounded(data, "actions", MOST_ACTIONS, "")
    return InstantActions(
        tuple(_action(each, f"actions[{n}]") for n, each in enumerate(raw)), int(data["headerId"])
    )


def read_node(raw: Any, path: str) -> Node:
    """A node out of its JSON object."""
    _check(raw, NODE, path)
    position = raw.get("nodePosition")
    return Node(
        raw["nodeId"],
        int(raw["sequenceId"]),
        raw["released"],
        None if position is None else _position(position),
        _actions(raw, path),
        raw.get("nodeDescription", ""),
    )


def _position(raw: Mapping[str, Any]) -> Position:
    radius = raw.get("allowedDeviationXY", raw.get("allowedDeviationXy", 0.0))
    turn, theta = raw.get("allowedDeviationTheta"), raw.get("theta")
    return Position(
        float(raw["x"]),
        float(raw["y"]),
        None if theta is None else float(theta),
        raw["mapId"],
        float(radius),
        None if turn is None else abs(float(turn)),
    )


_PLAIN = ("edgeId", "sequenceId", "released", "startNodeId", "endNodeId", "actions")


def read_edge(raw: Any, path: str) -> Edge:
    """An edge out of its JSON object."""
    _check(raw, EDGE, path)
    options = {key: raw[key] for key in EDGE if key in raw and key not in _PLAIN}
    return Edge(
        raw["edgeId"], int(raw["sequenceId"]), raw["released"], raw["startNodeId"], raw["endNodeId"], options,
        _actions(raw, path),
    )  # fmt: skip


def _actions(raw: Mapping[str, Any], path: str) -> tuple[Action, ...]:
    found = _bounded(raw, "actions", MOST_ACTIONS, path)
    return tuple(_action(each, f"{path}.actions[{n}]") for n, each in enumerate(found))


def _action(raw: Any, path: str) -> Action:
    _check(raw, ACTION, path)
    parameters = {each["key"]: each["value"] for each in raw.get("actionParameters", ())}
    return Action(
        raw["actionId"], raw["actionType"], raw["blockingType"], parameters, raw.get("actionDescription", "")
    )


def _bounded(raw: Mapping[str, Any], key: str, most: int, path: str) -> list[Any]:
    found: list[Any] = raw[key]
    if len(found) > most:
        raise Invalid(f"{path}.{key}".lstrip("."), f"at most {most} of them", f"{len(found)}")
    return found


# -- the kinds of values -------------------------------------------------------------------------------------


def _check(raw: Any, table: Mapping[str, str], path: str) -> None:
    """Raise `Invalid` for the first field that does not fit."""
    if not isinstance(raw, dict):
        raise Invalid(path, "an object", raw)
    for key, kind in table.items():
        where = f"{path}.{key}" if path else key
        if key in raw:
            _check_value(raw[key], kind.rstrip("!"), where)
        elif kind.endswith("!"):
            raise Invalid(where, _WORDS.get(kind[:-1], kind[:-1]), MISSING)


def _check_value(value: Any, kind: str, path: str) -> None:
    if kind == "position":
        _check(value, POSITION, path)
    elif kind == "parameters":
        _require(
            isinstance(value, list) and len(value) <= MOST_PARAMETERS, path, "a list of parameters", value
        )
        for n, each in enumerate(value):
            _check(each, PARAMETER, f"{path}[{n}]")
    else:
        _require(_FITS[kind](value), path, _WORDS[kind], value)


def _require(fits: bool, path: str, expected: str, got: object) -> None:
    if not fits:
        raise Invalid(path, expected, got)


def _is_number(value: Any) -> bool:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return abs(value) <= 1e300 and math.isfinite(value)


def _is_whole(value: Any) -> bool:
    return _is_number(value) and float(value).is_integer() and 0 <= value <= _UINT32


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and len(value) <= _LONGEST_TEXT


_FITS: dict[str, Any] = {
    "id": lambda v: isinstance(v, str) and len(v) <= LONGEST_ID,
    "text": _is_text,
    "number": _is_number,
    "positive": lambda v: _is_number(v) and v >= 0.0,
    "angle": lambda v: _is_number(v) and abs(v) <= _PI,
    "whole": _is_whole,
    "flag": lambda v: isinstance(v, bool),
    "list": lambda v: isinstance(v, list),
    "actions": lambda v: isinstance(v, list),
    "object": lambda v: isinstance(v, dict),
    "value": lambda v: isinstance(v, (bool, str, list, dict)) or _is_number(v),
    "blocking": lambda v: v in ("NONE", "SOFT", "HARD"),
    "orientation type": lambda v: v in ("GLOBAL", "TANGENTIAL"),
}
_WORDS = {
    "id": f"a text of at most {LONGEST_ID} characters",
    "text": f"a text of at most {_LONGEST_TEXT} characters",
    "number": "a number",
    "positive": "a number of at least 0",
    "angle": "an angle of -pi to pi",
    "whole": "a whole number of 0 to 4294967295",
    "flag": "true or false",
    "list": "a list",
    "actions": "a list of actions",
    "object": "an object",
    "value": "a list, an object, a text, a number, true or false",
    "blocking": "NONE, SOFT or HARD",
    "orientation type": "GLOBAL or TANGENTIAL",
    "position": "a position",
    "parameters": "a list of parameters",
}


# -- the shape of an order -----------------------------------------------------------------------------------


def _require_shape(order: Order) -> None:
    nodes, edges = order.nodes, order.edges
    _require(bool(nodes), "nodes", "at least one node", "none")
    _require(
        len(edges) == len(nodes) - 1, "edges", f"{len(nodes) - 1} edges for {len(nodes)} nodes", len(edges)
    )
    _require(nodes[0].released, "nodes[0].released", "true: the first node is part of the base", False)
    before: Node | Edge = nodes[0]
    for n, (edge, node) in enumerate(zip(edges, nodes[1:], strict=True)):
        ends = (edge.start, edge.end)
        _require(ends == (nodes[n].id, node.id), f"edges[{n}]", f"from {nodes[n].id} to {node.id}", ends)
        elements: tuple[tuple[str, Node | Edge], ...] = ((f"edges[{n}]", edge), (f"nodes[{n + 1}]", node))
        for path, each in elements:
            wanted = before.sequence + 1
            _require(each.sequence == wanted, f"{path}.sequenceId", f"{wanted}: it counts on", each.sequence)
            behind = f"{path}.released"
            _require(before.released or not each.released, behind, "false behind what is not released", True)
            before = each
        # An edge is released with both of its nodes (6.6.1), and a node is reached over its edge.
        _require(
            edge.released == node.released, f"edges[{n}].released", "as that of its end node", edge.released
        )
    seen: set[str] = set()
    for action in order.actions():
        _require(action.id not in seen, "actions", "each actionId once", action.id)
        seen.add(action.id)
