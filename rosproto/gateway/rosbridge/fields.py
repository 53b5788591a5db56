"""The fields of a rosbridge message: one type for each kind of field, with the check of its JSON value.

`operations.py` says which operation has which fields.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal

from rosproto.gateway.rosbridge.action_mapping import ActionStatus
from rosproto.gateway.rosbridge.status_levels import Level, level_named
from rosproto.text import printable

LARGEST = 2**31 - 1
"""The largest whole number; larger sizes, rates and counts make no sense."""
_SHOWN = 60  # characters of a wrong value in a sentence
_COMPRESSIONS = ("none", "png", "cbor", "cbor-raw")

Id = str | float | None
"""The client's id of a request, repeated in every answer. A number may have any JSON form."""


class FieldError(Exception):
    """A field is missing or wrong; the text is a sentence for the client."""


Check = Callable[[Any, int], Any]
"""(value, longest text) -> value; ValueError with what is expected."""


def _text(value: Any, longest: int) -> str:
    if isinstance(value, str) and len(value) <= longest:
        return value
    raise ValueError(f"a text of at most {longest} characters")


def _name(value: Any, longest: int) -> str:
    if isinstance(value, str) and 0 < len(value) <= longest:
        return value
    raise ValueError(f"a text of 1 to {longest} characters")


def _flag(value: Any, _longest: int) -> bool:
    if isinstance(value, bool):
        return value
    raise ValueError("true or false")


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


def _compression(value: Any, _longest: int) -> str:
    if isinstance(value, str) and value in _COMPRESSIONS:
        return value
    raise ValueError(f"one of {', '.join(_COMPRESSIONS)}")


def _level(value: Any, _longest: int) -> str:
    level = level_named(value) if isinstance(value, str) else None
    if level is not None:
        return level
    raise ValueError("one of none, error, warning, info")


def _arguments(value: Any, _longest: int) -> Any:
    if isinstance(value, (dict, list)):
        return value
    raise ValueError("an object by field, or an array by position")


def _status(value: Any, _longest: int) -> int:
    if type(value) is int and value in range(len(ActionStatus)):
        return value
    raise ValueError(f"a status of a goal, from 0 to {len(ActionStatus) - 1}")


def _anything(value: Any, _longest: int) -> Any:
    return value


# Each type with the check of its JSON value.
Anything = Annotated[Any, _anything]
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


def shown(value: Any) -> str:
    """A client's value for a sentence: short, on one line."""
    if isinstance(value, (dict, list)):
        return f"{'an object' if isinstance(value, dict) else 'an array'} of {len(value)}"
    if isinstance(value, str):
        cut = value if len(value) <= _SHOWN else f"{value[:_SHOWN]}..."
        return f"'{printable(cut)}'"
    if isinstance(value, bool) or value is None:
        return {True: "true", False: "false", None: "null"}[value]
    if isinstance(value, int) and value.bit_length() > 64:
        return "a number of more than 64 bits"
    return repr(value)
