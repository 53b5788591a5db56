"""Parse orders and instant actions from JSON. Pure.

A message that does not fit the tables of `schema.py` raises `Invalid` with the field, the expected and the
received value. So does an order with a wrong structure (6.6.1, 6.6.2): there must be one edge fewer than
nodes, each between its two nodes; sequence ids count up by one over nodes and edges; the first node is
released, and nothing after an unreleased element is; each actionId is unique. `order/rejection.py` rejects
well-formed orders that cannot be obeyed.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

from woosh_pure.fleet.messages.elements import Action, Edge, InstantActions, Node, NodePosition, Order
from woosh_pure.fleet.messages.schema import (
    ACTION,
    EDGE,
    INSTANT_ACTIONS,
    MOST_ACTIONS,
    MOST_BYTES,
    MOST_NODES,
    NODE,
    ORDER,
    Invalid,
    check,
    require,
)


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
        tuple(_action(each, f"actions[{n}]") for n, each in enumerate(raw)), int(data["headerId"])
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
    return tuple(_action(each, f"{path}.actions[{n}]") for n, each in enumerate(found))


def _action(raw: Any, path: str) -> Action:
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
