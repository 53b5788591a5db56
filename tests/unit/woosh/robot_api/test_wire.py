"""`wire`: bodies of the Robot API become values and values bodies, by the table of types."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosproto.errors import CodecError
from woosh_pure.robot_api import wire

LIMITS = {"int32": (-(2**31), 2**31 - 1), "uint32": (0, 2**32 - 1), "fixed32": (0, 2**32 - 1)}
LIMITS |= {"int64": (-(2**63), 2**63 - 1), "uint64": (0, 2**64 - 1)}


# -- the table -----------------------------------------------------------------------------------------------


def test_the_table_names_every_type_that_it_uses() -> None:
    """A field's type is a scalar, an enum or a message of the table; requests, answers and topics are messages."""
    known = {*wire.messages(), *LIMITS, "float", "bool", "bytes", "string"}
    for message in wire.messages():
        for field in wire.fields(message):
            assert field.type in known or wire.enum(field.type), (message, field)
    assert set(wire.topics()) | set(wire.requests()) <= known
    assert {request.answer for request in wire.requests().values()} <= known


def test_the_table_has_the_sizes_of_the_interface() -> None:
    assert (len(wire.requests()), len(wire.topics()), len(wire.messages())) == (70, 22, 195)
    assert {request.kind for request in wire.requests().values()} == {"read", "change", "move"}


def test_what_moves_the_robot_is_never_called_a_read() -> None:
    """A gateway that answers reads only relies on it."""
    moving = {"Twist", "ExecTask", "ExecPreTask", "ActionOrder", "Follow", "ChangeNavPath", "ChangeNavMode"}
    kinds = {name.removeprefix("woosh.robot."): request.kind for name, request in wire.requests().items()}
    assert {kinds[name] for name in moving} | {kinds["woosh.ros.CallAction"]} == {"move"}
    assert kinds["SwitchMap"] == kinds["SetRobotPose"] == kinds["setting.AutoCharge"] == "change"


def test_an_answer_names_its_own_type() -> None:
    requests = wire.requests()
    assert requests["woosh.robot.SwitchWorkMode"] == ("change", "woosh.robot.Mode", False)
    assert requests["woosh.robot.Twist"] == ("move", "woosh.robot.Twist", True)


def test_types_have_paths_and_paths_types() -> None:
    for name in wire.requests():
        assert wire.type_of(wire.path_of(name)) == name
    assert wire.path_of("woosh.map.mark.storage.Find") == "/woosh/map/mark/storage/Find"
    for path in (
        "/woosh/robot/Nothing",
        "woosh/robot/Twist",
        "/woosh.robot.Twist",
        "//woosh/robot/Twist",
        "",
        "/",
    ):
        assert wire.type_of(path) is None


# -- reading -------------------------------------------------------------------------------------------------


def test_defaults_are_filled_in_but_sub_messages_and_members_of_a_oneof_are_not() -> None:
    assert wire.load("woosh.robot.PoseSpeed", {}) == {"mapId": 0, "mileage": 0}
    assert wire.load("woosh.robot.PoseSpeed", {"twist": {}, "robotId": 0}) == {
        "twist": {"linear": 0.0, "angular": 0.0},
        "mapId": 0,
        "mileage": 0,
        "robotId": 0,
    }
    assert wire.load("woosh.robot.Twist", None) == {"linear": 0.0, "angular": 0.0, "linearY": 0.0}
    assert wire.load("woosh.robot.SwitchMap", {"fileDatas": None}) == {
        "sceneName": "",
        "mapName": "",
        "fileDatas": [],
    }


def test_both_spellings_are_taken() -> None:
    """Manuals and owners send both, mixed."""
    body = {"scene_name": "hall", "mapName": "ground", "file_datas": [{"name": "a", "data": "AA=="}]}
    assert wire.load("woosh.robot.SwitchMap", body) == {
        "sceneName": "hall",
        "mapName": "ground",
        "fileDatas": [{"name": "a", "data": b"\0"}],
    }


@pytest.mark.parametrize(
    ("kind", "field", "given", "value"),
    [
        ("woosh.robot.Twist", "linear", "0.25", 0.25),
        ("woosh.robot.Twist", "linear", 1, 1.0),
        ("woosh.robot.Twist", "linear", "-Infinity", -math.inf),
        ("woosh.robot.Twist", "linear", math.inf, math.inf),
        ("woosh.robot.ExecTask", "taskId", "-9223372036854775808", -(2**63)),
        ("woosh.robot.ExecTask", "taskId", 4711, 4711),
        ("woosh.robot.ExecTask", "taskId", 4711.0, 4711),
        ("woosh.robot.ExecTask", "taskId", "1e3", 1000),
        ("woosh.robot.ExecTask", "type", "kCharge", 3),
        ("woosh.robot.ExecTask", "type", "3", 3),
        ("woosh.robot.ExecTask", "type", 777, 777),
        ("woosh.robot.ExecTask", "custom", "-_8", b"\xfb\xff"),
        ("woosh.robot.ExecTask", "custom", "+/8=", b"\xfb\xff"),
        ("woosh.robot.setting.Sound", "mute", True, True),
        ("woosh.robot.Speak", "text", "你好", "你好"),
    ],
)
def test_a_reader_takes_what_other_writers_write(kind: str, field: str, given: object, value: object) -> None:
    assert wire.load(kind, {field: given})[field] == value


def test_not_a_number_is_read_as_a_word_and_as_a_text() -> None:
    ranges = wire.load("woosh.robot.ScannerData", json.loads('{"ranges": [1, NaN, "NaN", "Infinity"]}'))[
        "ranges"
    ]
    assert (ranges[0], ranges[3]) == (1.0, math.inf)
    assert math.isnan(ranges[1])
    assert math.isnan(ranges[2])


@pytest.mark.parametrize(
    ("kind", "body", "says"),
    [
        ("woosh.robot.Twist", [], "an array of 0 given; expected an object"),
        ("woosh.robot.Twist", "x", "'x' given; expected an object"),
        (
            "woosh.robot.Twist",
            {"linear": "fast"},
            r"woosh.robot.Twist.linear: 'fast' given; expected a number",
        ),
        ("woosh.robot.Twist", {"linear": "1_0"}, "expected a number"),
        ("woosh.robot.Twist", {"linear": " 1"}, "expected a number"),
        ("woosh.robot.Twist", {"linear": "nan"}, "expected a number"),
        ("woosh.robot.Twist", {"linear": True}, "expected a number"),
        ("woosh.robot.Twist", {"linear": 1e39}, "within float32"),
        (
            "woosh.robot.Twist",
            {"linear": 10**400},
            "a number of more than 64 bits given; expected a number within",
        ),
        ("woosh.robot.ExecTask", {"taskId": 2**63}, "expected a whole number from"),
        ("woosh.robot.ExecTask", {"taskId": "9" * 5000}, "expected a whole number from"),
        ("woosh.robot.ExecTask", {"taskId": 0.5}, "expected a whole number from"),
        ("woosh.robot.ExecTask", {"taskId": True}, "expected a whole number from"),
        ("woosh.robot.ExecTask", {"type": "kNothing"}, "a number or a name of woosh.task.Type"),
        ("woosh.robot.ExecTask", {"custom": "?"}, "bytes as base64"),
        ("woosh.robot.ExecTask", {"custom": 5}, "bytes as base64"),
        ("woosh.robot.ExecTask", {"pose": {"x": []}}, r"ExecTask.pose.x: an array of 0 given"),
        ("woosh.robot.setting.Sound", {"mute": 1}, "true or false"),
        ("woosh.robot.Speak", {"text": 5}, "expected a text"),
        ("woosh.robot.Speak", {"text": "\ud800"}, "a text of whole characters"),
        ("woosh.robot.SwitchMap", {"fileDatas": {}}, "an object of 0 given; expected an array"),
        ("woosh.robot.SwitchMap", {"fileDatas": [None]}, r"fileDatas\[0\]: null given; expected an object"),
        (
            "woosh.ros.CallAction",
            {"moveBase": {}, "stepControl": {}},
            "is there, too; expected only one of them",
        ),
        ("woosh.robot.Nothing", {}, "'woosh.robot.Nothing' is not a message of the Robot API"),
    ],
)
def test_a_value_that_does_not_fit_is_named(kind: str, body: object, says: str) -> None:
    with pytest.raises(CodecError, match=says):
        wire.load(kind, body)


def test_unknown_fields_are_left_out_unless_a_person_typed_them() -> None:
    body = {"linear": 1, "newField": {"deep": [[[]]]}}
    assert wire.load("woosh.robot.Twist", body) == {"linear": 1.0, "angular": 0.0, "linearY": 0.0}
    with pytest.raises(CodecError, match="has no field 'newField'; it has: linear, angular, linearY"):
        wire.dump("woosh.robot.Twist", body)


def test_the_lists_of_a_body_have_a_limit_together(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(wire, "MAX_VALUES", 5)
    path = {"poses": [{}, {}]}
    assert len(wire.load("woosh.robot.PlanPath", {"planPath": [{"path": path}]})["planPath"]) == 1
    with pytest.raises(CodecError, match=r"planPath\[1\].path.poses: the lists have more than 5 elements"):
        wire.load("woosh.robot.PlanPath", {"planPath": [{"path": path}, {"path": path}]})


# -- writing -------------------------------------------------------------------------------------------------


def test_a_robot_writes_zeros_and_a_client_leaves_them_out() -> None:
    values = wire.load("woosh.robot.PoseSpeed", {"twist": {"linear": 0.5}, "robotId": 0})
    assert wire.dump("woosh.robot.PoseSpeed", values) == {
        "twist": {"linear": 0.5, "angular": 0.0},
        "mapId": 0,
        "mileage": 0,
        "robotId": 0,
    }
    assert wire.dump("woosh.robot.PoseSpeed", values, zeros=False) == {"twist": {"linear": 0.5}, "robotId": 0}
    assert wire.dump("woosh.robot.Twist", {}, zeros=False) == {}
    assert wire.dump("woosh.robot.TaskHistory", {}) == {"tes": []}


def test_numbers_that_json_cannot_hold_are_texts() -> None:
    assert wire.dump("woosh.robot.TaskProc", {"robotTaskId": 140103000000}, zeros=False) == {
        "robotTaskId": "140103000000"
    }
    ranges = np.array([0.5, np.nan, np.inf, -np.inf], np.float32)
    assert wire.dump("woosh.robot.ScannerData", {"ranges": ranges}, zeros=False) == {
        "ranges": [0.5, "NaN", "Infinity", "-Infinity"]
    }
    assert wire.dump("woosh.common.FileData", {"data": b"\xfb\xff"}, zeros=False) == {"data": "+/8="}


def test_only_known_fields_are_written() -> None:
    """The vendor's client throws a whole message away for one field that it does not know."""
    with pytest.raises(CodecError, match="has no field 'speed'"):
        wire.dump("woosh.robot.Twist", {"speed": 1})
    with pytest.raises(CodecError, match=r"linear: 'x' given; expected a number"):
        wire.dump("woosh.robot.Twist", {"linear": "x"})


def scalars(kind: str) -> st.SearchStrategy[Any]:
    if kind in LIMITS:
        return st.integers(*LIMITS[kind])
    if kind == "float":
        return st.floats(width=32, allow_nan=False)
    return {"bool": st.booleans(), "bytes": st.binary(max_size=9), "string": st.text(max_size=9)}.get(
        kind, st.integers(-(2**31), 2**31 - 1)
    )


@st.composite
def values_of(draw: st.DrawFn, kind: str) -> wire.Values:
    found: wire.Values = {}
    chosen: set[str] = set()
    for field in wire.fields(kind):
        one = values_of(field.type) if field.type in wire.messages() else scalars(field.type)
        if field.repeated:
            found[field.key] = draw(st.lists(one, max_size=2))
        elif field.oneof or field.type in wire.messages():
            if field.oneof not in chosen and draw(st.booleans()):
                chosen |= {field.oneof} - {""}
                found[field.key] = draw(one)
        else:
            found[field.key] = draw(one)
    return found


@given(st.data(), st.sampled_from(sorted(wire.messages())), st.booleans())
def test_what_is_written_is_read_again(data: st.DataObject, kind: str, zeros: bool) -> None:
    """Through a JSON text, for every message of the table."""
    values = data.draw(values_of(kind))
    text = json.dumps(wire.dump(kind, values, zeros), allow_nan=False)
    assert wire.load(kind, json.loads(text)) == values
    assert wire.dump(kind, json.loads(text), zeros) == json.loads(text), "no other fields"


anything = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner, max_size=3),
)


@given(st.data(), st.sampled_from(sorted(wire.messages())))
def test_any_json_gives_values_or_a_documented_error(data: st.DataObject, kind: str) -> None:
    names = [name for field in wire.fields(kind) for name in (field.name, field.key)] or ["none"]
    body = data.draw(st.dictionaries(st.sampled_from(names), anything, max_size=6) | anything)
    try:
        values = wire.load(kind, body)
    except CodecError:
        return
    json.dumps(wire.dump(kind, values), allow_nan=False)


# -- frames --------------------------------------------------------------------------------------------------


def test_a_request_leaves_out_what_is_zero() -> None:
    """A zero velocity arrives as an empty body."""
    assert wire.dump("woosh.robot.Twist", {"linear": 0.0}, zeros=False) == {}
    assert wire.dump("woosh.robot.Twist", {"linear": -0.5}, zeros=False) == {"linear": -0.5}
    with pytest.raises(CodecError, match="has no field 'linaer'"):
        wire.dump("woosh.robot.Twist", {"linaer": 1}, zeros=False)


def test_an_answer_repeats_the_number_of_its_request() -> None:
    assert wire.answer("woosh.robot.Mode", {"ctrl": 1, "robotId": 7}, sn=3) == {
        "type": "woosh.robot.Mode",
        "body": {"ctrl": 1, "work": 0, "robotId": 7},
        "ok": True,
        "msg": "",
        "sn": 3,
    }
    assert wire.answer("woosh.robot.What", ok=False, msg="no such request") == {
        "type": "woosh.robot.What",
        "body": {},
        "ok": False,
        "msg": "no such request",
    }


def test_an_answer_differs_from_a_push() -> None:
    """Only an answer has `ok` and `msg`."""
    push = wire.push("woosh.robot.RobotState", {"state": 2})
    assert push == {"type": "woosh.robot.RobotState", "body": {"state": 2}}
