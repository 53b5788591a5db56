"""Values carried between revisions of a type, by field name."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rosproto.codec import define, message_class, service_class
from rosproto.codec.conversion import Conversion, ConversionError, ValuesLost, differences
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


OLD = "int32 a\nP[] p\nP q\nuint8[] u" + "\n" + "=" * 80 + "\nMSG: a/P\nint8 x"
NEW = OLD.replace("int32 a", "int32 a\nstring note\nfloat32[] f\ntime t").replace(
    "int8 x", "int8 x\nint8 y\nint8[] z"
)


def test_values_that_would_get_lost() -> None:
    """They are named, in arrays and nested messages too, unless they are only defaults."""
    new, old = define("a/Lossy", NEW), define("a/Lossy", OLD)
    there, back = Conversion(new, old), Conversion(old, new)
    part = new._binding.class_for("a/P")  # type: ignore[union-attr]
    assert repr(there) == f"<Conversion a/Lossy {new._md5sum[:4]} to {old._md5sum[:4]}>"
    message = new(a=1, p=[part(x=1), part(x=2)], u=b"ab")
    assert back.lost(old(a=5)) == there.lost(message) == []
    there.require_lossless(message)
    message.p[1].y = 3
    message.q.z = [0]
    message.note = "mind the step"
    message.f = np.zeros(2, "f4")
    assert sorted(there.lost(message)) == ["f", "note", "p.y", "q.z"]
    with pytest.raises(ValuesLost, match=r"a/Lossy.*has no place for the values of .*note") as caught:
        there.require_lossless(message)
    assert sorted(caught.value.fields) == ["f", "note", "p.y", "q.z"]
    assert caught.value.theirs is old
    assert there(message).p[1].x == 2
    assert back(there(message)).note == ""


@pytest.mark.parametrize("value", [float("nan"), float("inf"), 0.5, 5e9, -1])
def test_a_number_that_is_not_whole_or_too_large(value: float) -> None:
    """A float becomes an integer only when nothing of it gets lost."""
    conversion = Conversion(define("a/W", "float64 x"), define("a/W", "uint32 x"))
    with pytest.raises(CodecError, match=r"a/W\.x: .* does not fit uint32 \(0 to 4294967295\)"):
        conversion(conversion.source(x=value))
    assert conversion(conversion.source(x=7.0)).x == 7


def test_a_fixed_array_of_another_length_is_refused() -> None:
    """Nothing is cut off and nothing made up; an array of any length takes a fixed one's values."""
    three, two, many = (define("a/F", f"int8[{n}] x\nint8 y") for n in ("3", "2", ""))
    for source, target in [(three, two), (many, two)]:
        with pytest.raises(ConversionError, match=r"values cannot be converted"):
            Conversion(source, target)
    assert list(Conversion(three, many)(three(x=[1, 2, 3])).x) == [1, 2, 3]


def test_nested_messages_of_another_type_are_refused() -> None:
    """By name: a Point is not a Vector3, though their fields are alike."""
    a = define("a/N", "P p" + "\n" + "=" * 80 + "\nMSG: a/P\nint8 x")
    b = define("a/N", "Q p" + "\n" + "=" * 80 + "\nMSG: a/Q\nint8 x")
    c = define("a/N", "P[] p" + "\n" + "=" * 80 + "\nMSG: a/P\nint8 x")
    for source, target in [(a, b), (a, c), (c, a)]:
        with pytest.raises(ConversionError, match=r"a/N\.p: is "):
            Conversion(source, target)


def test_other_spellings_that_are_not_there_either() -> None:
    """A field whose second name the other side lacks as well gets its default."""
    response = service_class("woosh_msgs/ExecTask").Response
    given = define("woosh_msgs/ExecTaskResponse", "bool other\nint8 more")
    names = [name for pair in bundled().field_aliases(response._type) for name in pair]
    assert names
    target = define("woosh_msgs/ExecTaskResponse", f"bool other\nint8 {names[0]}\nint8 third", base=bundled())
    conversion = Conversion(given, target)
    assert conversion.defaulted == [names[0], "third"]
    assert conversion(given(other=True, more=3)) == target(other=True)


def test_a_message_of_one_class_is_copied() -> None:
    """Equal nested types are handed over as they are."""
    odometry = message_class("nav_msgs/Odometry")
    message = odometry(child_frame_id="base")
    copied = Conversion(odometry, odometry)(message)
    assert copied == message
    assert copied is not message
    assert copied.pose is message.pose
