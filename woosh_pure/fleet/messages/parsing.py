"""Parse orders and instant actions from JSON. Pure.

`elements.py` has the fields of chapters 6.6.6 and 6.9. Unknown fields are ignored, as by the schemas of the
standard.

A message that does not fit raises `Invalid` with the field, the expected and the received value. So does an
order with a wrong structure (6.6.1, 6.6.2): there must be one edge fewer than nodes, each between its
two nodes; sequence ids count up by one over nodes and edges; the first node is released, and nothing after an
unreleased element is; each actionId is unique. `order/rejection.py` rejects well-formed orders that cannot be
obeyed.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from datetime import datetime, timezone
from typing import TypeVar

from rosproto.json_fields import MISSING, Expected, FieldError, Reader
from rosproto.text import printable, short
from woosh_pure.fleet.messages import elements
from woosh_pure.fleet.messages.elements import ACTION, NODE, Action, Edge, Header, InstantActions, Node, Order

MAX_MESSAGE_BYTES = 1_000_000
"""Largest message; `msgLen` of the factsheet."""
T = TypeVar("T")
compact_json = json.JSONEncoder(separators=(",", ":")).encode
"""JSON without blanks; one encoder for all, because `json.dumps` makes one for each such text."""


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


_HEADER, _ORDER = Reader(Header, null=True), Reader(Order, null=True)
_INSTANT_ACTIONS = Reader(InstantActions, null=True)


def _read(check: Callable[[object], T], raw: object, path: str = "") -> T:
    try:
        return check(raw)
    except Expected as error:
        raise Invalid(path, str(error), raw) from None
    except FieldError as error:
        error = error.inside(path) if path else error
        got = "nothing" if error.value is MISSING else error.value
        raise Invalid(error.path, error.expected, got) from None


def require(fits: bool, path: str, expected: str, got: object) -> None:
    """Raise `Invalid` unless `fits`."""
    if not fits:
        raise Invalid(path, expected, got)


def check_header(data: Mapping[str, object], *, version: str, manufacturer: str, serial: str) -> None:
    """Check that a message is for this vehicle and has a supported version.

    Args:
        data: The message.
        version: The vehicle's version of the protocol; messages may have any version with the same major
            number.
        manufacturer, serial: The vehicle.

    Raises:
        Invalid: The message is for another vehicle or has another major version; the path names the field.
    """
    header = _read(_HEADER, data)
    major = version.partition(".")[0]
    require(header.version.partition(".")[0] == major, "version", f"a version {major}", header.version)
    for key, ours in (("manufacturer", manufacturer), ("serialNumber", serial)):
        require(data[key] == ours, key, f"{ours}: this vehicle", data[key])


def timestamp(seconds: float) -> str:
    """Format seconds since 1970 for a message: ISO 8601, UTC, with hundredths and a Z."""
    return datetime.fromtimestamp(seconds, timezone.utc).isoformat(timespec="milliseconds")[:22] + "Z"


# -- reading -------------------------------------------------------------------------------------------------


def parse(payload: bytes | str) -> dict[str, object]:
    """The JSON object of a message; raises `Invalid` for anything else."""
    if len(payload) > MAX_MESSAGE_BYTES:
        raise Invalid("", f"at most {MAX_MESSAGE_BYTES} bytes", f"{len(payload)} bytes")
    try:
        found = json.loads(payload, parse_constant=_no_constant, object_pairs_hook=_each_key_once)
    except (ValueError, RecursionError) as error:
        raise Invalid("", "a JSON object in UTF-8", str(error) or type(error).__name__) from None
    if not isinstance(found, dict):
        raise Invalid("", "a JSON object", found)
    return found


def _each_key_once(pairs: list[tuple[str, object]]) -> dict[str, object]:
    """A JSON object; repeated keys are an error, because it is not clear which value is meant."""
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError(
            f"the key {elements.first_repeated(key for key, _ in pairs)!r} comes twice in one object"
        )
    return found


def _no_constant(text: str) -> float:
    raise ValueError(f"{text} is not a JSON number")


def read_order(data: Mapping[str, object]) -> Order:
    """Read an order.

    Raises:
        Invalid: The object does not fit the table, or has the wrong structure.
    """
    _read(_HEADER, data)
    order = _read(_ORDER, data)
    _require_shape(order)
    return order


def read_instant_actions(data: Mapping[str, object]) -> InstantActions:
    """Read instant actions; the name of version 1 is accepted, too.

    Raises:
        Invalid: The object does not fit the table.
    """
    if "actions" not in data and "instantActions" in data:
        data = {**data, "actions": data["instantActions"]}
    _read(_HEADER, data)
    return _read(_INSTANT_ACTIONS, data)


def read_node(raw: object, path: str) -> Node:
    """Read a node; `path` is its place in the message, for errors."""
    return _read(NODE, raw, path)


def read_edge(raw: object, path: str) -> Edge:
    """Read an edge; `path` is its place in the message, for errors."""
    return _read(elements.read_edge, raw, path)


def read_action(raw: object, path: str) -> Action:
    """Read an action; `path` is its place in the message, for errors."""
    return _read(ACTION, raw, path)


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
        both: tuple[tuple[str, Node | Edge], ...] = ((f"edges[{n}]", edge), (f"nodes[{n + 1}]", node))
        for path, each in both:
            wanted = before.sequence + 1
            require(each.sequence == wanted, f"{path}.sequenceId", f"{wanted}: it counts on", each.sequence)
            behind = f"{path}.released"
            require(before.released or not each.released, behind, "false behind what is not released", True)
            before = each
        # An edge is released with both of its nodes (6.6.1), and a node is reached over its edge.
        require(
            edge.released == node.released, f"edges[{n}].released", "as that of its end node", edge.released
        )
    repeated = elements.first_repeated(action.id for action in order.actions())
    require(repeated is None, "actions", "each actionId once", repeated)
