"""What the REST API answers to bad requests: hostile bodies, odd addresses, wrong values, errors of the robot."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("uvicorn", reason="needs the extra `web`")
pytest.importorskip("websockets", reason="needs the extra `web`")

from rosproto.admission import AddressBuckets
from tests.support.web import Served, serving
from woosh_pure import Chassis
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.marks import UserMark
from woosh_pure.web.middleware import MAX_BODY


@pytest.fixture
def web(chassis: Chassis, tmp_path: Path) -> Iterator[Served]:
    """A server for one robot."""
    marks = [UserMark("A1", Pose2D(3.0, 1.0, 1.57)), UserMark("C1", Pose2D(-0.9, -3.0), charger=True)]
    with serving(chassis, marks=marks, recordings=tmp_path) as served:
        yield served


HOSTILE: list[Any] = [
    b"",
    b"{",
    b"null",
    b"[]",
    b"1",
    b'"x"',
    b"\xff\xfe",
    b"{}" * 10,
    b"[" * 20000,
    b'{"kind":' * 5000,
    b'{"kind":"move","distance":NaN}',
    b'{"kind":"move","distance":1e999}',
    b'{"kind":"move","distance":"1"}',
    {"kind": "move"},
    {"kind": "fly", "to": "the moon"},
    {"kind": "mark", "mark": ""},
    {"kind": "mark", "mark": 7},
    {"kind": "mark", "mark": "x" * 201},
    {"kind": "move", "distance": 1.0, "avoid": False},
    {"kind": ["move"]},
    {"kind": "pose", "x": True, "y": 0.0},
    {"kind": "pose", "x": 0.0, "y": 0.0, "theta": 1e9},
    {"kind": "move", "distance": 0.1, "timeout": -1},
    {"kind": "move", "distance": 1e300},
    {"kind": "move", "distance": 10.5},
    {"kind": "rotate", "angle": 99.0},
    {"x": 1},
    {"to": None, "seconds": 0},
]
WRITING = ("goals", "pose", "lease", "lease/grant", "recordings", "login")


# Each stop is answered once the robot has been measured to stand: 0.4 s for each body.
@pytest.mark.promise("a message that is not valid ends that connection with an error text")
@pytest.mark.parametrize("path", [*WRITING, pytest.param("stop", marks=pytest.mark.slow)])
def test_hostile_bodies_get_a_sentence_and_move_nothing(web: Served, chassis: Chassis, path: str) -> None:
    access = web.app.state.context.access  # type: ignore[attr-defined]
    for body in HOSTILE:
        access._commands = AddressBuckets(5.0, 10.0)
        raw = body if isinstance(body, bytes) else json.dumps(body).encode()
        answer = web.post(path, raw, headers={"content-type": "application/json"})
        if answer.status >= 400:
            assert answer.status in (400, 401, 409, 422, 429), (path, raw[:80], answer)
            assert answer.problem
        else:
            assert path != "goals", raw[:80]
    assert not chassis.moved or path == "stop"
    assert web.get("status").status == 200


@pytest.mark.promise("a message that is not valid ends that connection with an error text")
def test_a_body_that_is_too_large_is_not_read(web: Served) -> None:
    answer = web.post("goals", b"x" * (MAX_BODY + 1), headers={"content-type": "application/json"})
    assert answer.status == 413
    assert "larger than" in answer.problem
    announced = web.ask("POST", "goals", b"{}", headers={"content-length": "99999999999999999999"})
    assert announced.status in (400, 413)


@pytest.mark.parametrize(
    "path",
    [
        "nothing",
        "goals/999",
        "goals/%00",
        "goals/../../etc/passwd",
        "recordings/7/bag",
        "/..%2f..%2fetc%2fpasswd",
        "/js/../../../__init__.py",
        "camera/color.gif",
        "feeds/%0a",
        "robots/%2e%2e/status",
        "goals/1/wait?timeout=inf",
        "goals/1/wait?timeout=-1",
        "camera/color.jpg?width=999999",
        "feeds/pose/stream?rate=0",
    ],
)
def test_odd_addresses_get_a_sentence(web: Served, path: str) -> None:
    answer = web.get(path)
    assert answer.status in (404, 422), answer
    assert answer.problem


@pytest.mark.promise("driving by velocity needs `--allow-driving`, the lease and")
def test_odd_methods_get_a_sentence(web: Served) -> None:
    for method in ("PUT", "PATCH", "TRACE", "BREW"):
        assert web.ask(method, "status").status == 405
    for path in ("stop", "pose", "lease/grant", "login"):
        assert web.get(path).status in (404, 405), "nothing moves or stops by a GET"


def test_common_mistakes_are_answered_with_what_to_do(web: Served) -> None:
    for method, path, takes in (
        ("GET", "stop", "POST"),
        ("PUT", "stop", "POST"),
        ("PUT", "goals", "GET, HEAD, POST"),
    ):
        other = web.ask(method, path)
        assert (other.status, other.headers["allow"]) == (405, takes)
        assert f"accepts {takes}, not {method}" in other.problem
    assert "see /docs/ for the API" in web.get("statu").problem
    goal = b'{"kind": "mark", "mark": "A1"}'
    form = web.post("goals", goal, headers={"content-type": "application/x-www-form-urlencoded"})
    assert (
        form.problem == "the body is application/x-www-form-urlencoded: send content-type: application/json"
    )
    assert "the body has no type" in web.post("goals", goal).problem
    assert "a body is missing: send a JSON object" in web.post("goals").problem
    quotes = web.post("goals", b"{'kind': 'mark'}", headers={"content-type": "application/json"})
    assert "the body is not JSON: Expecting property name" in quotes.problem
    assert "(at character 1)" in quotes.problem


REFUSED: dict[str, tuple[str, Any, str, str]] = {
    "no kind": ("goals", {}, 'kind is missing; allowed: "mark", "park", "charge",', "缺少 kind"),
    "no such kind": ("goals", {"kind": "fly"}, 'kind is "fly"; allowed: "mark", "park", "charge",', 'kind 的值是 "fly"'),
    "a part is missing": ("goals", {"kind": "move"}, "distance is missing; allowed: a number from -10 to 10 m", "缺少 distance"),
    "a text for a number": ("pose", {"x": "1", "y": 0.0}, 'x is "1"; allowed: a number from -100000 to 100000 m', 'x 的值是 "1"'),
    "degrees": ("pose", {"x": 1, "y": 0, "yaw": 90}, "yaw is 90; allowed: a number from -6.28318531 to 6.28318531 rad", "单位 rad"),
    "too far": ("goals", {"kind": "move", "distance": 10.5}, "distance is 10.5; allowed:", "distance 的值是 10.5"),
    "no way": ("goals", {"kind": "move", "distance": 0}, "the way is 0", "距离或角度是 0"),
    "no angle": ("goals", {"kind": "rotate", "angle": 0, "replace": True}, "the way is 0", "距离或角度是 0"),
    "no time": ("goals", {"kind": "mark", "mark": "A1", "timeout": 0}, "timeout is 0; allowed: a number above 0 and up to 86400 s", "大于 0"),
    "an empty name": ("goals", {"kind": "mark", "mark": ""}, 'mark is ""; allowed: a text of 1 to 200 characters', "1 到 200 个字符"),
    "another part": ("goals", {"kind": "mark", "mark": "A1", "fast": 1}, '"fast" is not known here; known: timeout, replace, kind, mark', "这里没有"),
    "two at once": ("recordings", {"seconds": 0, "camera": 1}, "; camera is 1; allowed: true or false", "true 或 false"),
    "no object": ("lease", [1], "the body is [1]; allowed: a JSON object with seconds", "JSON 对象"),
    "null": ("lease", None, "the body is null; allowed: a JSON object, or no body", "请求体是 null"),
    "a stop": ("stop", {"everything": "no"}, '; but everything is "no"; allowed: true or false', "仍然执行了停止"),
    "no JSON": ("stop", b"{", "; but the body is not JSON:", "请求体不是 JSON"),
    "a long key": ("goals", {"kind": "rotate", "angle": 0}, "Idempotency-Key is", "Idempotency-Key 的值是"),
    "a second goal": ("goals", {"kind": "rotate", "angle": 1}, 'or replace it with "replace": true', '请加上 "replace": true'),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_a_refusal_names_the_part_what_was_found_and_what_is_allowed(web: Served, name: str) -> None:
    path, body, english, chinese = REFUSED[name]
    headers = {"content-type": "application/json"}
    if name == "a long key":
        headers["idempotency-key"] = "k" * 201
    if name == "a second goal":
        web.post("goals", {"kind": "mark", "mark": "B1"})
    raw = body if isinstance(body, bytes) else json.dumps(body).encode()
    refused = [
        web.post(path, raw, headers={**headers, "accept-language": language})
        for language in ("en", "zh-CN,zh;q=0.9,en;q=0.8")
    ]
    web.post("stop")
    assert [answer.status for answer in refused] == [409 if name == "a second goal" else 422] * 2
    assert english in refused[0].problem
    assert chinese in refused[1].problem
    for answer in refused:
        assert "=True" not in answer.problem
        assert "discriminator" not in answer.problem


def test_a_parameter_of_the_address_is_refused_the_same_way(web: Served) -> None:
    assert web.get("goals/1/wait?timeout=0").problem == (
        'timeout is "0"; allowed: a number above 0 and up to 300'
    )
    assert web.get("camera/color.gif").problem == 'form is "gif"; allowed: "jpg", "png"'


@pytest.mark.structure
def test_what_is_said_to_clients_in_place_of_advice_for_python_has_its_chinese() -> None:
    from woosh_pure.language.table import translator_for
    from woosh_pure.web.snapshot import ADVICE

    assert [text for text in ADVICE.values() if not translator_for("zh").has(text)] == []


def test_errors_of_the_robot_are_problems_with_its_sentence(web: Served) -> None:
    refused = web.post("goals", {"kind": "mark", "mark": "no such mark"})
    assert refused.status == 409
    assert "no such mark" in refused.problem
    assert web.get("journal").json[-1]["state"] == "refused"
