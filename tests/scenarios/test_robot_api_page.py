"""The page and the REST API know what the robot names by its Robot API, and nothing waits for a slow one."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("uvicorn", reason="needs the extra `web`")
pytest.importorskip("websockets", reason="needs the extra `web`")

from tests.support.robot_api_peer import ANSWERS, ApiPeer, Refused
from tests.support.web import PageClient, Served, serving
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.maps.marks import UserMark
from woosh_pure.robot_api import api


@pytest.fixture
def peer() -> Iterator[ApiPeer]:
    with ApiPeer() as robot:
        yield robot


@pytest.fixture
def web(sim: SimulatedChassis, peer: ApiPeer) -> Iterator[Served]:
    """A server whose robot has a Robot API, with one mark on its own list."""
    own = UserMark("home", None, "mine", on_chassis=True)
    with Chassis(sim.master_uri, robot_api=peer.address) as chassis, serving(chassis, marks=[own]) as served:
        yield served


def test_the_list_has_the_robots_marks_with_their_poses(web: Served) -> None:
    marks = {mark["name"]: mark for mark in web.get("marks").json}
    assert sorted(marks) == ["A1", "C1", "home", "nowhere", "仓库 2"], "U1 is on another map"
    assert (marks["A1"]["source"], marks["A1"]["x"], marks["A1"]["on_chassis"]) == ("robot", 3.0, True)
    assert (marks["C1"]["charger"], marks["home"]["source"]) == (True, "list")
    assert web.get("marks/A1").json == marks["A1"]


def test_the_robots_marks_are_read_only(web: Served) -> None:
    assert len(web.get("marks").json) == 5
    assert web.ask("PATCH", "marks/A1", {"note": "x"}).status == 404
    assert web.delete("marks/A1").status == 404
    made = web.post("marks", {"name": "A1", "on_chassis": True, "note": "my own words"})
    assert made.status == 201
    mark = next(mark for mark in web.get("marks").json if mark["name"] == "A1")
    assert (mark["note"], mark["x"], mark["source"]) == ("my own words", 3.0, "list")


def test_a_goal_for_a_mark_of_the_robot_is_its_own_task(web: Served, sim: SimulatedChassis) -> None:
    web.get("marks")
    goal = web.post("goals", {"kind": "mark", "mark": "A1"})
    assert goal.status == 201, goal
    assert goal.json["target"] == {"x": 3.0, "y": 1.0}
    assert sim.world.tasks.task_id != 0
    web.post("stop")


def test_maps_and_zones_are_named(web: Served) -> None:
    assert web.get("scenes").json == {
        "scene": "hall",
        "map": "ground",
        "scenes": [{"name": "hall", "maps": ["ground", "upper"]}, {"name": "yard", "maps": ["yard"]}],
        "zones": [
            {
                "kind": "speed_limit",
                "max_speed": 0.3,
                "points": [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]],
            }
        ],
    }


def test_a_page_is_shown_them(web: Served) -> None:
    with PageClient(web.port) as page:
        page.of("hello")
        site = page.wait(lambda d: d["t"] == "site" and d["map"])
        assert (site["map"], len(site["zones"])) == ("ground", 1)
        assert site["outline"][0] == [0.41, 0.27]
        page.wait(lambda d: d["t"] == "marks" and any(mark["source"] == "robot" for mark in d["marks"]))


def test_the_map_is_switched_and_written_into_the_journal(
    web: Served, peer: ApiPeer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(api, "SETTLED_SECONDS", 0.0)

    def switch(request: str, body: dict[str, Any]) -> Any:
        peer.answers["woosh.robot.Scene"] = {"sceneName": body["sceneName"], "mapName": body["mapName"]}
        return {}

    peer.answers["woosh.robot.SwitchMap"] = switch
    done = web.post("scenes/current", {"scene": "yard", "map": "yard"})
    assert (done.status, done.json) == (200, {"scene": "yard", "map": "yard", "localised": True})
    entry = web.get("journal").json[-1]
    assert (entry["what"], entry["state"]) == ("switch to the map yard of yard", "done")


def test_a_switch_that_the_robot_refuses_has_its_words(web: Served, peer: ApiPeer) -> None:
    def refuse(request: str, body: dict[str, Any]) -> Any:
        raise Refused("没有此地图")

    peer.answers["woosh.robot.SwitchMap"] = refuse
    refused = web.post("scenes/current", {"scene": "nowhere"})
    assert (refused.status, "没有此地图" in refused.problem) == (409, True)
    assert web.get("journal").json[-1]["state"] == "failed"


@pytest.mark.promise("`chassis.robot_api.switch_map`, another map chosen")
def test_the_map_is_not_switched_while_a_goal_is_under_way(web: Served, peer: ApiPeer) -> None:
    assert web.post("goals", {"kind": "move", "distance": 1.0}).status == 201
    refused = web.post("scenes/current", {"scene": "yard"})
    assert (refused.status, "is under way" in refused.problem) == (409, True)
    assert "SwitchMap" not in peer.requests
    web.post("stop")


def test_a_robot_without_one_is_as_before(sim: SimulatedChassis) -> None:
    with Chassis(sim.master_uri, robot_api=False) as chassis, serving(chassis) as web:
        assert web.get("marks").json == []
        assert web.get("scenes").json == {"scene": None, "map": None, "scenes": [], "zones": []}
        refused = web.post("scenes/current", {"scene": "hall"})
        assert (refused.status, "names no maps" in refused.problem) == (409, True)
        with PageClient(web.port) as page:
            assert page.of("site")["outline"] == []


@pytest.mark.promise("Robot API (port 5480) is slow, wrong or silent")
def test_the_page_of_a_robot_whose_robot_api_never_answers_is_as_before(sim: SimulatedChassis) -> None:
    """The first question is still without an answer when all else is shown and a goal is under way."""
    asked, answer = threading.Event(), threading.Event()

    def wait(request: str) -> None:
        asked.set()
        answer.wait(60.0)

    with (
        ApiPeer(ANSWERS, wait=wait) as peer,
        Chassis(sim.master_uri, robot_api=peer.address) as chassis,
        serving(chassis) as web,
        PageClient(web.port) as page,
    ):
        assert asked.wait(10.0)
        for kind in ("pose", "map", "marks"):
            page.of(kind)
        page.wait(lambda d: d["t"] == "state" and d.get("readiness"))
        goal = web.post("goals", {"kind": "mark", "mark": "A1"})
        assert goal.status == 201
        assert web.post("stop").json["stands_still"] is True
        assert peer.requests == ["RobotState"], "one question, in a thread of its own"
        answer.set()
