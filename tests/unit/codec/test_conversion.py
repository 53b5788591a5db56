"""Values carried between revisions of a type, by field name."""

from __future__ import annotations

import math

import pytest

from rosproto.codec import define, message_class, service_class
from rosproto.codec.comparison import differences
from rosproto.codec.conversion import Conversion, ConversionError
from rosproto.errors import CodecError
from rosproto.msg import bundled


def revision(name: str, label: str) -> type:
    """A message class as of a revision."""
    found = next(r for r in bundled().revisions(name) if r.label == label)
    return message_class(name, found.library)


@pytest.mark.parametrize(
    "name", ["woosh_msgs/Battery", "woosh_msgs/Parameter", "woosh_msgs/StepControlGoal", "woosh_msgs/MoveBaseGoal",
             "woosh_msgs/NavigationModeGoal", "woosh_msgs/ArmGoal", "woosh_msgs/StepControlActionGoal",
             "woosh_msgs/Information"],
)  # fmt: skip
def test_every_known_revision_converts_both_ways(name: str) -> None:
    """What both sides have arrives; nothing needs an error."""
    current = message_class(name)
    revisions = bundled().revisions(name)
    assert revisions
    for found in revisions:
        other = message_class(name, found.library)
        there, back = Conversion(current, other), Conversion(other, current)
        assert type(there(current())) is other
        assert back(there(current())) == current()
        assert sorted(there.dropped) == sorted(back.defaulted)


def test_order_does_not_matter() -> None:
    """The page lists Battery's fields in another order; the values find their place."""
    battery = message_class("woosh_msgs/Battery")(bmsStatus=7, cellVoltageMax=3.5, batteryPercentage=80)
    page = Conversion(type(battery), revision("woosh_msgs/Battery", "page"))(battery)
    assert (page.bmsStatus, page.cellVoltageMax, page.batteryPercentage) == (7, 3.5, 80)
    assert page.__slots__ != battery.__slots__


def test_what_one_side_lacks() -> None:
    """It is dropped one way and has its default the other way, in arrays of messages too."""
    goal_class = message_class("woosh_msgs/StepControlGoal")
    step_class = message_class("woosh_msgs/StepControl")
    old_class = revision("woosh_msgs/StepControlGoal", "1.1.0")
    conversion = Conversion(goal_class, old_class)
    assert conversion.dropped == ["stepControl.angle"]
    old = conversion(goal_class(mode=1, stepControl=[step_class(executeMode=1, data=0.5, angle=0.3)]))
    assert not hasattr(old.stepControl[0], "angle")
    back = Conversion(old_class, goal_class)(old)
    assert (back.stepControl[0].data, back.stepControl[0].angle) == (0.5, 0.0)


def test_another_width_is_range_checked() -> None:
    """uint32 and float32 of pulsePerCircle: whole numbers in range pass, others are errors that name the field."""
    current = message_class("woosh_msgs/Parameter")
    page = revision("woosh_msgs/Parameter", "page")
    assert Conversion(current, page)(current(pulsePerCircle=5600)).pulsePerCircle == 5600.0
    back = Conversion(page, current)
    assert back(page(pulsePerCircle=5600.0)).pulsePerCircle == 5600
    for wrong in (0.5, -1.0, 1e10, math.nan, math.inf):
        with pytest.raises(CodecError, match=r"pulsePerCircle.*does not fit uint32"):
            back(page(pulsePerCircle=wrong))


def test_a_changed_kind_is_refused_with_both_definitions() -> None:
    """Text for a number cannot be carried over; the error shows the two side by side."""
    ours = define("test_msgs/Thing", "float64 speed\nstring name")
    theirs = define("test_msgs/Thing", "float64 speed\nuint8 name")
    with pytest.raises(ConversionError, match="is uint8 on one side and string on the other") as caught:
        Conversion(theirs, ours)
    assert "! string name" in caught.value.table
    assert caught.value.field_path == "name"
    assert [tuple(d) for d in differences(ours._spec, theirs._spec)] == [("name", "string", "uint8")]


@pytest.mark.parametrize(
    ("ours", "theirs"),
    [("int32 a", "int32[] a"), ("int32[3] a", "int32[4] a"), ("time a", "float64 a"), ("bool a", "uint8 a")],
)
def test_kinds_that_are_not_the_same(ours: str, theirs: str) -> None:
    """A value and an array, arrays of two lengths, a time and a number, a flag and a number."""
    with pytest.raises(ConversionError):
        Conversion(define("test_msgs/T", theirs), define("test_msgs/T", ours))


def test_arrays_of_another_width() -> None:
    """Each element is checked."""
    wide, narrow = define("test_msgs/T", "int32[] a"), define("test_msgs/T", "uint8[] a")
    assert list(Conversion(wide, narrow)(wide(a=[1, 255])).a) == [1, 255]
    with pytest.raises(CodecError, match="256 does not fit"):
        Conversion(wide, narrow)(wide(a=[256]))


def test_page_spelling_in_python() -> None:
    """`task_exec` and `statuscode` work beside the wire's spelling."""
    exec_task = service_class("woosh_msgs/ExecTask")
    request = exec_task.Request(task_exec=1, mark_no="A1")
    assert request.task_exect == 1
    request.task_exec = 4
    assert request.task_exect == 4
    assert exec_task.Response(statusCode=2).statuscode == 2
    assert "task_exec" not in exec_task.Request.__slots__


def test_page_spelling_on_the_wire() -> None:
    """A robot that spells as the page does gets the value under its own name, and answers in it."""
    found = next(r for r in bundled().revisions("woosh_msgs/ExecTask", kind="srv") if r.label == "page")
    ours, theirs = service_class("woosh_msgs/ExecTask"), service_class("woosh_msgs/ExecTask", found.library)
    assert "task_exec" in theirs.Request.__slots__
    request = Conversion(ours.Request, theirs.Request)(ours.Request(task_exect=4))
    assert request.task_exec == 4
    assert request.task_exect == 4
    assert Conversion(theirs.Response, ours.Response)(theirs.Response(statuscode=8)).statusCode == 8


def test_definitions_that_share_no_field() -> None:
    """All defaults would look like values: that is refused."""
    ours, theirs = define("test_msgs/T", "float64 charge"), define("test_msgs/T", "float64 percent")
    with pytest.raises(ConversionError, match="share no field"):
        Conversion(theirs, ours)
    empty = define("test_msgs/T", "")
    assert Conversion(theirs, empty)(theirs(percent=1.0)) == empty()


def test_fields_called_like_keywords() -> None:
    """Python's keywords are names in ROS like all others."""
    ours, theirs = (
        define("my_msgs/K", "uint8 class\nuint16 from\nstring pass"),
        define("my_msgs/K", "uint8 from\nuint8 class"),
    )
    made = Conversion(theirs, ours)(theirs(**{"from": 3, "class": 4}))
    assert [getattr(made, name) for name in ("class", "from", "pass")] == [4, 3, ""]
    assert made == ours(**{"class": 4, "from": 3})


def test_defaults_are_not_shared() -> None:
    """A field the other side lacks is a fresh value in each message."""
    ours, theirs = (
        define("my_msgs/D", "uint8 a\nstring[] names\nfloat32[2] pair"),
        define("my_msgs/D", "uint8 a"),
    )
    conversion = Conversion(theirs, ours)
    one, two = conversion(theirs(a=1)), conversion(theirs(a=2))
    one.names.append("x")
    assert (two.names, list(two.pair)) == ([], [0.0, 0.0])
    assert one.a == 1
