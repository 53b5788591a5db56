"""The fields of a rosbridge message: one type for each kind of field, with the check of its JSON value.

`operations.py` says which operation has which fields.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from rosproto.gateway.rosbridge.action_mapping import ActionStatus
from rosproto.json_fields import Expected, fits, flag, number, one_of, shown, whole
from rosproto.json_values import JsonValue

MAX_WHOLE_NUMBER = 2**31 - 1
"""The largest whole number; larger sizes, rates and counts make no sense."""
_COMPRESSIONS = ("none", "png", "cbor", "cbor-raw")

Level = Literal["none", "error", "warning", "info"]
LEVELS: tuple[Level, ...] = ("none", "error", "warning", "info")
"""Levels of status messages (ROSBRIDGE_PROTOCOL.md, 3.2); each includes those before it."""
_SPELLINGS: dict[str, Level] = {
    **{level: level for level in LEVELS},
    "err": "error",
    "warn": "warning",
    "information": "info",
}

Id = str | float | None
"""The client's id of a request, repeated in every answer. A number may have any JSON form."""


class WrongMessage(Exception):
    """A message or one of its fields is wrong; the text is a sentence for the client."""


def _seconds(value: Any, _max_characters: int) -> float | None:
    """None, "no time-out", for zero, negative numbers (from roslib) and anything else."""
    return float(value) if type(value) in (int, float) and 0 < value <= MAX_WHOLE_NUMBER else None


def _level(value: Any, _max_characters: int) -> Level:
    if isinstance(value, str) and value in _SPELLINGS:
        return _SPELLINGS[value]
    raise Expected(f"one of {', '.join(LEVELS)}")


_text = fits(
    lambda value, n: isinstance(value, str) and len(value) <= n,
    "a text of at most {max_characters} characters",
)
_name = fits(
    lambda value, n: isinstance(value, str) and 0 < len(value) <= n,
    "a text of 1 to {max_characters} characters",
)
_compression = one_of(_COMPRESSIONS, f"one of {', '.join(_COMPRESSIONS)}")
_arguments = fits(
    lambda value, _: isinstance(value, (dict, list)), "an object by field, or an array by position"
)
_status = fits(
    lambda value, _: type(value) is int and value in range(len(ActionStatus)),
    f"a status of a goal, from 0 to {len(ActionStatus) - 1}",
)

# Each type with the check of its JSON value.
Text = Annotated[str, _text]
Name = Annotated[str, _name]
Flag = Annotated[bool, flag]
Count = Annotated[int, whole(0, MAX_WHOLE_NUMBER)]
Size = Annotated[int, whole(1, MAX_WHOLE_NUMBER)]
Seconds = Annotated[float, _seconds]
Number = Annotated[float, number(-(2**63), 2**63)]
Compression = Annotated[Literal["none", "png", "cbor", "cbor-raw"], _compression]
StatusLevel = Annotated[Level, _level]
Arguments = Annotated[dict[str, JsonValue] | list[JsonValue], _arguments]
Status = Annotated[int, _status]


def read_id(message: dict[str, JsonValue], text_length: int) -> Id:
    """The id of a message, or None.

    Raises:
        WrongMessage: It is neither a text nor a number, or too long.
    """
    value = message.get("id")
    if value is None or (isinstance(value, (int, float)) and abs(value) < 2**63):  # not a NaN
        return value
    if isinstance(value, str) and len(value) <= text_length:
        return value
    raise WrongMessage(
        f"field id is {shown(value)}; expected a text of at most {text_length} characters or a number"
    )
