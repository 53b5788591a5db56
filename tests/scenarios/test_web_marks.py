"""The marks of the page: saved in the user's list, changed, taken off, and driven to."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("uvicorn", reason="needs the extra `web`")
pytest.importorskip("websockets", reason="needs the extra `web`")

from tests.support.web import PageClient, Served, serving
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.marks import MarkFile


@pytest.fixture
def file(tmp_path: Path) -> MarkFile:
    """A list that does not exist yet."""
    return MarkFile(tmp_path / "site" / "marks.json")


@pytest.fixture
def web(chassis: Chassis, file: MarkFile) -> Iterator[Served]:
    """A server that saves in it."""
    with serving(chassis, marks=file) as served:
        yield served


def names(web: Served) -> list[str]:
    return [mark["name"] for mark in web.get("marks").json]


def test_a_mark_is_saved_where_the_robot_stands_and_stays_in_the_file(
    web: Served, chassis: Chassis, file: MarkFile
) -> None:
    assert web.get("marks").json == []
    made = web.post("marks", {"name": " Dock 1/2 ", "here": True, "note": "shelf"})
    assert made.status == 201, made
    here = chassis.pose.wait(10.0)
    mark = made.json
    assert (mark["name"], mark["note"], mark["on_chassis"]) == ("Dock 1/2", "shelf", False)
    assert Pose2D(mark["x"], mark["y"]).distance_to(here) < 0.1
    assert web.get(made.headers["location"]).json == mark
    kept = MarkFile(file.path)["Dock 1/2"]
    assert (kept.note, kept.on_chassis, kept.charger) == ("shelf", False, False)
    assert web.get("journal").json[-1]["what"] == "save mark Dock 1/2"


def test_a_mark_is_renamed_moved_and_taken_off(web: Served, file: MarkFile) -> None:
    assert web.post("marks", {"name": "A", "x": 1.0, "y": 2.0, "yaw": 1.5}).status == 201
    renamed = web.ask("PATCH", "marks/A", {"name": "仓库", "charger": True}).json
    assert renamed == {
        "name": "仓库", "x": 1.0, "y": 2.0, "yaw": 1.5, "theta": 1.5, "charger": True, "note": "", "on_chassis": False, "source": "list",
    }  # fmt: skip
    moved = web.ask("PATCH", "marks/%E4%BB%93%E5%BA%93", {"x": 3.0, "y": 2.0}).json
    assert (moved["x"], moved["yaw"]) == (3.0, 1.5), "where it looks stays"
    assert names(web) == ["仓库"]
    gone = web.delete("marks/%E4%BB%93%E5%BA%93")
    assert (gone.status, gone.body) == (204, b"")
    assert (names(web), len(MarkFile(file.path))) == ([], 0)
    assert web.delete("marks/A").status == 404


def test_a_mark_of_the_chassis_without_a_pose_cannot_become_a_place_without_one(web: Served) -> None:
    assert web.post("marks", {"name": "A", "on_chassis": True}).status == 201
    refused = web.ask("PATCH", "marks/A", {"on_chassis": False})
    assert refused.status == 409, "the request is valid: the mark stands against it"
    assert "a place needs a pose" in refused.problem
    assert web.ask("PATCH", "marks/A", {"on_chassis": False, "x": 1.0, "y": 0.0}).status == 200


@pytest.mark.parametrize(
    ("body", "status", "text"),
    [
        ({"name": "A"}, 422, "a place needs a pose"),
        ({"name": "  ", "x": 0.0, "y": 0.0}, 422, "needs a name"),
        ({"name": "A\u202eB\x00", "x": 0.0, "y": 0.0}, 422, "printable characters"),
        ({"name": "A", "x": 0.0}, 422, "x and y belong together"),
        ({"name": "A", "here": True, "x": 0.0, "y": 0.0}, 422, "leave out x, y and yaw"),
        ({"name": "A", "x": 0.0, "y": 0.0, "yaw": 90.0}, 422, "yaw is 90.0; allowed:"),
        ({"name": "B", "x": 0.0, "y": 0.0}, 409, "there is a mark 'B' already"),
    ],
)
def test_what_makes_no_mark_is_said(
    web: Served, file: MarkFile, body: object, status: int, text: str
) -> None:
    file.put("B")
    file.save()
    answer = web.post("marks", body)
    assert (answer.status, text in answer.problem) == (status, True), answer
    assert names(web) == ["B"]


def test_no_mark_is_saved_where_a_lost_robot_believes_to_be() -> None:
    with (
        SimulatedChassis(full_graph=False) as sim,
        Chassis(sim.master_uri) as chassis,
        serving(chassis, marks=[]) as web,
    ):
        sim.lose_localization()
        answer = web.post("marks", {"name": "A", "here": True})
        assert (answer.status, "does not know where it is" in answer.problem) == (409, True)
        assert names(web) == []


def test_a_rename_takes_no_other_mark_away(web: Served, file: MarkFile) -> None:
    file.put("A"), file.put("B")
    file.save()
    assert web.ask("PATCH", "marks/A", {"name": "B"}).status == 409
    assert names(web) == ["A", "B"]


def test_what_another_program_saves_is_seen_at_once(web: Served, file: MarkFile) -> None:
    with PageClient(web.port) as page:
        page.of("marks", marks=[])
        other = MarkFile(file.path)
        other.put("A1", Pose2D(3.0, 1.0))
        other.save()
        told = page.wait(lambda d: d["t"] == "marks" and d["marks"])
        assert [mark["name"] for mark in told["marks"]] == ["A1"]
    assert web.post("marks", {"name": "B", "x": 0.0, "y": 0.0}).status == 201
    assert MarkFile(file.path).names == ["A1", "B"], "and kept"


def test_a_goal_to_a_place_of_the_list_goes_by_its_pose(web: Served, chassis: Chassis) -> None:
    """The chassis knows no mark of this name."""
    here = chassis.pose.wait(10.0)
    assert web.post("marks", {"name": "mine", "x": here.x + 0.5, "y": here.y}).status == 201
    goal = web.post("goals", {"kind": "mark", "mark": "mine"}).json
    ended = web.get(f"goals/{goal['id']}/wait?timeout=60", timeout=70.0).json
    assert ended["arrived"] is True, ended
    assert chassis.pose.wait(10.0).distance_to(Pose2D(here.x + 0.5, here.y)) < 0.2
    assert web.get("journal").json[-1]["what"] == "go to mine"
    refused = web.post("goals", {"kind": "charge", "mark": "mine"})
    assert (refused.status, "the chassis itself must know" in refused.problem) == (409, True)


def test_a_mark_of_the_chassis_goes_by_its_name(web: Served) -> None:
    assert web.post("marks", {"name": "A1", "on_chassis": True}).status == 201
    assert web.get("marks/A1").json["x"] is None
    goal = web.post("goals", {"kind": "mark", "mark": "A1"}).json
    ended = web.get(f"goals/{goal['id']}/wait?timeout=60", timeout=70.0).json
    assert ended["arrived"] is True, ended


@pytest.mark.promise("Clients do not receive paths of this computer")
def test_a_list_that_cannot_be_kept_is_told_without_its_path(
    web: Served, file: MarkFile, caplog: pytest.LogCaptureFixture
) -> None:
    file.path.parent.write_text("a file where the folder should be")
    with caplog.at_level(logging.ERROR):
        answer = web.post("marks", {"name": "A", "x": 0.0, "y": 0.0})
    assert answer.status == 503
    assert "cannot be written; the log of the server" in answer.problem
    assert str(file.path.parent).encode() not in answer.body
    assert str(file.path.parent) in caplog.text
    assert names(web) == []


def test_marks_need_no_lease_and_count_as_commands(web: Served, chassis: Chassis) -> None:
    assert chassis.lease.acquire("the night shift")
    statuses = [web.delete("marks/none").status for _ in range(15)]
    assert statuses[:10] == [404] * 10
    assert 429 in statuses
