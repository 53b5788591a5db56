"""The goals of the REST API on the simulated chassis: begun, paused, deleted, repeated with a key; stop and set-pose."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("uvicorn", reason="needs the extra `web`")
pytest.importorskip("websockets", reason="needs the extra `web`")

from tests.support.web import Served, serving
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.marks import UserMark


@pytest.fixture
def web(chassis: Chassis, tmp_path: Path) -> Iterator[Served]:
    """A server for one robot."""
    marks = [UserMark("A1", Pose2D(3.0, 1.0, 1.57)), UserMark("C1", Pose2D(-0.9, -3.0), charger=True)]
    with serving(chassis, marks=marks, recordings=tmp_path) as served:
        yield served


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
    assert "is still being processed" in second.problem
    assert len(web.get("goals").json) == 1
    web.post("stop")


def test_keys_take_bounded_memory() -> None:
    from woosh_pure.web.goals import IdempotentAnswers

    answers = IdempotentAnswers(max_answers=3)
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


def test_the_seconds_of_a_goal_do_not_jump_with_this_computers_clock(
    web: Served, sim: SimulatedChassis, monkeypatch: pytest.MonkeyPatch
) -> None:
    sim.speed = 1.0
    goal = web.post("goals", {"kind": "mark", "mark": "B1"}).json
    wall = time.time
    monkeypatch.setattr(time, "time", lambda: wall() + 3600.0)
    assert 0.0 <= web.get(f"goals/{goal['id']}").json["seconds"] < 300.0
    assert web.delete(f"goals/{goal['id']}").json["seconds"] < 300.0
