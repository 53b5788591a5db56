"""Orders and instant actions as values: Order, Node, Edge, Action (6.6.6, 6.9). Pure.

The annotations of the fields have the checks of their JSON values, see `rosproto.json_fields`. Version 2.1
only adds fields to 2.0, so one class serves both.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, NamedTuple

from rosproto.json_fields import (
    REQUIRED,
    Check,
    FieldError,
    Reader,
    fits,
    flag,
    listed,
    number,
    one_of,
    whole,
)

MAX_NODES = 1000
MAX_ACTIONS = 100  # of a node, an edge, or a message of instant actions
MAX_PARAMETERS = 100
MAX_ID_CHARACTERS = 256
_MAX_TEXT_CHARACTERS = 4096
_UINT32 = 2**32 - 1
_PI = math.pi + 1e-6
_MAX_NUMBER = 1e300


def _text(limit: int) -> Check[object]:
    return fits(lambda v, _: isinstance(v, str) and len(v) <= limit, f"a text of at most {limit} characters")


def _is_value(value: object, _max_characters: int) -> bool:
    return isinstance(value, (str, list, dict)) or (
        isinstance(value, (int, float)) and abs(value) <= _MAX_NUMBER
    )


_angle = number(-_PI, _PI, "an angle of -pi to pi")
_blocking = one_of(("NONE", "SOFT", "HARD"), "NONE, SOFT or HARD")
_orientation_type = one_of(("GLOBAL", "TANGENTIAL"), "GLOBAL or TANGENTIAL")
_object = fits(lambda value, _: isinstance(value, dict), "an object")
Id = Annotated[str, _text(MAX_ID_CHARACTERS)]
Text = Annotated[str, _text(_MAX_TEXT_CHARACTERS)]
Flag = Annotated[bool, flag]
Count = Annotated[int, whole(0, _UINT32, f"a whole number of 0 to {_UINT32}")]
Number = Annotated[float, number(-_MAX_NUMBER, _MAX_NUMBER)]
Distance = Annotated[float, number(0.0, _MAX_NUMBER, "a number of at least 0")]
Angle = Annotated[float, _angle]
Value = Annotated[Any, fits(_is_value, "a list, an object, a text, a number, true or false")]


class Header(NamedTuple):
    """The header of each message."""

    header: Annotated[Count, "headerId"]
    timestamp: Text
    version: Text
    manufacturer: Text
    serial: Annotated[Text, "serialNumber"]


class _Parameter(NamedTuple):
    key: Id
    value: Value


_read_parameters = listed(Reader(_Parameter, null=True), MAX_PARAMETERS, "a list of parameters")


def _parameters(value: object, max_characters: int) -> dict[str, object]:
    given = _read_parameters(value, max_characters)
    repeated = first_repeated(each.key for each in given)
    if repeated is not None:
        raise FieldError("", "each key once", f"{repeated} more than once")
    return {each.key: each.value for each in given}


def first_repeated(keys: Iterable[str]) -> str | None:
    """The first key that repeats an earlier one; None if all differ."""
    seen: set[str] = set()
    for key in keys:
        if key in seen:
            return key
        seen.add(key)
    return None


@dataclass(frozen=True, slots=True)
class Action:
    """An action of a node or edge, or an instant action.

    Attributes:
        id, type: `actionId`, `actionType`.
        blocking: NONE, SOFT or HARD.
        parameters: By key.
        description: Free text.
    """

    id: Annotated[Id, "actionId"]
    type: Annotated[Id, "actionType"]
    blocking: Annotated[str, _blocking, "blockingType", REQUIRED] = "NONE"
    parameters: Annotated[Mapping[str, Any], _parameters, "actionParameters"] = field(default_factory=dict)
    description: Annotated[Text, "actionDescription"] = ""

    def to_json(self) -> dict[str, object]:
        """The JSON object of an order message."""
        found: dict[str, object] = {
            "actionType": self.type,
            "actionId": self.id,
            "blockingType": self.blocking,
        }
        if self.description:
            found["actionDescription"] = self.description
        found["actionParameters"] = [{"key": key, "value": value} for key, value in self.parameters.items()]
        return found


def _turn(value: object, max_characters: int) -> float:
    return abs(float(_angle(value, max_characters)))


ACTION = Reader(Action, null=True)
_actions = listed(ACTION, MAX_ACTIONS, "a list of actions")


@dataclass(frozen=True, slots=True)
class NodePosition:
    """The position of a node, m and rad in the map.

    Attributes:
        deviation_xy: Radius of the deviation range in m; 0 is the vehicle's own tolerance.
        deviation_theta: Allowed deviation of the heading in rad; None is the vehicle's own tolerance.
    """

    x: Number
    y: Number
    map_id: Annotated[Id, "mapId"]
    theta: Angle | None = None
    deviation_xy: Annotated[Distance, "allowedDeviationXY"] = 0.0
    deviation_theta: Annotated[float | None, _turn, "allowedDeviationTheta"] = None
    description: Annotated[Text, "mapDescription"] = ""

    def to_json(self) -> dict[str, object]:
        """The JSON object of an order message."""
        found: dict[str, object] = {"x": self.x, "y": self.y, "mapId": self.map_id}
        if self.theta is not None:
            found["theta"] = self.theta
        if self.deviation_xy:
            found["allowedDeviationXY"] = self.deviation_xy
        if self.deviation_theta is not None:
            found["allowedDeviationTheta"] = self.deviation_theta
        return found


_read_position = Reader(NodePosition, null=True)


def _position(value: object, max_characters: int) -> NodePosition:
    """The schema of 2.0 spells one field differently from its text, and from 2.1."""
    if isinstance(value, dict) and "allowedDeviationXY" not in value and "allowedDeviationXy" in value:
        value = {**value, "allowedDeviationXY": value["allowedDeviationXy"]}
    return _read_position(value, max_characters)


@dataclass(frozen=True, slots=True)
class Node:
    """A node of an order."""

    id: Annotated[Id, "nodeId"]
    sequence: Annotated[Count, "sequenceId"]
    released: Flag
    position: Annotated[NodePosition | None, _position, "nodePosition"] = None
    actions: Annotated[tuple[Action, ...], _actions, REQUIRED] = ()
    description: Annotated[Text, "nodeDescription"] = ""

    def to_json(self) -> dict[str, object]:
        """The JSON object of an order message."""
        found: dict[str, object] = {"nodeId": self.id, "sequenceId": self.sequence, "released": self.released}
        if self.description:
            found["nodeDescription"] = self.description
        if self.position is not None:
            found["nodePosition"] = self.position.to_json()
        found["actions"] = [action.to_json() for action in self.actions]
        return found


@dataclass(frozen=True, slots=True)
class Edge:
    """The edge between two nodes.

    Attributes:
        options: Its other fields (maxSpeed, orientation, trajectory ...), by the names of the standard.
    """

    id: Annotated[Id, "edgeId"]
    sequence: Annotated[Count, "sequenceId"]
    released: Flag
    start: Annotated[Id, "startNodeId"]
    end: Annotated[Id, "endNodeId"]
    options: Mapping[str, Any] = field(default_factory=dict)
    actions: Annotated[tuple[Action, ...], _actions, REQUIRED] = ()

    def to_json(self) -> dict[str, object]:
        """The JSON object of an order message."""
        return {
            "edgeId": self.id, "sequenceId": self.sequence, "released": self.released,
            "startNodeId": self.start, "endNodeId": self.end, **self.options,
            "actions": [action.to_json() for action in self.actions],
        }  # fmt: skip


NODE = Reader(Node, null=True)


class _EdgeOptions(NamedTuple):
    description: Annotated[Text, "edgeDescription"] = ""
    max_speed: Annotated[Number, "maxSpeed"] = 0.0
    max_height: Annotated[Number, "maxHeight"] = 0.0
    min_height: Annotated[Number, "minHeight"] = 0.0
    orientation: Angle = 0.0
    orientation_type: Annotated[str, _orientation_type, "orientationType"] = ""
    direction: Text = ""
    rotation_allowed: Annotated[Flag, "rotationAllowed"] = True
    max_rotation_speed: Annotated[Number, "maxRotationSpeed"] = 0.0
    length: Number = 0.0
    trajectory: Annotated[Mapping[str, object], _object] = {}
    corridor: Annotated[Mapping[str, object], _object] = {}


_read_edge, _read_options = Reader(Edge, null=True), Reader(_EdgeOptions, null=True)


def read_edge(value: object, max_characters: int = 0) -> Edge:
    """An edge with its options as they are in JSON."""
    edge = _read_edge(value, max_characters)
    _read_options(value, max_characters)
    given = value if isinstance(value, dict) else {}
    return replace(edge, options={name: given[name] for name, *_ in _read_options.fields if name in given})


@dataclass(frozen=True, slots=True)
class Order:
    """A well-formed order or order update."""

    id: Annotated[Id, "orderId"]
    update: Annotated[Count, "orderUpdateId"]
    nodes: Annotated[tuple[Node, ...], listed(NODE, MAX_NODES)]
    edges: Annotated[tuple[Edge, ...], listed(read_edge, MAX_NODES), REQUIRED] = ()
    zone_set: Annotated[Text, "zoneSetId"] = ""
    header: Annotated[Count, "headerId", REQUIRED] = 0

    @property
    def references(self) -> dict[str, str]:
        """The references of a problem of this order (7.1)."""
        return {
            "topic": "order", "headerId": str(self.header), "orderId": self.id,
            "orderUpdateId": str(self.update),
        }  # fmt: skip

    def actions(self) -> Iterator[Action]:
        """The actions of all nodes and edges."""
        elements: tuple[Node | Edge, ...] = (*self.nodes, *self.edges)
        for element in elements:
            yield from element.actions


@dataclass(frozen=True, slots=True)
class InstantActions:
    """A message of instant actions."""

    actions: Annotated[tuple[Action, ...], listed(ACTION, MAX_ACTIONS)]
    header: Annotated[Count, "headerId", REQUIRED] = 0
