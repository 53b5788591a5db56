"""`rosproto.records.NamedTuple` is what `typing.NamedTuple` is, without the cost."""

from __future__ import annotations

import pickle
import typing

import pytest

from rosproto.records import NamedTuple


class Point(NamedTuple):
    """Where something is."""

    x: float
    y: float = 2.0
    frame: str = "map"

    @property
    def sum(self) -> float:
        """Both together."""
        return self.x + self.y

    @classmethod
    def origin(cls) -> Point:
        return cls(0.0, 0.0)


class Genuine(typing.NamedTuple):
    """Where something is."""

    x: float
    y: float = 2.0
    frame: str = "map"


def test_it_has_the_fields_defaults_and_texts_of_the_genuine_one() -> None:
    assert Point._fields == Genuine._fields
    assert Point._field_defaults == Genuine._field_defaults
    assert Point.__annotations__.keys() == Genuine.__annotations__.keys()
    assert typing.get_type_hints(Point) == typing.get_type_hints(Genuine)
    assert Point.__doc__ == Genuine.__doc__
    assert (Point.__module__, Point.__qualname__) == (__name__, "Point")
    assert repr(Point(1.0)) == repr(Genuine(1.0)).replace("Genuine", "Point")


def test_values_behave_as_tuples_with_names() -> None:
    point = Point(1.0, frame="odom")
    assert point == (1.0, 2.0, "odom") == Point(x=1.0, y=2.0, frame="odom")
    assert hash(point) == hash((1.0, 2.0, "odom"))
    assert point._replace(x=5.0).x == 5.0
    assert point._asdict() == {"x": 1.0, "y": 2.0, "frame": "odom"}
    assert pickle.loads(pickle.dumps(point)) == point


def test_methods_and_properties_are_kept() -> None:
    assert Point(1.0).sum == 3.0
    assert Point.origin() == (0.0, 0.0, "map")


def test_values_cannot_be_changed_or_made_of_too_little() -> None:
    with pytest.raises(AttributeError):
        Point(1.0).x = 2.0  # type: ignore[misc]
    with pytest.raises(TypeError, match="x"):
        Point()  # type: ignore[call-arg]
