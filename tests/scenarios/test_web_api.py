"""The REST API over real sockets, on the simulated chassis: what it answers, and what it refuses in words."""

from __future__ import annotations

import itertools
import json
import struct
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("uvicorn", reason="needs the extra `web`")
pytest.importorskip("websockets", reason="needs the extra `web`")

from tests.support.web import PageClient, Served, serving
from woosh_pure import Chassis
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.marks import UserMark
from woosh_pure.web.middleware import MOST_BODY

TOKEN = "a-long-secret"


@pytest.fixture
def web(chassis: Chassis, tmp_path: Path) -> Iterator[Served]:
    """A server for one robot."""
    marks = [UserMark("A1", Pose2D(3.0, 1.0, 1.57)), UserMark("C1", Pose2D(-0.9, -3.0), charger=True)]
    with serving(chassis, marks=marks, recordings=tmp_path) as served:
        yield served


def test_status_and_snapshot_say_what_the_robot_is(web: Served, chassis: Chassis) -> None:
    chassis.battery.wait(10.0, new=False)
    chassis.pose.wait(10.0, new=False)
    shown = web.get("snapshot").json
    assert shown["battery"]["percent"] > 0
    assert set(shown["pose"]) == {"x", "y", "yaw", "theta"}
    assert shown["pose"]["theta"] == shown["pose"]["yaw"], "the old name of the same number"
    assert shown["ages"]["pose"] is not None
    assert shown["readiness"]["answer"] in ("yes", "no", "not known")
    status = web.get("status").json
    assert status["robot"] == "robot"
    assert status["battery_percent"] == shown["battery"]["percent"]
    assert web.get("faults").json["active"] == []
    assert web.get("readiness").json["answer"] == status["ready"]


def test_a_goal_to_a_mark_is_begun_waited_for_and_told_in_the_journal(web: Served) -> None:
    answer = web.post("goals", {"kind": "mark", "mark": "A1"})
    assert answer.status == 201, answer
    goal = answer.json
    assert (goal["kind"], goal["done"], goal["can_pause"]) == ("mark", False, True)
    ended = web.get(f"goals/{goal['id']}/wait?timeout=60", timeout=70.0).json
    assert (ended["done"], ended["arrived"], ended["state"]) == (True, True, "arrived"), ended
    assert [one["id"] for one in web.get("goals").json] == [goal["id"]]
    entry = web.get("journal").json[-1]
    assert (entry["what"], entry["state"], entry["goal"]) == ("go to A1", "arrived", goal["id"])
    assert entry["who"] == "program at 127.0.0.1"


@pytest.mark.parametrize(
    "order",
    [
        {"kind": "pose", "x": 0.5, "y": 0.0, "yaw": 0.3},
        {"kind": "move", "distance": 0.3, "speed": 0.3},
        {"kind": "rotate", "angle": 0.5, "speed": 0.5},
    ],
    ids=lambda order: order["kind"],
)
def test_the_other_kinds_of_goals_arrive(web: Served, order: dict[str, Any]) -> None:
    goal = web.post("goals", order).json
    assert web.get(f"goals/{goal['id']}/wait?timeout=60", timeout=70.0).json["arrived"] is True


def test_a_goal_is_paused_resumed_and_cancelled(web: Served) -> None:
    number = web.post("goals", {"kind": "mark", "mark": "B1"}).json["id"]
    assert web.post(f"goals/{number}/pause").json["state"] == "paused"
    assert web.post(f"goals/{number}/resume").json["state"] == "running"
    ended = web.post(f"goals/{number}/cancel").json
    assert (ended["state"], ended["arrived"]) == ("cancelled", False)
    assert "has ended already" in web.post(f"goals/{number}/pause").problem
    assert web.get(f"goals/{number}").json["state"] == "cancelled"


def test_a_deleted_goal_is_cancelled_and_gone(web: Served) -> None:
    number = web.post("goals", {"kind": "mark", "mark": "B1"}).json["id"]
    deleted = web.delete(f"goals/{number}")
    assert (deleted.status, deleted.json["state"]) == (200, "cancelled")
    for path in (f"goals/{number}", f"goals/{number}/wait"):
        assert web.get(path).status == 404
    assert web.delete(f"goals/{number}").status == 404, "once more does nothing"
    assert web.get("goals").json == []
    assert [entry["state"] for entry in web.get("journal").json if entry["goal"]] == ["cancelled"]


def test_a_goal_whose_end_is_not_confirmed_stays_when_it_is_deleted(
    web: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    from woosh_pure.web.api import commands

    number = web.post("goals", {"kind": "mark", "mark": "B1"}).json["id"]
    handle = web.app.state.context.robot(None).goals.get(number).handle  # type: ignore[attr-defined]
    with monkeypatch.context() as patched:
        patched.setattr(commands, "CANCEL_SECONDS", 0.05)
        patched.setattr(type(handle), "cancel", lambda *_, **__: None)
        deleted = web.delete(f"goals/{number}")
    assert (deleted.status, deleted.json["done"]) == (202, False)
    assert web.get(deleted.headers["location"]).json["done"] is False
    web.post("stop")


def test_what_was_made_is_at_its_location(web: Served) -> None:
    goal = web.post("goals", {"kind": "rotate", "angle": 0.1})
    assert goal.headers["location"] == f"/api/v1/goals/{goal.json['id']}"
    assert web.get(goal.headers["location"]).json["id"] == goal.json["id"]
    web.post("stop")
    bag = web.post("/api/v1/robots/robot/recordings", {"seconds": 5.0})
    assert web.get(bag.headers["location"]).json["name"] == bag.json["name"]


# -- Idempotency-Key -----------------------------------------------------------------------------------------


def test_the_same_key_gets_the_first_answer_and_moves_nothing_again(web: Served, chassis: Chassis) -> None:
    order, key = {"kind": "rotate", "angle": 0.3, "speed": 0.5}, {"idempotency-key": '"a-4711"'}
    first = web.post("goals", order, headers=key)
    number = first.json["id"]
    assert web.get(f"goals/{number}/wait?timeout=60", timeout=70.0).json["arrived"] is True
    again = web.post("goals", order, headers={"idempotency-key": "a-4711"})
    assert (again.status, again.json, again.headers["location"]) == (
        201,
        first.json,
        first.headers["location"],
    )
    assert len(web.get("goals").json) == 1
    other = web.post("goals", {**order, "angle": -0.3}, headers=key)
    assert other.status == 422
    assert "a-4711' was sent before, with another body" in other.problem
    assert len([e for e in web.get("journal").json if e["goal"]]) == 1


def test_a_refusal_is_kept_for_its_key_as_well(web: Served) -> None:
    key = {"idempotency-key": "b"}
    refused = [web.post("goals", {"kind": "mark", "mark": "none"}, headers=key) for _ in range(2)]
    assert [answer.status for answer in refused] == [409, 409]
    assert refused[0].json == refused[1].json
    assert len(web.get("journal").json) == 1, "the robot was asked once"


def test_a_key_is_in_use_while_its_first_request_is_worked_on(web: Served, chassis: Chassis) -> None:
    import threading

    go_on, asked = threading.Event(), threading.Event()
    go_to_mark = chassis.go_to_mark

    def slow(*args: Any, **options: Any) -> Any:
        asked.set()
        assert go_on.wait(20.0)
        return go_to_mark(*args, **options)

    chassis.go_to_mark = slow  # type: ignore[method-assign]
    order, key = {"kind": "mark", "mark": "B1"}, {"idempotency-key": "c"}
    first = threading.Thread(target=web.post, args=("goals", order), kwargs={"headers": key})
    first.start()
    try:
        assert asked.wait(10.0)
        second = web.post("goals", order, headers=key)
    finally:
        go_on.set()
        first.join(20.0)
    assert second.status == 409
    assert "is still being worked on" in second.problem
    assert len(web.get("goals").json) == 1
    web.post("stop")


def test_keys_take_bounded_memory() -> None:
    from woosh_pure.web.goals import FirstAnswers

    answers = FirstAnswers(most=3)
    done: list[str] = []
    for key in ("a", "b", "c", "d"):
        answers.give("me", key, "go", lambda key=key: {"id": done.append(key)})  # type: ignore[misc]
    answers.give("me", "b", "go", lambda: {"id": done.append("again")})
    answers.give("you", "b", "go", lambda: {"id": done.append("another client's")})
    answers.give("me", "a", "go", lambda: {"id": done.append("forgotten")})
    assert done == ["a", "b", "c", "d", "another client's", "forgotten"]


def test_a_second_goal_is_refused_with_its_reasons_and_replaces_where_it_is_told_to(web: Served) -> None:
    first = web.post("goals", {"kind": "mark", "mark": "B1"}).json["id"]
    refused = web.post("goals", {"kind": "move", "distance": 0.2})
    assert refused.status == 409
    assert refused.problem
    assert refused.json["reasons"]
    second = web.post("goals", {"kind": "mark", "mark": "A1", "replace": True})
    assert second.status == 201, second
    assert web.get(f"goals/{first}/wait?timeout=10").json["state"] == "replaced"
    web.post("stop")


def test_the_time_of_a_goal_runs_out_although_nobody_waits(web: Served) -> None:
    number = web.post("goals", {"kind": "mark", "mark": "B1", "timeout": 0.3}).json["id"]
    ended = web.get(f"goals/{number}/wait?timeout=20").json
    assert ended["state"] == "timed out", ended


def test_a_wait_that_is_over_before_the_goal_says_so(web: Served) -> None:
    number = web.post("goals", {"kind": "rotate", "angle": 6.0, "speed": 0.1}).json["id"]
    assert web.get(f"goals/{number}/wait?timeout=0.1").json["done"] is False
    web.post("stop")


@pytest.mark.promise("STOP in the page")
def test_stop_answers_what_stands_still(web: Served) -> None:
    web.post("goals", {"kind": "mark", "mark": "B1"})
    answer = web.post("stop")
    assert answer.status == 200
    assert answer.json["stands_still"] is True
    assert answer.json["cancelled"]
    assert "stands still" in answer.json["text"]


def test_set_pose_is_taken_and_noted(web: Served) -> None:
    assert web.post("pose", {"x": 0.1, "y": 0.2, "yaw": 0.3}).json["yaw"] == pytest.approx(0.3)
    assert web.get("journal").json[-1]["state"] == "sent"


def test_the_old_name_of_the_heading_is_taken_but_not_both(web: Served) -> None:
    taken = web.post("pose", {"x": 0.1, "y": 0.2, "theta": 0.3}).json
    assert (taken["yaw"], taken["theta"]) == (pytest.approx(0.3), pytest.approx(0.3))
    both = web.post("pose", {"x": 0.1, "y": 0.2, "theta": 0.3, "yaw": 0.3})
    assert both.status == 422
    assert both.problem == "yaw and theta are the same heading: send yaw alone"
    part = web.get("/openapi.json").json["components"]["schemas"]["PoseGoal"]
    assert part["properties"]["theta"]["deprecated"] is True
    assert "deprecated" not in part["properties"]["yaw"]


def test_the_map_is_a_picture_with_facts(web: Served) -> None:
    facts, answer = web.get("map").json, web.get("map.png")
    assert answer.headers["content-type"] == "image/png"
    assert struct.unpack(">II", answer.body[16:24]) == (facts["width"], facts["height"])
    tag = answer.headers["etag"]
    assert web.get("map.png", headers={"if-none-match": tag}).status == 304
    assert b"resolution: 0.05" in web.get("map.yaml").body
    assert web.get("plan").json == {"points": []}


def test_marks_are_those_that_were_given(web: Served) -> None:
    assert [(m["name"], m["charger"]) for m in web.get("marks").json] == [("A1", False), ("C1", True)]


@pytest.mark.parametrize(("path", "magic"), [("color.jpg", b"\xff\xd8"), ("depth.png", b"\x89PNG")])
def test_a_picture_is_taken_and_the_camera_let_go(
    web: Served, chassis: Chassis, path: str, magic: bytes
) -> None:
    answer = web.get(f"camera/{path}")
    assert answer.status == 200, answer
    assert answer.body.startswith(magic)
    camera = web.app.state.context.robot(None).cameras[path.partition(".")[0]]  # type: ignore[attr-defined]
    camera.close_idle(0.0)
    assert not camera.open


def test_feeds_are_listed_and_read_and_pictures_are_not_among_them(web: Served, chassis: Chassis) -> None:
    names = {feed["name"] for feed in web.get("feeds").json}
    assert {"battery", "pose", "scan"} <= names
    assert "camera" not in names
    chassis.measured_velocity.wait(10.0, new=False)
    value = web.get("feeds/velocity").json
    assert (value["name"], set(value["value"])) == ("velocity", {"vx", "vy", "wz"})
    assert web.get("feeds/camera").status == 415
    assert "near names" in web.get("feeds/batery").problem


def test_a_feed_is_streamed_as_events(web: Served) -> None:
    import http.client

    connection = http.client.HTTPConnection("127.0.0.1", web.port, timeout=10)
    connection.request("GET", "/api/v1/feeds/velocity/stream?rate=20")
    response = connection.getresponse()
    assert response.getheader("content-type", "").startswith("text/event-stream")
    said = (response.readline().decode().rstrip("\n") for _ in range(200))
    lines = list(itertools.islice((line for line in said if line and not line.startswith(":")), 6))
    connection.close()
    assert lines[0] == lines[3] == "event: velocity"
    first, second = (json.loads(lines[at].removeprefix("data: ")) for at in (2, 5))
    assert first["value"].keys() == second["value"].keys() == {"vx", "vy", "wz"}
    context = web.app.state.context  # type: ignore[attr-defined]
    until = time.monotonic() + 10.0
    while context.streams and time.monotonic() < until:
        time.sleep(0.05)
    assert context.streams == 0, "who goes frees the stream"


def test_a_bag_is_recorded_seen_growing_downloaded_and_deleted(web: Served, tmp_path: Path) -> None:
    number = web.post("recordings", {"seconds": 60.0}).json["id"]
    assert "end it first" in web.post("recordings").problem
    assert web.get(f"recordings/{number}/bag").status == 409
    until = time.monotonic() + 15.0
    while web.get(f"recordings/{number}").json["messages"] < 5 and time.monotonic() < until:
        time.sleep(0.1)
    assert "end it first" in web.delete(f"recordings/{number}").problem, "nothing is lost by an old client"
    assert web.post(f"recordings/{number}/end").json["running"] is False
    answer = web.get(f"recordings/{number}/bag")
    assert answer.body.startswith(b"#ROSBAG V2.0")
    assert ".bag" in answer.headers["content-disposition"]
    assert web.delete(f"recordings/{number}").json["id"] == number
    assert not list(tmp_path.iterdir())
    assert web.get(f"recordings/{number}").status == web.delete(f"recordings/{number}").status == 404
    done = [entry["what"] for entry in web.get("journal").json]
    assert done == [f"record bag {number}", f"end bag {number}", f"delete bag {number}"]


def test_a_lease_of_somebody_else_is_in_the_way_but_never_of_a_stop(web: Served, chassis: Chassis) -> None:
    assert chassis.lease.acquire("the night shift")
    refused = web.post("goals", {"kind": "move", "distance": 0.1})
    assert refused.status == 409
    assert "the night shift commands this robot now" in refused.problem
    assert refused.json["holder"] == "the night shift"
    assert web.post("pose", {"x": 0.0, "y": 0.0}).status == 409
    assert web.post("stop").json["stands_still"] is True
    asked = web.post("lease").json
    assert (asked["yours"], asked["asking"]) == (False, ["program at 127.0.0.1"])
    assert web.post("lease/grant").status == 409
    assert chassis.lease.grant("the night shift", "program at 127.0.0.1")
    assert web.get("lease").json["yours"] is True
    assert [web.delete("lease").json["holder"] for _ in range(2)] == [None, None]


def test_a_person_takes_over_from_a_program_by_asking_twice(web: Served, chassis: Chassis) -> None:
    assert chassis.lease.acquire("the night shift")
    early = web.post("lease", {"take_over": True})
    assert (early.status, "first" in early.problem) == (409, True), "asked once"
    asked = web.post("lease").json
    assert (asked["yours"], asked["holder_is_program"]) == (False, True)
    taken = web.post("lease", {"take_over": True}).json
    assert (taken["yours"], taken["asking"]) == (True, [])
    assert web.get("journal").json[-1]["what"] == "take over from the night shift"
    assert not chassis.lease.renew("the night shift")


def test_nobody_takes_over_from_a_person(web: Served, chassis: Chassis) -> None:
    with PageClient(web.port) as page:
        page.say(t="lease", op="ask")
        holder = page.of("lease", yours=True)
        assert holder["holder_is_program"] is False
        assert web.post("lease").json["holder_is_program"] is False
        refused = web.post("lease", {"take_over": True})
        assert (refused.status, "is a person" in refused.problem) == (409, True)
        assert chassis.lease.holder == holder["you"]


@pytest.mark.promise("not told where this computer keeps its files")
def test_a_folder_for_recordings_that_is_not_there_is_told_at_the_start(
    chassis: Chassis, tmp_path: Path
) -> None:
    from woosh_pure import web

    with pytest.raises(ValueError, match="there is no folder"):
        web.app(chassis, recordings=tmp_path / "none")
    with Chassis(chassis.master_uri) as other:
        web.app({"a": chassis, "b": other}, recordings=tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "b"], "one for each of several robots"


@pytest.mark.promise("not told where this computer keeps its files")
def test_a_bag_that_cannot_be_written_is_told_without_its_path(chassis: Chassis, tmp_path: Path) -> None:
    folder = tmp_path / "bags"
    folder.mkdir()
    with serving(chassis, recordings=folder) as web:
        folder.rmdir()
        answer = web.post("recordings")
        assert (answer.status, "the log of the server" in answer.problem) == (503, True)
        assert str(tmp_path).encode() not in answer.body


def test_several_robots_have_one_page_each(chassis: Chassis) -> None:
    with Chassis(chassis.master_uri) as other, serving({"hall": chassis, "yard": other}) as web:
        assert [robot["name"] for robot in web.get("robots").json] == ["hall", "yard"]
        assert web.get("status").json["robot"] == "hall"
        assert web.get("robots/yard/status").json["robot"] == "yard"
        assert web.get("/robots/yard/api/v1/status").json["robot"] == "yard"
        assert b"<html" in web.get("/robots/yard/").body
        assert "there are hall, yard" in web.get("robots/cellar/status").problem


# -- who may ask ---------------------------------------------------------------------------------------------


@pytest.mark.promise("page of another site asks for", "STOP in the page")
def test_a_foreign_page_may_change_nothing(web: Served) -> None:
    for path in ("goals", "stop", "pose", "lease", "recordings", "login"):
        for headers in (
            {"origin": "http://evil.example"},
            {"sec-fetch-site": "cross-site"},
            {"origin": "null"},
        ):
            answer = web.post(path, {"kind": "move", "distance": 1.0}, headers=headers)
            assert answer.status == 403, (path, headers)
            assert "only the page of this server may" in answer.problem
    assert web.get("journal").json == []


@pytest.mark.promise("is refused (DNS rebinding)")
def test_a_name_that_is_not_ours_is_refused_for_everything(web: Served) -> None:
    for path in ("status", "/", "/openapi.json", "access"):
        answer = web.get(path, headers={"host": "evil.example"})
        assert answer.status == 421
        assert "--host-name" in answer.problem


@pytest.mark.promise("elsewhere it takes a token of at least 8 letters", "STOP in the page")
def test_without_the_token_nothing_but_the_page_is_shown(chassis: Chassis) -> None:
    with serving(chassis, token=TOKEN) as web:
        web.token = None
        assert web.get("/").status == 200
        assert web.get("access").json == {
            "needs_token": True,
            "logged_in": False,
            "allow_driving": False,
            "robots": [],
        }
        for method, path in (
            ("GET", "status"),
            ("GET", "snapshot"),
            ("POST", "stop"),
            ("GET", "/openapi.json"),
            ("GET", "map.png"),
            ("GET", "/robots/robot/api/v1/status"),
            ("DELETE", "goals/1"),
        ):
            answer = web.ask(method, path)
            assert answer.status == 401, path
            assert "token" in answer.problem
        assert web.get("status", headers={"authorization": "Bearer wrong"}).status == 401
        assert web.get("status", headers={"authorization": f"Bearer {TOKEN}"}).status == 200


@pytest.mark.promise("a cookie that scripts cannot read and other sites do not send")
def test_the_page_logs_in_with_a_cookie_that_scripts_cannot_read(chassis: Chassis) -> None:
    with serving(chassis, token=TOKEN) as web:
        web.token = None
        assert web.post("login", {"token": "wrong"}).status == 401
        cookie = web.post("login", {"token": TOKEN}).headers["set-cookie"]
        assert "HttpOnly" in cookie
        assert "SameSite=strict" in cookie
        assert TOKEN not in cookie
        sent = {"cookie": cookie.partition(";")[0]}
        assert web.get("status", headers=sent).status == 200
        assert web.get("access", headers=sent).json["logged_in"] is True
        foreign = web.post("stop", headers={**sent, "origin": "http://evil.example"})
        assert foreign.status == 403, "the cookie does not help a foreign page"
        stale = web.get("status", headers={"cookie": f"woosh_token={TOKEN}"})
        assert stale.status == 401, "the token itself is no cookie"


@pytest.mark.promise("two servers of one host do not accept each other's")
def test_two_servers_of_one_host_keep_their_log_ins_apart(chassis: Chassis) -> None:
    """Browsers send a cookie to every port of its host."""
    with serving(chassis, token=TOKEN) as one, serving(chassis, token=TOKEN) as two:
        first, second = (
            web.post("login", {"token": TOKEN}).headers["set-cookie"].partition(";")[0] for web in (one, two)
        )
        one.token = two.token = None
        assert first.partition("=")[0] != second.partition("=")[0], "none overwrites the other"
        both = {"cookie": f"{first}; {second}"}
        assert [web.get("status", headers=both).status for web in (one, two)] == [200, 200]
        name, value = second.partition("=")[0], first.partition("=")[2]
        for cookie in (first, f"{name}={value}"):
            assert two.get("status", headers={"cookie": cookie}).status == 401


@pytest.mark.promise("The same host by another scheme is another site")
def test_a_page_by_another_scheme_is_another_site(web: Served) -> None:
    own = f"127.0.0.1:{web.port}"
    assert web.post("stop", headers={"origin": f"https://{own}"}).status == 403
    assert web.post("stop", headers={"origin": f"http://{own}"}).status == 200


@pytest.mark.promise("answered ten times, then once every six seconds")
def test_who_guesses_tokens_is_slowed_down(chassis: Chassis) -> None:
    with serving(chassis, token=TOKEN) as web:
        wrong = {"authorization": "Bearer wrong-guess"}
        statuses = [web.get("status", headers=wrong).status for _ in range(12)]
        assert statuses[:10] == [401] * 10
        assert statuses[-1] == 429
        assert web.get("status").status == 200


def test_orders_come_at_most_five_a_second_and_stops_always(web: Served) -> None:
    answers = [web.post("lease") for _ in range(30)]
    assert 429 in {answer.status for answer in answers}
    assert "at most five a second" in next(a for a in answers if a.status == 429).problem
    assert all(web.post("stop").status == 200 for _ in range(3))


@pytest.mark.promise("(Content-Security-Policy without exceptions)")
def test_the_page_has_a_strict_policy_and_nothing_is_framed(web: Served) -> None:
    for path in ("/", "status", "/nothing"):
        headers = web.get(path).headers
        policy = headers["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "unsafe" not in policy
        assert "frame-ancestors 'none'" in policy
        assert headers["x-content-type-options"] == "nosniff"
    assert web.get("status").headers["cache-control"] == "no-store"


@pytest.mark.promise("elsewhere it takes a token of at least 8 letters")
def test_off_this_computer_only_with_a_token(chassis: Chassis) -> None:
    from woosh_pure import web
    from woosh_pure.web.server import WebServer

    for bind in ("0.0.0.0", "::", "192.168.1.7"):
        with pytest.raises(ValueError, match="that takes a token"):
            WebServer(web.app(chassis), bind=bind, port=0)


# -- bad input -----------------------------------------------------------------------------------------------

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
        access._moves.clear()
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
    answer = web.post("goals", b"x" * (MOST_BODY + 1), headers={"content-type": "application/json"})
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
        assert f"takes {takes}, not {method}" in other.problem
    assert "/docs/ shows what there is" in web.get("statu").problem
    goal = b'{"kind": "mark", "mark": "A1"}'
    form = web.post("goals", goal, headers={"content-type": "application/x-www-form-urlencoded"})
    assert (
        form.problem == "the body is application/x-www-form-urlencoded: send content-type: application/json"
    )
    assert "the body has no type" in web.post("goals", goal).problem
    assert "a body is missing: send a JSON object" in web.post("goals").problem
    quotes = web.post("goals", b"{'kind': 'mark'}", headers={"content-type": "application/json"})
    assert "the body is no JSON: Expecting property name" in quotes.problem
    assert "(at character 1)" in quotes.problem


def test_files_that_are_no_certificate_are_refused_before_the_server_starts(
    chassis: Chassis, tmp_path: Path
) -> None:
    from woosh_pure import web
    from woosh_pure.web.server import WebServer

    wrong = tmp_path / "wrong.pem"
    wrong.write_text("no certificate")
    with pytest.raises(ValueError, match=r"wrong\.pem: it is no PEM certificate with its unencrypted key"):
        WebServer(web.app(chassis), port=0, tls_cert=wrong)
    with pytest.raises(FileNotFoundError):
        WebServer(web.app(chassis), port=0, tls_cert=tmp_path / "missing.pem")


REFUSED: dict[str, tuple[str, Any, str, str]] = {
    "no kind": ("goals", {}, 'kind is missing; allowed: "mark", "park", "charge",', "缺少 kind"),
    "no such kind": ("goals", {"kind": "fly"}, 'kind is "fly"; allowed: "mark", "park", "charge",', 'kind 的值是 "fly"'),
    "a part is missing": ("goals", {"kind": "move"}, "distance is missing; allowed: a number from -10 to 10 m", "缺少 distance"),
    "a text for a number": ("pose", {"x": "1", "y": 0.0}, 'x is "1"; allowed: a number from -100000 to 100000 m', 'x 的值是 "1"'),
    "degrees": ("pose", {"x": 1, "y": 0, "yaw": 90}, "yaw is 90; allowed: a number from -6.28318531 to 6.28318531 rad", "单位 rad"),
    "too far": ("goals", {"kind": "move", "distance": 10.5}, "distance is 10.5; allowed:", "distance 的值是 10.5"),
    "no time": ("goals", {"kind": "mark", "mark": "A1", "timeout": 0}, "timeout is 0; allowed: a number above 0 and up to 86400 s", "大于 0"),
    "an empty name": ("goals", {"kind": "mark", "mark": ""}, 'mark is ""; allowed: a text of 1 to 200 characters', "1 到 200 个字符"),
    "another part": ("goals", {"kind": "mark", "mark": "A1", "fast": 1}, '"fast" is not known here; known: timeout, replace, kind, mark', "这里没有"),
    "two at once": ("recordings", {"seconds": 0, "camera": 1}, "; camera is 1; allowed: true or false", "true 或 false"),
    "no object": ("lease", [1], "the body is [1]; allowed: a JSON object with seconds", "JSON 对象"),
    "null": ("lease", None, "the body is null; allowed: a JSON object, or no body", "请求体是 null"),
    "a stop": ("stop", {"everything": "no"}, '; but everything is "no"; allowed: true or false', "仍然执行了停止"),
    "no JSON": ("stop", b"{", "; but the body is no JSON:", "请求体不是 JSON"),
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
def test_what_is_said_to_clients_in_place_of_advice_for_python_is_said_by_somebody() -> None:
    from tools.templates import texts
    from woosh_pure.language.table import key_of, translator_for
    from woosh_pure.web.http_errors import ADVICE

    said = texts(leaving_out="woosh_pure/web/http_errors.py")
    assert [template for template in ADVICE if key_of(template) not in said] == []
    assert [text for text in ADVICE.values() if not translator_for("zh").has(text)] == []


def test_errors_of_the_robot_are_problems_with_its_sentence(web: Served) -> None:
    refused = web.post("goals", {"kind": "mark", "mark": "no such mark"})
    assert refused.status == 409
    assert "no such mark" in refused.problem
    assert web.get("journal").json[-1]["state"] == "refused"


# -- the description, and mounting ---------------------------------------------------------------------------


def test_the_description_names_every_operation_once_and_every_error(web: Served) -> None:
    schema = web.get("/openapi.json").json
    operations = [op for path in schema["paths"].values() for op in path.values()]
    names = [op["operationId"] for op in operations]
    assert len(names) == len(set(names)) > 50
    assert {"create_goal", "wait_for_goal", "stop", "create_goal_of_robot"} <= set(names)
    tags = {
        path: operations["post"]["tags"]
        for path, operations in schema["paths"].items()
        if "post" in operations
    }
    assert tags["/api/v1/stop"] == tags["/api/v1/pose"] == ["stop"], (
        "generated clients have a module for each tag"
    )
    text = json.dumps(schema)
    assert "HTTPValidationError" not in text
    for reference in {part.partition('"')[0] for part in text.split('"#/components/schemas/')[1:]}:
        assert reference in schema["components"]["schemas"]
    for operation in operations:
        assert operation.get("summary")
        assert any(code.startswith("2") for code in operation["responses"])
        assert {"413", "421", "429", "500", "503"} <= set(operation["responses"])


def test_the_description_says_who_needs_a_token(chassis: Chassis) -> None:
    with serving(chassis, token=TOKEN) as web:
        document = web.get("/openapi.json").json
    assert document["components"]["securitySchemes"]["token"]["scheme"] == "bearer"
    assert document["security"] == [{"token": []}]
    for path, item in document["paths"].items():
        for operation in item.values():
            is_open = path.endswith(("/access", "/login"))
            assert (operation.get("security") == []) == is_open
            assert "401" in operation["responses"] or is_open
    with serving(chassis) as web:
        assert "security" not in web.get("/openapi.json").json


def test_head_answers_wherever_get_does_and_sends_no_body(web: Served) -> None:
    for path in ("status", "marks", "goals", "map.png", "lease", "feeds/pose/stream", "/", "/openapi.json"):
        head = web.ask("HEAD", path)
        assert (head.status, head.body) == (200, b""), path
        assert head.headers["content-type"]
    assert web.ask("HEAD", "map.yaml").headers["content-length"] == str(len(web.get("map.yaml").body))
    assert web.ask("HEAD", "goals/7").status == 404
    context = web.app.state.context  # type: ignore[attr-defined]
    until = time.monotonic() + 10.0
    while context.streams and time.monotonic() < until:
        time.sleep(0.02)
    assert context.streams == 0


def test_a_client_made_from_the_description_drives_to_a_mark(web: Served) -> None:
    """Every address, body and answer is taken from /openapi.json; nothing is known beforehand but the names."""
    schema = web.get("/openapi.json").json
    found = {
        op["operationId"]: (method, path, op)
        for path, ops in schema["paths"].items()
        for method, op in ops.items()
    }

    def call(name: str, body: Any = None, **parameters: Any) -> Any:
        method, path, operation = found[name]
        known = {p["name"]: p["in"] for p in operation.get("parameters", [])}
        query = "&".join(f"{k}={v}" for k, v in parameters.items() if known[k] == "query")
        for key, value in parameters.items():
            path = path.replace(f"{{{key}}}", str(value))
        answer = web.ask(method.upper(), path + (f"?{query}" if query else ""), body, timeout=70.0)
        assert str(answer.status) in operation["responses"], answer
        content = operation["responses"][str(answer.status)]["content"]["application/json"]["schema"]
        listed = content.get("items", content)
        required = schema["components"]["schemas"][listed["$ref"].rsplit("/", 1)[1]]["required"]
        for one in answer.json if isinstance(answer.json, list) else [answer.json]:
            assert set(required) <= set(one)
        return answer.json

    mark = call("get_marks")[0]["name"]
    goal = call("create_goal", {"kind": "mark", "mark": mark})
    assert call("wait_for_goal", goal=goal["id"], timeout=60)["arrived"] is True


@pytest.mark.parametrize("outer", ["fastapi", "starlette"])
def test_it_is_mounted_in_somebody_elses_application_and_starts_nothing_by_itself(
    chassis: Chassis, outer: str
) -> None:
    import threading

    import uvicorn
    from fastapi import FastAPI
    from starlette.applications import Starlette
    from starlette.responses import PlainTextResponse
    from starlette.routing import Route

    from woosh_pure import web
    from woosh_pure.web.server import WebServer

    before = {thread.name for thread in threading.enumerate()}
    with Chassis(chassis.master_uri) as mine:
        inner = web.app(mine)
        assert not mine._components.feeds.opened
        assert {t.name for t in threading.enumerate() if t.name.startswith("woosh:web")} <= before

        def hello(request: Any) -> PlainTextResponse:
            return PlainTextResponse("mine")

        host = FastAPI() if outer == "fastapi" else Starlette()
        host.router.routes.append(Route("/mine", hello))
        host.mount("/robot", inner)
        host.state.context = inner.state.context  # only for the server of this test
        assert uvicorn
        with WebServer(host, port=0) as server:  # type: ignore[arg-type]
            served = Served(server.port)
            assert served.get("/mine").body == b"mine"
            assert served.get("/robot/api/v1/status").json["robot"] == "robot"
            assert b"<html" in served.get("/robot/").body
            assert served.get("/robot/api/v1/nothing").status == 404
            assert served.post("/robot/api/v1/stop", headers={"origin": "http://evil.example"}).status == 403
            from tests.support.web import PageClient

            with PageClient(server.port, "/robot/api/v1/live") as page:
                assert page.of("hello")["robot"] == "robot"


@pytest.mark.parametrize("name", ["a b", "a/b", "", "x" * 101, "a?b", "a%b"])
def test_a_name_that_cannot_stand_in_an_address_is_refused(chassis: Chassis, name: str) -> None:
    from woosh_pure import web

    with pytest.raises(ValueError, match="robot name"):
        web.app({name: chassis})
