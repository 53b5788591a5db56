"""Convert values to what JSON can express. Pure."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from enum import Enum
from typing import Any, TypeAlias

__all__ = ["JsonValue", "plain"]

JsonValue: TypeAlias = "bool | int | float | str | list[JsonValue] | dict[str, JsonValue] | None"
"""What a JSON text can hold, for type checkers."""


def plain(
    value: object,
    *,
    finite: bool = True,
    names: bool = True,
    octets: Callable[[Any], object] = list,
    text: Callable[[str], str] = str,
) -> Any:
    """Convert a value to dicts, lists, str, int, float, bool and None.

    Messages and dataclasses become dicts by field, times `{"secs", "nsecs"}`, arrays and sets lists, and what
    is none of these its text.

    Args:
        value: Any value.
        finite: Replace NaN and infinities, which JSON lacks, by None.
        names: Enums become their names, not their values; those of texts always become their texts.
        octets: Converts bytes; by default to a list of numbers.
        text: Converts each text, except for keys.
    """

    def one(value: Any) -> object:
        kind = type(value)
        if value is None or kind is int or kind is bool:
            return value
        if isinstance(value, Enum):
            return value.name if names and not isinstance(value, str) else one(value.value)
        if isinstance(value, str):
            return text(value)
        if isinstance(value, float):
            return float(value) if not finite or math.isfinite(value) else None
        if isinstance(value, int):
            return int(value)
        if isinstance(value, (bytes, bytearray, memoryview)):
            return octets(value)
        if isinstance(value, (list, tuple, set, frozenset)):
            return [one(item) for item in value]
        if isinstance(value, Mapping):
            return {str(key): one(item) for key, item in value.items()}
        # A message before the others: its fields may have any name, `tolist` too.
        fields = getattr(value, "__dataclass_fields__", None)  # without the slow import of `dataclasses`
        if hasattr(value, "_slot_types"):
            fields = value.__slots__
        if fields is not None:
            return {name: one(getattr(value, name)) for name in fields}
        if hasattr(value, "tolist"):  # a number or an array of numpy
            return one(value.tolist())
        if hasattr(value, "secs") and hasattr(value, "nsecs"):
            return {"secs": value.secs, "nsecs": value.nsecs}
        return text(str(value))

    return one(value)
