"""Messages to dicts and back, as the command line and JSON need them."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from rosproto.codec import message_class
from rosproto.codec.dicts import fill, from_dict, to_dict
from rosproto.errors import CodecError
from rosproto.time import Time

Twist = message_class("geometry_msgs/Twist")
PoseStamped = message_class("geometry_msgs/PoseStamped")
Polygon = message_class("geometry_msgs/Polygon")
Scan = message_class("sensor_msgs/LaserScan")
MultiArray = message_class("std_msgs/Float64MultiArray")
Int32s = message_class("std_msgs/Int32MultiArray")
String = message_class("std_msgs/String")


def test_to_dict_is_json() -> None:
    """Every value is plain, arrays too, in the definition's order."""
    scan = Scan(ranges=[1.0, math.inf], angle_min=-1.5)
    plain = to_dict(scan, finite=True)
    assert plain["ranges"] == [1.0, None]
    assert list(plain)[:2] == ["header", "angle_min"]
    assert json.loads(json.dumps(plain))["header"]["stamp"] == {"secs": 0, "nsecs": 0}
    assert to_dict(scan)["ranges"][1] == math.inf


@pytest.mark.parametrize(
    "value",
    [
        {"linear": {"x": 0.5}, "angular": {"z": 1}},
        {"linear": [0.5, 0, 0], "angular": {"z": 1.0}},
        [[0.5, 0, 0], [0, 0, 1]],
    ],
)
def test_by_name_and_by_position(value: object) -> None:
    """Dicts name fields, lists take them in order; an int is welcome where a float is meant."""
    twist = from_dict(Twist, value)
    assert (twist.linear.x, twist.angular.z) == (0.5, 1.0)


def test_one_bare_value() -> None:
    """`rostopic pub /say std_msgs/String hello` needs no braces."""
    assert from_dict(String, "hello").data == "hello"
    assert from_dict(String, {"data": None}).data == ""  # `data:` without a value
    with pytest.raises(CodecError, match="5 is not a string; quote it"):
        from_dict(String, 5)  # 007 would be "7"


def test_arrays_of_messages() -> None:
    """Elements are messages of the right class."""
    polygon = from_dict(Polygon, {"points": [{"x": 1}, [4, 5, 6]]})
    assert [(p.x, p.y) for p in polygon.points] == [(1.0, 0.0), (4.0, 5.0)]
    assert from_dict(Polygon, [[{"x": 1}, {"x": 2}]]).points[1].x == 2.0
    assert list(from_dict(MultiArray, {"data": [1, 2]}).data) == [1.0, 2.0]


def test_arrays_of_numpy() -> None:
    """Elements of an array of whole numbers are whole numbers; its own integers are not Python's."""
    assert list(from_dict(Int32s, {"data": np.array([1, -2])}).data) == [1, -2]
    assert list(from_dict(MultiArray, {"data": np.array([1, 2])}).data) == [1.0, 2.0]
    with pytest.raises(CodecError, match="is not a list"):
        from_dict(Int32s, {"data": np.int32(1)})


def test_now_and_auto() -> None:
    """Times can be given as words when there is a clock."""
    now = Time(7, 8)
    assert from_dict(PoseStamped, {"header": "auto"}, now=now).header.stamp == now
    assert from_dict(PoseStamped, {"header": {"stamp": "now"}}, now=now).header.stamp == now
    assert from_dict(PoseStamped, {"header": {"stamp": 1.5}}).header.stamp == Time(1, 500000000)
    assert from_dict(PoseStamped, {"header": {"stamp": {"secs": 3}}}).header.stamp == Time(3, 0)
    with pytest.raises(CodecError, match="no clock"):
        from_dict(PoseStamped, {"header": "auto"})


@pytest.mark.parametrize(
    ("cls", "value", "says"),
    [
        (Twist, {"linaer": {}}, "has no field 'linaer'; it has: linear, angular"),
        (Twist, {"linear": {"q": 1}}, "x, y, z"),
        (Twist, {"linear": {"x": "fast"}}, "'fast' is not a valid float64"),
        (Twist, [1], "1 values given for the 2 fields"),
        (Polygon, {"points": 3}, "is not a list"),
        (PoseStamped, {"header": {"seq": 1.5}}, "is not a valid uint32"),
        (PoseStamped, {"header": {"stamp": "soon"}}, "is not a time"),
        (PoseStamped, {"header": {"seq": -1}}, "-1 is out of range for uint32; expected 0 to 4294967295"),
        (PoseStamped, {"header": {"stamp": {"secs": -1}}}, "-1 is out of range for a time"),
        (String, {"data": [1]}, "is not a string"),
    ],
)
def test_wrong_values_name_the_field(cls: type, value: object, says: str) -> None:
    """A typing error is answered with the path and with what would be right."""
    with pytest.raises(CodecError, match=says):
        from_dict(cls, value)


def test_true_and_false_are_numbers_as_in_genpy() -> None:
    """`rostopic pub` sends 1 and 0 for them, also in arrays and fields of whole numbers."""
    assert from_dict(Twist, {"linear": {"x": True}}).linear.x == 1.0
    assert list(from_dict(MultiArray, {"data": [True, False]}).data) == [1.0, 0.0]
    assert list(from_dict(Int32s, {"data": [True]}).data) == [1]


def test_fill_keeps_what_is_not_named() -> None:
    """Values that are not given stay."""
    twist = Twist()
    twist.linear.y = 3.0
    fill(twist, {"linear": {"x": 1}})
    assert (twist.linear.x, twist.linear.y) == (1.0, 3.0)
    fill(twist, None)
    assert twist.linear.x == 1.0
