"""The messages that a vehicle publishes, as JSON objects: connection, state, visualization and factsheet, and
the header of each.
"""

from __future__ import annotations

import operator
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from itertools import compress
from typing import Generic, TypeVar

from rosproto.version import __version__
from woosh_pure.fleet.chassis_facts import ChassisFacts
from woosh_pure.fleet.config import VehicleConfig
from woosh_pure.fleet.messages import elements, parsing
from woosh_pure.fleet.messages.elements import Edge, Node
from woosh_pure.fleet.messages.parsing import compact_json, timestamp
from woosh_pure.fleet.order.action_states import BUILT_IN, ActionState, SupportedAction
from woosh_pure.fleet.order.errors import ErrorType, Level, Problem
from woosh_pure.fleet.order.state import OrderState
from woosh_pure.fleet.order.vehicle_limits import Capabilities
from woosh_pure.values import Parameters

# -- the header of each message ------------------------------------------------------------------------------

_HEADER_IDS = 2**32  # headerId is a uint32; it starts again at 0


class MessageHeaders:
    """Makes the headers of one vehicle's messages; any thread may call it.

    Args:
        version: Version of the protocol, "2.1.0".
        manufacturer, serial: The vehicle.
    """

    def __init__(self, version: str, manufacturer: str, serial: str) -> None:
        self._fixed = {"version": version, "manufacturer": manufacturer, "serialNumber": serial}
        self._next: dict[str, int] = {}
        self._lock = threading.Lock()

    def header(self, topic: str) -> dict[str, object]:
        """Return the next header of a topic."""
        with self._lock:
            number = self._next.get(topic, 0)
            self._next[topic] = (number + 1) % _HEADER_IDS
        return {"headerId": number, "timestamp": timestamp(time.time()), **self._fixed}

    def connection_message(self, state: str) -> dict[str, object]:
        """The connection message for a state, such as "ONLINE"."""
        return {**self.header("connection"), "connectionState": state}


# -- state and visualization: from the order and the data of the chassis -------------------------------------

T = TypeVar("T")


class _Texts(Generic[T]):
    """The JSON texts of a list, which differs little from one message to the next: elements of an order have
    gone in front, or an action has changed. What was in the last message is not formatted again."""

    def __init__(self, describe: Callable[[T], Mapping[str, object]]) -> None:
        self._describe = describe
        self._elements: tuple[T, ...] = ()
        self._texts: list[str] = []

    def of(self, elements: tuple[T, ...]) -> list[str]:
        """The texts of the elements."""
        before, texts = self._elements, self._texts
        gone = len(before) - len(elements)
        if gone >= 0 and before[gone:] == elements:
            texts = texts[gone:]
        elif gone < 0 and elements[:gone] == before:
            texts = [*texts, *(compact_json(self._describe(each)) for each in elements[gone:])]
        elif gone == 0:
            for n in compress(range(len(elements)), map(operator.is_not, before, elements)):
                texts[n] = compact_json(self._describe(elements[n]))
        else:
            known = dict(zip(map(id, before), texts, strict=True))
            texts = [known.get(id(each)) or compact_json(self._describe(each)) for each in elements]
        self._elements, self._texts = elements, texts
        return texts


def _position_and_velocity(facts: ChassisFacts) -> dict[str, object]:
    """The fields agvPosition and velocity, as far as they are known."""
    found: dict[str, object] = {}
    if facts.position is not None:
        found["agvPosition"] = {
            "x": facts.position.x, "y": facts.position.y, "theta": facts.position.theta,
            "mapId": facts.map_id, "positionInitialized": facts.located and not facts.lost,
        }  # fmt: skip
    if facts.velocity is not None:
        found["velocity"] = dict(zip(("vx", "vy", "omega"), facts.velocity, strict=True))
    return found


def _node_state(node: Node) -> dict[str, object]:
    found: dict[str, object] = {"nodeId": node.id, "sequenceId": node.sequence, "released": node.released}
    if node.description:
        found["nodeDescription"] = node.description
    if node.position is not None and node.position.theta is not None:  # the schema of 2.0 wants a theta
        p = node.position
        found["nodePosition"] = {"x": p.x, "y": p.y, "theta": p.theta, "mapId": p.map_id}
    return found


def _edge_state(edge: Edge) -> dict[str, object]:
    return {"edgeId": edge.id, "sequenceId": edge.sequence, "released": edge.released}


def _trajectory(order: OrderState, facts: ChassisFacts) -> dict[str, object]:
    """The field of the current edge with the path that the chassis has planned (6.10.1), as a NURBS of degree
    1: a line through its corners."""
    drive, inner = order.drive, len(facts.path) - 1
    if drive is None or drive.edge is None or not facts.has_path_to(drive.node):
        return {}
    knots = [0.0, *(round(n / inner, 6) for n in range(inner + 1)), 1.0]
    corners = [{"x": round(x, 3), "y": round(y, 3)} for x, y in facts.path]
    return {"trajectory": {"degree": 1, "knotVector": knots, "controlPoints": corners}}


class StateMessages:
    """Makes the state messages of one vehicle. Not for several threads at a time.

    Args:
        version: Version of the protocol.
    """

    def __init__(self, version: str) -> None:
        self._version = version
        self._nodes, self._edges = _Texts(_node_state), _Texts(_edge_state)
        self._actions = _Texts(ActionState.to_state)

    def text(self, order: OrderState, facts: ChassisFacts, header: Mapping[str, object]) -> str:
        """The next state message, as JSON."""
        edges, trajectory = self._edges.of(order.edges), _trajectory(order, facts)
        if trajectory:
            edges = [compact_json(_edge_state(order.edges[0]) | trajectory), *edges[1:]]
        lists = {
            "nodeStates": self._nodes.of(order.nodes),
            "edgeStates": edges,
            "actionStates": self._actions.of(order.action_states.all),
        }
        listed = ",".join(f'"{key}":[{",".join(texts)}]' for key, texts in lists.items())
        return f"{compact_json(_state_fields(order, facts, header, self._version))[:-1]},{listed}}}"


def _state_fields(
    order: OrderState, facts: ChassisFacts, header: Mapping[str, object], version: str
) -> dict[str, object]:
    """The fields of the state message except the lists of nodes, edges and actions."""
    later = not version.startswith("2.0")
    faults = [
        Problem(ErrorType.CHASSIS, text, level=Level.FATAL if severe else Level.WARNING)
        for text, severe in facts.faults
    ]
    message: dict[str, object] = {
        **header,
        "orderId": order.order_id,
        "orderUpdateId": order.update,
        "lastNodeId": order.last_node,
        "lastNodeSequenceId": order.last_sequence,
        "driving": facts.moving or (facts.lost and facts.may_move),
        "paused": order.paused or order.held,
        "newBaseRequest": order.wants_base,
        "batteryState": _battery(facts),
        "operatingMode": order.mode,
        "errors": [problem.to_json(hints=later) for problem in (*faults, *order.problems)],
        "information": [
            {"infoType": kind, "infoDescription": text, "infoLevel": "INFO", "infoReferences": []}
            for kind, text in facts.information
        ],
        "safetyState": {
            "eStop": "MANUAL" if facts.emergency_stop else "NONE", "fieldViolation": facts.bumper,
        },
        **_position_and_velocity(facts),
    }  # fmt: skip
    if facts.zone_set:
        message["zoneSetId"] = facts.zone_set
    if facts.loads is not None:
        message["loads"] = [load.to_json() for load in facts.loads]
    if later and facts.maps:
        message["maps"] = [entry.to_json() for entry in facts.maps]
    return message


def _battery(facts: ChassisFacts) -> dict[str, object]:
    found: dict[str, object] = {"batteryCharge": float(facts.percent or 0.0), "charging": facts.charging}
    if facts.voltage is not None:
        found["batteryVoltage"] = facts.voltage
    return found


def visualization_message(facts: ChassisFacts, header: dict[str, object]) -> dict[str, object]:
    """Pose and velocity for displays."""
    return header | _position_and_velocity(facts)


# -- the factsheet -------------------------------------------------------------------------------------------
#
# Values that the chassis does not provide (height, load, deceleration) come from the configuration; unknown
# ones are 0, which means "not known" in the standard.


_OPTIONAL = {
    "order.nodes.nodePosition.theta": "the heading on the node",
    "order.nodes.nodePosition.allowedDeviationXY": "more than 0: the node is passed without a stop",
    "order.nodes.nodePosition.allowedDeviationTheta": "the heading's range on the node",
    "order.nodes.nodeDescription": "passed on",
    "order.edges.length": "not needed",
    "order.edges.rotationAllowed": "true only: the vehicle plans its own way",
    "order.edges.maxSpeed": "set before the edge is driven",
    "order.edges.orientation": "tangential, 0 or pi: forwards or backwards",
    "order.edges.orientationType": "TANGENTIAL",
}


def _optional_parameters(limits: Capabilities) -> list[dict[str, object]]:
    given = dict(_OPTIONAL)
    if limits.zone_set:
        given["order.zoneSetId"] = limits.zone_set
    found: list[dict[str, object]] = [
        {"parameter": key, "support": "SUPPORTED", "description": text} for key, text in given.items()
    ]
    position = "SUPPORTED" if limits.marks else "REQUIRED"
    why = "a node without one is a mark of the chassis" if limits.marks else "where to drive to"
    return [{"parameter": "order.nodes.nodePosition", "support": position, "description": why}, *found]


def _agv_action(supported: SupportedAction) -> dict[str, object]:
    # blockingTypes is omitted: text and schema of 2.1 contradict each other, and no value fits both.
    found: dict[str, object] = {
        "actionType": supported.type,
        "actionScopes": [scope.value for scope in supported.scopes],
    }
    if supported.description:
        found["actionDescription"] = supported.description
    if supported.parameters:
        found["actionParameters"] = [
            {"key": p.key, "valueDataType": p.kind, "isOptional": p.optional, "description": p.description}
            for p in supported.parameters
        ]
    return found


def factsheet_message(
    config: VehicleConfig,
    limits: Capabilities,
    header: Mapping[str, object],
    known: Parameters | None,
    outline: Sequence[tuple[float, float]],
) -> dict[str, object]:
    """The factsheet for the vehicle's version of the standard.

    Args:
        config: The vehicle.
        limits: Its capabilities.
        header: The message's header.
        known: The chassis's driving parameters; None if they are not known yet.
        outline: Corners (x, y) in m in base_link; empty if not known.
    """
    xs, ys = zip(*outline, strict=True) if outline else ((0.0,), (0.0,))
    actions = {**limits.actions, **BUILT_IN}
    timing = {"minOrderInterval": 0.1, "minStateInterval": 0.1, "defaultStateInterval": 30.0}
    if config.visualization > 0.0:
        timing["visualizationInterval"] = config.visualization
    physical = {
        "speedMin": 0.0, "speedMax": 0.0 if known is None else known.max_linear,
        "accelerationMax": config.acceleration, "decelerationMax": config.acceleration,
        "heightMin": config.height, "heightMax": config.height,
        "width": max(ys) - min(ys), "length": max(xs) - min(xs),
    }  # fmt: skip
    envelope = {"set": "footprint", "polygonPoints": [{"x": x, "y": y} for x, y in outline]}
    message: dict[str, object] = {
        **header,
        "typeSpecification": {
            "seriesName": config.series, "agvKinematic": "DIFF", "agvClass": "CARRIER",
            "maxLoadMass": config.load, "localizationTypes": ["NATURAL"], "navigationTypes": ["AUTONOMOUS"],
        },
        "physicalParameters": physical,
        "protocolLimits": {
            "maxStringLens": {"msgLen": parsing.MAX_MESSAGE_BYTES, "idLen": elements.MAX_ID_CHARACTERS,
            "idNumericalOnly": False}, "maxArrayLens": {
                "order.nodes": elements.MAX_NODES, "order.edges": elements.MAX_NODES - 1,
                "node.actions": elements.MAX_ACTIONS, "edge.actions": elements.MAX_ACTIONS,
                "actions.actionsParameters": elements.MAX_PARAMETERS, "instantActions":
                elements.MAX_ACTIONS,
            },
            "timing": timing,
        },
        "protocolFeatures": {
            "optionalParameters": _optional_parameters(limits),
            "agvActions": [_agv_action(each) for each in actions.values()],
        },
        "agvGeometry": {"envelopes2d": [envelope]} if outline else {},
        "loadSpecification": {},
    }  # fmt: skip
    if not config.version.startswith("2.0"):
        turn = 0.0 if known is None else known.max_angular
        physical.update(angularSpeedMin=0.0, angularSpeedMax=turn)
        message["vehicleConfig"] = {"versions": [{"key": "woosh-pure", "value": __version__}]}
    return message
