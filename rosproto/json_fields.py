"""Read JSON objects from outside into dataclasses and named tuples. Pure.

The annotation of each field holds the check of its JSON value, and its name in the JSON if that differs:

    class Channel(NamedTuple):
        id: Annotated[int, whole(0, 255)]
        schema_name: Annotated[str, text, "schemaName"] = ""

`Reader(Channel)` reads it. A field without a default is required; other fields of the JSON are ignored. A
wrong value raises `FieldError` with its path. A reader is a check itself, for objects inside of others.
"""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any, Generic, NamedTuple, TypeVar, get_args, get_type_hints

from rosproto.text import short

__all__ = [
    "MISSING", "REQUIRED", "Anything", "Check", "Expected", "Field", "FieldError", "Reader", "fits", "flag",
    "listed", "number", "one_of", "shown", "text", "whole",
]  # fmt: skip

T = TypeVar("T")
Check = Callable[[object, int], T]
"""(JSON value, longest text) -> value; raises `Expected`. The second is the caller's limit, for checks that
have none."""

MISSING = object()
"""The value of a field that is not there."""
REQUIRED = object()
"""In the annotation of a field that has a default, but is required in JSON."""


class Expected(ValueError):
    """A value does not fit; the text says what was expected."""


class FieldError(ValueError):
    """A field is missing or wrong.

    Attributes:
        path: Its place, such as "channels[1].topic".
        expected: The expected value, in words.
        value: The received value; `MISSING` without one.
    """

    def __init__(self, path: str, expected: str, value: object) -> None:
        self.path, self.expected, self.value = path, expected, value
        super().__init__(f"{path} is {shown(value)}; expected {expected}")

    def inside(self, outer: str) -> FieldError:
        """The same error, of a field inside of another one."""
        dot = "" if self.path[:1] in ("", "[") else "."
        return FieldError(f"{outer}{dot}{self.path}", self.expected, self.value)


def shown(value: object) -> str:
    """A value from outside for a sentence: short, on one line."""
    if value is MISSING:
        return "missing"
    if isinstance(value, (dict, list)):
        return f"{'an object' if isinstance(value, dict) else 'an array'} of {len(value)}"
    if isinstance(value, str):
        return repr(short(value))
    if isinstance(value, int) and value.bit_length() > 64:
        return "a number of more than 64 bits"
    return json.dumps(value)


# -- checks --------------------------------------------------------------------------------------------------


def fits(test: Callable[[object, int], bool], expected: str) -> Check[object]:
    """A check that takes a value as it is, if it fits; `{max_characters}` in the text is the longest text."""

    def check(value: object, max_characters: int) -> object:
        if test(value, max_characters):
            return value
        raise Expected(expected.format(max_characters=max_characters))

    return check


def whole(low: int, high: int, expected: str = "") -> Check[int]:
    """A check for whole numbers, also those that are written as 3.0."""
    expected = expected or f"a whole number from {low} to {high}"

    def check(value: object, _max_characters: int) -> int:
        number = int(value) if isinstance(value, float) and value.is_integer() else value
        if type(number) is int and low <= number <= high:
            return number
        raise Expected(expected)

    return check


def number(low: float, high: float, expected: str = "a number") -> Check[float]:
    """A check for finite numbers, which become floats."""

    def check(value: object, _max_characters: int) -> float:
        if (type(value) is int or type(value) is float) and low <= value <= high:
            return float(value)
        raise Expected(expected)

    return check


def one_of(words: Sequence[str], expected: str) -> Check[object]:
    """A check for one of a few texts."""
    return fits(lambda value, _: isinstance(value, str) and value in words, expected)


def listed(check: Check[T], max_items: int | None = None, expected: str = "a list") -> Check[tuple[T, ...]]:
    """A check that makes a tuple of a list; `check` is that of the items."""

    def read(value: object, max_characters: int) -> tuple[T, ...]:
        if not isinstance(value, list):
            raise Expected(expected)
        if max_items is not None and len(value) > max_items:
            raise FieldError("", f"at most {max_items} of them", len(value))
        found = []
        for item in value:
            try:
                found.append(check(item, max_characters))
            except (Expected, FieldError) as error:
                raise _at(f"[{len(found)}]", error, item) from None
        return tuple(found)

    return read


def _at(place: str, error: Expected | FieldError, value: object) -> FieldError:
    return error.inside(place) if isinstance(error, FieldError) else FieldError(place, str(error), value)


flag = fits(lambda value, _: isinstance(value, bool), "true or false")
text = fits(lambda value, _: isinstance(value, str), "a text")
_anything = fits(lambda value, _: value is not MISSING, "any value")
Anything = Annotated[Any, _anything]
"""A field with any value; null is a value, too."""


# -- objects -------------------------------------------------------------------------------------------------


class Field(NamedTuple):
    """A field of an object: its name in the JSON, the attribute, the check, and whether it is required."""

    name: str
    attribute: str
    check: Check[object]
    required: bool
    takes_null: bool


class Reader(Generic[T]):
    """Reads objects; made once for a class.

    Args:
        make: The class. Fields without a check in their annotation are not read.
        null: Null is a value and needs to fit; by default, it counts as left out.

    Attributes:
        make: The class.
        fields: The fields that are read.
    """

    def __init__(self, make: Callable[..., T], *, null: bool = False) -> None:
        self.make = make
        hints = get_type_hints(make, include_extras=True)
        self.fields = tuple(
            found
            for each in inspect.signature(make).parameters.values()
            for found in _field(each, hints[each.name], null)
        )

    def arguments(self, document: Mapping[str, object], max_characters: int = 0) -> dict[str, Any]:
        """The fields of an object by attribute; those left out are not in it.

        Raises:
            FieldError: A field is missing or wrong.
        """
        found = {}
        for name, attribute, check, required, takes_null in self.fields:
            value = document.get(name)
            if value is None and not (takes_null and name in document):
                if not required:
                    continue
                value = MISSING
            try:
                found[attribute] = check(value, max_characters)
            except (Expected, FieldError) as error:
                raise _at(name, error, value) from None
        return found

    def __call__(self, value: object, max_characters: int = 0) -> T:
        """Read an object.

        Raises:
            Expected: It is not an object.
            FieldError: A field is missing or wrong.
        """
        if not isinstance(value, dict):
            raise Expected("an object")
        return self.make(**self.arguments(value, max_characters))


def _field(each: inspect.Parameter, hint: object, null: bool) -> list[Field]:
    # `Annotated[...]`, or `Annotated[...] | None`
    marks = [mark for one in (hint, *get_args(hint)) for mark in getattr(one, "__metadata__", ())]
    checks = [mark for mark in marks if callable(mark)]
    if not checks:
        return []
    names = [mark for mark in marks if isinstance(mark, str)]
    required = each.default is each.empty or REQUIRED in marks
    return [Field((names or [each.name])[0], each.name, checks[0], required, null or checks[0] is _anything)]
