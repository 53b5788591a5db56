"""Orders and instant actions as values: Order, Node, Edge, Action (6.6.6, 6.9). Pure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True, slots=True)
class Action:
    """An action of a node or edge, or an instant action.

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
        """The JSON object of an order message."""
        found: dict[str, Any] = {"actionType": self.type, "actionId": self.id, "blockingType": self.blocking}
        if self.description:
            found["actionDescription"] = self.description
        found["actionParameters"] = [{"key": key, "value": value} for key, value in self.parameters.items()]
        return found


@dataclass(frozen=True, slots=True)
class NodePosition:
    """The position of a node, m and rad in the map.

    Attributes:
        deviation_xy: Radius of the deviation range in m; 0 is the vehicle's own tolerance.
        deviation_theta: Allowed deviation of the heading in rad; None is the vehicle's own tolerance.
    """

    x: float
    y: float
    theta: float | None
    map_id: str
    deviation_xy: float = 0.0
    deviation_theta: float | None = None

    def to_json(self) -> dict[str, Any]:
        """The JSON object of an order message."""
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
    """A node of an order."""

    id: str
    sequence: int
    released: bool
    position: NodePosition | None = None
    actions: tuple[Action, ...] = ()
    description: str = ""

    def to_json(self) -> dict[str, Any]:
        """The JSON object of an order message."""
        found: dict[str, Any] = {"nodeId": self.id, "sequenceId": self.sequence, "released": self.released}
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

    id: str
    sequence: int
    released: bool
    start: str
    end: str
    options: Mapping[str, Any] = field(default_factory=dict)
    actions: tuple[Action, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """The JSON object of an order message."""
        return {
            "edgeId": self.id, "sequenceId": self.sequence, "released": self.released,
            "startNodeId": self.start, "endNodeId": self.end, **self.options,
            "actions": [action.to_json() for action in self.actions],
        }  # fmt: skip


@dataclass(frozen=True, slots=True)
class Order:
    """A well-formed order or order update."""

    id: str
    update: int
    nodes: tuple[Node, ...]
    edges: tuple[Edge, ...] = ()
    zone_set: str = ""
    header: int = 0

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

    actions: tuple[Action, ...]
    header: int = 0
