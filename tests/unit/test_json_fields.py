"""Objects of JSON are read by the annotations of a class; a wrong value is named by its path."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import pytest

from rosproto.json_fields import (
    REQUIRED,
    Anything,
    Expected,
    FieldError,
    Reader,
    flag,
    listed,
    number,
    one_of,
    text,
    whole,
)

Octet = Annotated[int, whole(0, 255)]


class Inner(NamedTuple):
    id: Octet
    label: Annotated[str, text, "innerLabel"] = "none"


@dataclass(frozen=True)
class Outer:
    inner: Annotated[Inner, Reader(Inner)]
    several: Annotated[tuple[Inner, ...], listed(Reader(Inner), max_items=2)] = ()
    value: Anything = 5
    told: Annotated[str, text, REQUIRED] = ""
    ours: int = 7


READ = Reader(Outer)
WHOLE: dict[str, Any] = {"inner": {"id": 1}, "told": "x"}


def test_an_object_is_read_with_those_inside_of_it() -> None:
    """By the names of the JSON; what is left out has its default, and what has no check is not read."""
    given = {
        "inner": {"id": 3.0, "innerLabel": "a"},
        "several": [{"id": 2}],
        "told": "x",
        "ours": 9,
        "more": 1,
    }
    assert READ(given) == Outer(Inner(3, "a"), (Inner(2),), told="x")
    assert type(READ(given).inner.id) is int


def test_null_is_left_out_where_it_is_not_a_value() -> None:
    """A reader may also take null for a value, which then has to fit."""
    assert READ({**WHOLE, "several": None, "value": None}) == Outer(Inner(1), value=None, told="x")
    with pytest.raises(FieldError, match="several is null; expected a list"):
        Reader(Outer, null=True)({**WHOLE, "several": None})


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"inner": None}, "inner is missing; expected an object"),
        ({"inner": [1]}, "inner is an array of 1; expected an object"),
        ({"inner": {"id": 256}}, "inner.id is 256; expected a whole number from 0 to 255"),
        ({"inner": {"id": True}}, "inner.id is true; expected a whole number from 0 to 255"),
        ({"inner": {"id": 1e400}}, "inner.id is Infinity; expected a whole number from 0 to 255"),
        ({"inner": {"id": 1, "innerLabel": 2}}, "inner.innerLabel is 2; expected a text"),
        ({"several": [{"id": 1}, "x"]}, "several[1] is 'x'; expected an object"),
        ({"several": [{"id": 1}, {}]}, "several[1].id is missing; expected a whole number from 0 to 255"),
        ({"several": [{}] * 3}, "several is 3; expected at most 2 of them"),
        ({"told": None}, "told is missing; expected a text"),
    ],
)
def test_a_wrong_value_is_named_by_its_path(changes: dict[str, Any], words: str) -> None:
    """Path, value and what was expected."""
    with pytest.raises(FieldError) as caught:
        READ({**WHOLE, **changes})
    assert str(caught.value) == words


def test_what_is_not_an_object_is_not_read() -> None:
    with pytest.raises(Expected, match="an object"):
        READ([1])


def test_a_wrong_value_deep_inside_is_looked_at_once() -> None:
    """An error costs no more than the reading: no level checks its value a second time."""
    seen = []

    def refuse(value: object, _max_characters: int) -> object:
        seen.append(value)
        raise Expected("something else")

    deep = listed(listed(listed(refuse)))
    with pytest.raises(FieldError) as caught:
        deep([[[1]]], 0)
    assert (caught.value.path, seen) == ("[0][0][0]", [1])


@pytest.mark.parametrize(
    ("check", "good", "wrong"),
    [
        (number(-1.0, 2.0), [-1, 0.5, 2], [True, None, "1", 2.1, 10**400, float("nan"), float("inf"), [1]]),
        (one_of(("a", "b"), "a or b"), ["a", "b"], ["c", None, ["a"], {}, 1]),
        (flag, [True, False], [0, 1, None, "true"]),
        (text, ["", "x"], [None, 1, ["x"]]),
        (whole(0, 3), [0, 3, 2.0], [4, -1, 1.5, True, "1", float("nan"), float("inf"), 10**400]),
    ],
)
def test_a_check_takes_what_it_says(check: Any, good: list[Any], wrong: list[Any]) -> None:
    """And nothing else, of whatever type."""
    assert [check(value, 0) for value in good] == good
    for value in wrong:
        with pytest.raises(Expected):
            check(value, 0)
