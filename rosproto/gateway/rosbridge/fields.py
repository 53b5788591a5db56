"""The fields of a rosbridge message: one type for each kind of field, with the check of its JSON value.

`operations.py` says which operation has which fields.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal

from rosproto.gateway.rosbridge.action_mapping import ActionStatus
from rosproto.gateway.values import shown

LARGEST = 2**31 - 1
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


class FieldError(Exception):
    """A field is missing or wrong; the text is a sentence for the client."""


Check = Callable[[Any, int], Any]
"""(value, longest text) -> value; ValueError with what is expected."""


def _expect(fits: Callable[[Any, int], bool], expected: str) -> Check:
    """A check that takes a value as it is, if it fits."""

    def check(value: Any, longest: int) -> Any:
        if fits(value, longest):
            return value
        raise ValueError(expected.format(longest=longest))

    return check


def _whole(least: int) -> Check:
    def check(value: Any, _longest: int) -> int:
        number = int(value) if isinstance(value, float) and value.is_integer() else value
        if type(number) is int and least <= number <= LARGEST:
            return number
        raise ValueError(f"a whole number from {least} to {LARGEST}")

    return check


def _seconds(value: Any, _longest: int) -> float | None:
    """None, "no time-out", for zero, negative numbers (from roslib) and anything else."""
    return float(value) if type(value) in (int, float) and 0 < value <= LARGEST else None


def _number(value: Any, _longest: int) -> float:
    if type(value) in (int, float) and abs(value) <= 2**63:
        return float(value)
    raise ValueError("a number")


def _level(value: Any, _longest: int) -> Level:
    if isinstance(value, str) and value in _SPELLINGS:
        return _SPELLINGS[value]
    raise ValueError(f"one of {', '.join(LEVELS)}")


_text = _expect(
    lambda value, n: isinstance(value, str) and len(value) <= n, "a text of at most {longest} characters"
)
_name = _expect(
    lambda value, n: isinstance(value, str) and 0 < len(value) <= n, "a text of 1 to {longest} characters"
)
_flag = _expect(lambda value, _: isinstance(value, bool), "true or false")
_compression = _expect(
    lambda value, _: isinstance(value, str) and value in _COMPRESSIONS, f"one of {', '.join(_COMPRESSIONS)}"
)
_arguments = _expect(
    lambda value, _: isinstance(value, (dict, list)), "an object by field, or an array by position"
)
_status = _expect(
    lambda value, _: type(value) is int and value in range(len(ActionStatus)),
    f"a status of a goal, from 0 to {len(ActionStatus) - 1}",
)

# Each type with the check of its JSON value.
Anything = Annotated[Any, _expect(lambda value, _: True, "anything")]
Text = Annotated[str, _text]
Name = Annotated[str, _name]
Flag = Annotated[bool, _flag]
Count = Annotated[int, _whole(0)]
Size = Annotated[int, _whole(1)]
Seconds = Annotated[float, _seconds]
Number = Annotated[float, _number]
Compression = Annotated[Literal["none", "png", "cbor", "cbor-raw"], _compression]
StatusLevel = Annotated[Level, _level]
Arguments = Annotated[dict[str, Any] | list[Any], _arguments]
Status = Annotated[int, _status]


def read_id(message: dict[str, Any], text_length: int) -> Id:
    """The id of a message, or None.

    Raises:
        FieldError: It is neither a text nor a number, or too long.
    """
    value = message.get("id")
    if value is None or (isinstance(value, (int, float)) and abs(value) < 2**63):  # not a NaN
        return value
    if isinstance(value, str) and len(value) <= text_length:
        return value
    raise FieldError(
        f"field id is {shown(value)}; expected a text of at most {text_length} characters or a number"
    )
