"""Field tables of the messages that a fleet manager sends, and the check by them; header check and
timestamps. Pure.

The tables list the fields of chapters 6.6.6 and 6.9 with the kind of their values; `!` marks required fields.
Unknown fields are ignored, as by the schemas of the standard. Version 2.1 only adds fields to 2.0, so one
table serves both.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from datetime import datetime, timezone
from typing import Any

from rosproto.text import printable

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
        self.got = printable(got if isinstance(got, str) else repr(got))[:120]
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
        where = f"{path}.{key}" if path else key
        if key in raw:
            _check_value(raw[key], kind.rstrip("!"), where)
        elif kind.endswith("!"):
            raise Invalid(where, _WORDS.get(kind[:-1], kind[:-1]), "nothing")


def _check_value(value: Any, kind: str, path: str) -> None:
    if kind == "position":
        check(value, POSITION, path)
    elif kind == "parameters":
        require(
            isinstance(value, list) and len(value) <= MOST_PARAMETERS, path, "a list of parameters", value
        )
        for n, each in enumerate(value):
            check(each, PARAMETER, f"{path}[{n}]")
    else:
        require(_FITS[kind](value), path, _WORDS[kind], value)


def require(fits: bool, path: str, expected: str, got: object) -> None:
    """Raise `Invalid` unless `fits`."""
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
    moment = datetime.fromtimestamp(seconds, timezone.utc)
    return moment.strftime("%Y-%m-%dT%H:%M:%S.") + f"{moment.microsecond // 10000:02d}Z"
