"""What chapter 6.8.1 says of the predefined actions: where each may stand, and its parameters. Pure.

An action of the user's with one of these names is declared in the factsheet as the standard has it.
"""

from __future__ import annotations

from typing import Any

from woosh_pure.fleet.order.actions import Ability, Parameter, Scope

__all__ = ["MOVING", "PARAMETERS", "SCOPES", "predefined"]

_NODE, _EDGE, _INSTANT = Scope.NODE, Scope.EDGE, Scope.INSTANT
SCOPES: dict[str, tuple[Scope, ...]] = {
    "startCharging": (_INSTANT, _NODE), "stopCharging": (_INSTANT, _NODE), "initPosition": (_INSTANT, _NODE),
    "enableMap": (_INSTANT, _NODE), "downloadMap": (_INSTANT,), "deleteMap": (_INSTANT,),
    "logReport": (_INSTANT,), "pick": (_NODE, _EDGE), "drop": (_NODE, _EDGE), "detectObject": (_NODE, _EDGE),
    "finePositioning": (_NODE, _EDGE), "waitForTrigger": (_NODE,),
}  # fmt: skip
_MAP = (Parameter("mapId"), Parameter("mapVersion"))
_LOAD = (
    Parameter("lhd", optional=True), Parameter("stationName", optional=True),
    Parameter("loadId", optional=True), Parameter("height", "FLOAT", optional=True),
    Parameter("depth", "FLOAT", optional=True), Parameter("side", optional=True),
)  # fmt: skip
PARAMETERS: dict[str, tuple[Parameter, ...]] = {
    "initPosition": (
        Parameter("x", "FLOAT"), Parameter("y", "FLOAT"), Parameter("theta", "FLOAT"), Parameter("mapId"),
        Parameter("lastNodeId", optional=True),
    ),
    "enableMap": _MAP, "deleteMap": _MAP,
    "downloadMap": (
        *_MAP, Parameter("mapDownloadLink", description="http(s), a ZIP of a map_server YAML and picture"),
        Parameter("mapHash", optional=True, description="MD5, SHA-1, SHA-256 or SHA-512, hexadecimal"),
    ),
    "logReport": (Parameter("reason"),),
    "pick": (Parameter("stationType"), Parameter("loadType"), *_LOAD),
    "drop": (Parameter("stationType", optional=True), Parameter("loadType", optional=True), *_LOAD),
    "detectObject": (Parameter("objectType", optional=True),),
    "finePositioning": (Parameter("stationType", optional=True), Parameter("stationName", optional=True)),
    "waitForTrigger": (Parameter("triggerType"),),
}  # fmt: skip
MOVING = frozenset(("startCharging", "stopCharging", "pick", "drop", "finePositioning"))
"""Those that move the robot, unless a function says otherwise."""


def predefined(name: str, **given: Any) -> Ability:
    """An ability of the standard's, with the scopes and parameters that it has there."""
    return Ability(name, SCOPES[name], PARAMETERS.get(name, ()), moves=name in MOVING, **given)
