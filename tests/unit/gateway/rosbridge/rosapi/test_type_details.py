"""Typedefs: fields, arrays, examples and constants as in rosapi."""

from __future__ import annotations

import pytest

from rosproto.gateway.rosbridge.rosapi.types import MAX_TYPES, type_details
from rosproto.msg import Field, FieldType, MessageSpec, bundled, library_from_full_text


def test_a_message_and_what_it_uses_in_order() -> None:
    """Depth first, each type once, times as a type of their own."""
    library = bundled()
    found = type_details(library.message("geometry_msgs/PoseStamped"), library.message)
    assert [d["type"] for d in found] == [
        "geometry_msgs/PoseStamped", "std_msgs/Header", "time",
        "geometry_msgs/Pose", "geometry_msgs/Point", "geometry_msgs/Quaternion",
    ]  # fmt: skip
    assert found[0]["examples"] == ["{}", "{}"]
    assert found[1]["fieldtypes"] == ["uint32", "time", "string"]
    assert found[1]["examples"] == ["0", "{}", ""]
    assert found[2]["fieldnames"] == ["secs", "nsecs"]
    assert found[4]["examples"] == ["0.0", "0.0", "0.0"]


def test_arrays_constants_and_odd_builtins() -> None:
    """-1 for no array, 0 for any length, else the length; constants by name; char and byte are numbers."""
    text = "byte Z=7\nstring A=a # b\nbool YES=True\nfloat32 F=0.5\nchar c\nbyte b\nuint8[] d\nbool[4] e\nbool f\nduration g"
    library = library_from_full_text("my_msgs/All", text)
    (all_, duration) = type_details(library.message("my_msgs/All"), library.message)
    assert all_["fieldtypes"] == ["char", "byte", "uint8", "bool", "bool", "duration"]
    assert all_["fieldarraylen"] == [-1, -1, 0, 4, -1, -1]
    assert all_["examples"] == ["0", "0", "[]", "[]", "False", "{}"]
    assert all_["constnames"] == ["A", "F", "YES", "Z"]
    assert all_["constvalues"] == ["a # b", "0.5", "True", "7"]
    assert duration["type"] == "duration"


@pytest.mark.promise("a million characters at most, a parameter's value 32 levels, an answer 300 types")
def test_a_definition_without_end_gives_a_bounded_answer() -> None:
    """What robots say of their types is anybody's."""

    def find(name: str) -> MessageSpec:
        number = int(name[3:])
        return MessageSpec(name, (Field("f", FieldType(f"m/T{number + 1}")),), (), "")

    def many(name: str) -> MessageSpec:
        return MessageSpec(name, (), (), "")

    wide = MessageSpec("m/W", tuple(Field(f"f{i}", FieldType(f"m/T{i}")) for i in range(5000)), (), "")
    assert len(type_details(wide, many)) <= MAX_TYPES
    assert len(type_details(find("m/T0"), find)) <= MAX_TYPES
    assert (
        type_details(MessageSpec("m/A", (Field("a", FieldType("m/A", True)),), (), ""), find)[0]["type"]
        == "m/A"
    )
