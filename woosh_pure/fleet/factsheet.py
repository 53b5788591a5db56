"""The factsheet: what the vehicle is and can, from the chassis's own parameters, its footprint and its
abilities.

Pure. What a chassis does not tell (its height, what it may carry, how fast it brakes) comes from the
configuration; a value that nobody has given is 0, which the standard reads as "no limit is known".
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from woosh_pure.fleet.messages import schema
from woosh_pure.fleet.order.actions import BUILT_IN, Ability
from woosh_pure.fleet.order.limits import Limits

__all__ = ["Body", "factsheet_message"]


@dataclass(frozen=True, slots=True)
class Body:
    """What is known of the vehicle's body.

    Attributes:
        series: `seriesName`.
        speed_max: m/s.
        turn_max: rad/s.
        outline: Corners (x, y) in m in base_link; empty where it is not known.
        height, load: m and kg; 0 where nobody has said it.
        acceleration: m/s².
        omni: Whether it drives sideways.
    """

    series: str = "Woosh chassis"
    speed_max: float = 0.0
    turn_max: float = 0.0
    outline: Sequence[tuple[float, float]] = ()
    height: float = 0.0
    load: float = 0.0
    acceleration: float = 0.0
    omni: bool = False

    @property
    def size(self) -> tuple[float, float]:
        """Length and width in m; 0 where the outline is not known."""
        if not self.outline:
            return 0.0, 0.0
        xs, ys = zip(*self.outline, strict=True)
        return max(xs) - min(xs), max(ys) - min(ys)


_OPTIONAL = {
    "order.nodes.nodePosition.theta": "the heading on the node",
    "order.nodes.nodePosition.allowedDeviationXY": "more than 0: the node is passed without a stop",
    "order.nodes.nodePosition.allowedDeviationTheta": "the heading's range on the node",
    "order.nodes.nodeDescription": "passed on",
    "order.edges.length": "not needed",
    "order.edges.rotationAllowed": "true only: the vehicle plans its own way",
}


def _optional_parameters(limits: Limits) -> list[dict[str, Any]]:
    given = dict(_OPTIONAL)
    if limits.speed:
        given["order.edges.maxSpeed"] = "set before the edge is driven"
    if limits.directions:
        given["order.edges.orientation"] = "tangential, 0 or pi: forwards or backwards"
        given["order.edges.orientationType"] = "TANGENTIAL"
    if limits.zone_set:
        given["order.zoneSetId"] = limits.zone_set
    found = [{"parameter": key, "support": "SUPPORTED", "description": text} for key, text in given.items()]
    position = "SUPPORTED" if limits.marks else "REQUIRED"
    why = "a node without one is a mark of the chassis" if limits.marks else "where to drive to"
    return [{"parameter": "order.nodes.nodePosition", "support": position, "description": why}, *found]


def _ability(ability: Ability) -> dict[str, Any]:
    # Without blockingTypes: text and schema of 2.1 contradict each other there, and no value fits both.
    found: dict[str, Any] = {
        "actionType": ability.type,
        "actionScopes": [scope.value for scope in ability.scopes],
    }
    if ability.description:
        found["actionDescription"] = ability.description
    if ability.parameters:
        found["actionParameters"] = [
            {"key": p.key, "valueDataType": p.kind, "isOptional": p.optional, "description": p.description}
            for p in ability.parameters
        ]
    return found


def factsheet_message(
    body: Body,
    limits: Limits,
    header: Mapping[str, Any],
    *,
    version: str,
    visualization: float = 0.0,
    software: Sequence[tuple[str, str]] = (),
    load_positions: Sequence[str] = (),
) -> dict[str, Any]:
    """The factsheet of a version of the standard.

    Args:
        body: The vehicle's body.
        limits: What it can do.
        header: The message's header.
        version: "2.0.0" or "2.1.0".
        visualization: Seconds between two visualization messages; 0 sends none.
        software: (name, version) pairs.
        load_positions: Names of its load handling devices.
    """
    later = not version.startswith("2.0")
    length, width = body.size
    abilities = {**limits.abilities, **BUILT_IN}
    timing = {"minOrderInterval": 0.1, "minStateInterval": 0.1, "defaultStateInterval": 30.0}
    if visualization > 0.0:
        timing["visualizationInterval"] = visualization
    message: dict[str, Any] = {
        **header,
        "typeSpecification": {
            "seriesName": body.series, "agvKinematic": "OMNI" if body.omni else "DIFF", "agvClass": "CARRIER",
            "maxLoadMass": body.load, "localizationTypes": ["NATURAL"], "navigationTypes": ["AUTONOMOUS"],
        },
        "physicalParameters": {
            "speedMin": 0.0, "speedMax": body.speed_max, "accelerationMax": body.acceleration,
            "decelerationMax": body.acceleration, "heightMin": body.height, "heightMax": body.height,
            "width": width, "length": length,
        },
        "protocolLimits": {
            "maxStringLens": {"msgLen": schema.MOST_BYTES, "idLen": schema.LONGEST_ID,
            "idNumericalOnly": False}, "maxArrayLens": {
                "order.nodes": schema.MOST_NODES, "order.edges": schema.MOST_NODES - 1,
                "node.actions": schema.MOST_ACTIONS, "edge.actions": schema.MOST_ACTIONS,
                "actions.actionsParameters": schema.MOST_PARAMETERS, "instantActions":
                schema.MOST_ACTIONS,
            },
            "timing": timing,
        },
        "protocolFeatures": {
            "optionalParameters": _optional_parameters(limits),
            "agvActions": [_ability(each) for each in abilities.values()],
        },
        "agvGeometry": {},
        "loadSpecification": {"loadPositions": list(load_positions)} if load_positions else {},
    }  # fmt: skip
    if later:
        message["physicalParameters"].update(angularSpeedMin=0.0, angularSpeedMax=body.turn_max)
        versions = [{"key": key, "value": value} for key, value in software]
        message["vehicleConfig"] = {"versions": versions} if versions else {}
    if body.outline:
        corners = [{"x": x, "y": y} for x, y in body.outline]
        message["agvGeometry"]["envelopes2d"] = [{"set": "footprint", "polygonPoints": corners}]
    return message
