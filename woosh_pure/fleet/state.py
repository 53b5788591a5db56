"""The state and visualization messages, made of the order and of what the chassis tells. Pure."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Any

from woosh_pure.fleet.messages.elements import Node
from woosh_pure.fleet.order.errors import ErrorType, Level, Problem
from woosh_pure.fleet.order.limits import AgvPosition
from woosh_pure.fleet.order.state import OrderState

__all__ = ["Facts", "Load", "MapEntry", "state_message", "visualization_message"]


@dataclass(frozen=True, slots=True)
class Load:
    """A load on the vehicle, as pick and drop have left it."""

    load_id: str = ""
    load_type: str = ""
    position: str = ""

    def to_json(self) -> dict[str, Any]:
        """As the state has it."""
        given = {"loadId": self.load_id, "loadType": self.load_type, "loadPosition": self.position}
        return {key: value for key, value in given.items() if value}


@dataclass(frozen=True, slots=True)
class MapEntry:
    """A map on the vehicle."""

    map_id: str
    version: str = "1"
    enabled: bool = True

    def to_json(self) -> dict[str, Any]:
        """As the state has it."""
        status = "ENABLED" if self.enabled else "DISABLED"
        return {"mapId": self.map_id, "mapVersion": self.version, "mapStatus": status}


@dataclass(slots=True)
class Facts:
    """What is known of the chassis.

    Attributes:
        position: m and rad in the map; None while it was not heard.
        located: Whether the robot knows where it is.
        lost: Whether nothing is heard of the robot.
        may_move: While it is lost: whether it may be driving, because it was, or was told to.
        velocity: vx, vy in m/s, wz in rad/s; None while it was not heard.
        percent, voltage, charging: Of the battery; None while it was not heard.
        emergency_stop, bumper: As the chassis tells them.
        faults: Sentences of the faults that it tells, each with whether it is severe.
        loads: None where nothing tells them.
        zone_set: Of the chassis's map; "" where there is none.
        information: (type, text) pairs for people.
    """

    position: AgvPosition | None = None
    located: bool = False
    lost: bool = False
    may_move: bool = False
    velocity: tuple[float, float, float] | None = None
    percent: float | None = None
    voltage: float | None = None
    charging: bool = False
    emergency_stop: bool = False
    bumper: bool = False
    faults: tuple[tuple[str, bool], ...] = ()
    loads: tuple[Load, ...] | None = None
    maps: tuple[MapEntry, ...] = ()
    map_id: str = ""
    zone_set: str = ""
    information: tuple[tuple[str, str], ...] = field(default_factory=tuple)

    @property
    def alarms(self) -> tuple[object, ...]:
        """What is so urgent that any change of it sends a state."""
        return self.emergency_stop, self.bumper, self.faults, self.charging

    @property
    def moving(self) -> bool:
        """Whether the robot drives or turns."""
        return self.velocity is not None and (
            abs(self.velocity[0]) > 0.01 or abs(self.velocity[1]) > 0.01 or abs(self.velocity[2]) > 0.02
        )


def _position(facts: Facts) -> dict[str, Any] | None:
    if facts.position is None:
        return None
    return {
        "x": facts.position.x, "y": facts.position.y, "theta": facts.position.theta, "mapId": facts.map_id,
        "positionInitialized": facts.located and not facts.lost,
    }  # fmt: skip


def _velocity(facts: Facts) -> dict[str, Any] | None:
    if facts.velocity is None:
        return None
    return dict(zip(("vx", "vy", "omega"), facts.velocity, strict=True))


def _node_state(node: Node) -> dict[str, Any]:
    found: dict[str, Any] = {"nodeId": node.id, "sequenceId": node.sequence, "released": node.released}
    if node.description:
        found["nodeDescription"] = node.description
    if node.position is not None and node.position.theta is not None:  # the schema of 2.0 wants a theta
        p = node.position
        found["nodePosition"] = {"x": p.x, "y": p.y, "theta": p.theta, "mapId": p.map_id}
    return found


def state_message(order: OrderState, facts: Facts, header: dict[str, Any], version: str) -> dict[str, Any]:
    """The state as it is now, of a version of the standard."""
    later = not version.startswith("2.0")
    problems = [*_of_chassis(facts), *order.problems]
    message: dict[str, Any] = {
        **header,
        "orderId": order.order_id,
        "orderUpdateId": order.update,
        "lastNodeId": order.last_node,
        "lastNodeSequenceId": order.last_sequence,
        "nodeStates": [_node_state(node) for node in order.nodes],
        "edgeStates": [
            {"edgeId": edge.id, "sequenceId": edge.sequence, "released": edge.released} for edge in
            order.edges
        ],
        "driving": facts.moving or (facts.lost and facts.may_move),
        "paused": order.paused or order.held,
        "newBaseRequest": order.wants_base,
        "actionStates": [record.to_state() for record in order.action_states],
        "batteryState": _battery(facts),
        "operatingMode": order.mode,
        "errors": [problem.to_json(hints=later) for problem in problems],
        "information": [
            {"infoType": kind, "infoDescription": text, "infoLevel": "INFO", "infoReferences": []}
            for kind, text in facts.information
        ],
        "safetyState": {
            "eStop": "MANUAL" if facts.emergency_stop else "NONE", "fieldViolation": facts.bumper,
        },
    }  # fmt: skip
    for key, value in (("agvPosition", _position(facts)), ("velocity", _velocity(facts))):
        if value is not None:
            message[key] = value
    if facts.zone_set:
        message["zoneSetId"] = facts.zone_set
    if facts.loads is not None:
        message["loads"] = [load.to_json() for load in facts.loads]
    if later and facts.maps:
        message["maps"] = [entry.to_json() for entry in facts.maps]
    return message


def _battery(facts: Facts) -> dict[str, Any]:
    found: dict[str, Any] = {"batteryCharge": float(facts.percent or 0.0), "charging": facts.charging}
    if facts.voltage is not None:
        found["batteryVoltage"] = facts.voltage
    return found


def _of_chassis(facts: Facts) -> Collection[Problem]:
    return [
        Problem(ErrorType.CHASSIS, text, (), Level.FATAL if severe else Level.WARNING)
        for text, severe in facts.faults
    ]


def visualization_message(facts: Facts, header: dict[str, Any]) -> dict[str, Any]:
    """Pose and velocity for displays."""
    message = dict(header)
    for key, value in (("agvPosition", _position(facts)), ("velocity", _velocity(facts))):
        if value is not None:
            message[key] = value
    return message
