"""Missions through the web server: files, runs, the queue, answers, events; a stop; a kill; two servers."""

from __future__ import annotations

import http.client
import json
import shutil
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("uvicorn", reason="needs the extra `web`")
pytest.importorskip("websockets", reason="needs the extra `web`")

from rosproto.admission import TokenBucket
from tests.support.doors import held, in_thread
from tests.support.waiting import until
from tests.support.web import PageClient, Served, serving
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.missions import Missions

ASK = {"do": "ask", "text": "Loaded?", "answers": {"Yes": "next", "No": "stop"}}
TURN = {"do": "rotate", "degrees": 20}
WAIT = {"do": "wait", "seconds": 600}


def mission(*steps: dict[str, Any], **more: Any) -> dict[str, Any]:
    """Its readiness is not known: this chassis says its state on change only."""
    return {"mission": 1, "name": "Round", "guards": {"not_known": "go"}, "step": list(steps), **more}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Of the files; and no state of another test."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    return tmp_path / "missions"


@pytest.fixture
def web(folder: Path, chassis: Chassis) -> Iterator[Served]:
    with serving(chassis, missions=folder) as served:
        yield served


def save(web: Served, *steps: dict[str, Any], file: str = "round", **more: Any) -> None:
    saved = web.ask("PUT", f"missions/{file}", {"mission": mission(*steps, **more)})
    assert saved.status == 200, saved


def start(web: Served, file: str = "round", **more: Any) -> str:
    begun = web.post("mission-runs", {"file": file, **more})
    assert begun.status == 201, begun
    assert web.get(begun.headers["location"]).json["id"] == begun.json["id"]
    return str(begun.json["id"])


def reaches(web: Served, run: str, *states: str) -> dict[str, Any]:
    """The run once it is in one of these states."""
    found: dict[str, Any] = {}

    def there() -> bool:
        found.update(web.get(f"mission-runs/{run}").json)
        return found["state"] in states

    until(there, what=f"{states}; it is {found}")
    return found


def journal(web: Served) -> list[tuple[str, str]]:
    return [(entry["what"], entry["state"]) for entry in web.get("journal").json]


# -- files ---------------------------------------------------------------------------------------------------


def test_a_mission_is_saved_listed_changed_and_deleted(web: Served, folder: Path) -> None:
    assert web.get("missions").json["missions"] == []
    save(web, TURN, ASK, description="with a question")
    assert "degrees = 20" in (folder / "round.mission.toml").read_text()
    (one,) = web.get("missions").json["missions"]
    assert (one["file"], one["mission"]["name"], one["problem"]) == ("round", "Round", None)
    got = web.get("missions/round")
    assert got.json["mission"] == mission(TURN, ASK, description="with a question")
    save(web, TURN)
    assert web.get("missions/round").json["mission"] == mission(TURN)
    assert web.delete("missions/round").status == 204
    assert web.delete("missions/round").status == web.get("missions/round").status == 404
    assert list(folder.iterdir()) == []
    assert journal(web) == [(f"{verb} mission round", "done") for verb in ("save", "save", "delete")]


def test_a_faulty_mission_is_refused_with_its_place(web: Served, folder: Path) -> None:
    refused = web.ask("PUT", "missions/round", {"mission": mission(TURN, {"do": "go_to_mark"})})
    assert refused.status == 422
    assert "mark" in refused.problem
    assert refused.json["path"] == ["step", 1, "mark"]
    assert not folder.exists()


@pytest.mark.promise("Clients do not receive paths of this computer")
def test_a_file_that_cannot_be_read_is_listed_with_its_problem(web: Served, folder: Path) -> None:
    """And does not start; the answer has no path of this computer."""
    folder.mkdir()
    (folder / "torn.mission.toml").write_text("mission = 1\nname = ")
    (folder / "large.mission.toml").write_bytes(b"#" * 100_000)
    found = web.get("missions")
    assert [(one["file"], bool(one["problem"])) for one in found.json["missions"]] == [
        ("large", True),
        ("torn", True),
    ]
    refused = web.post("mission-runs", {"file": "torn"})
    assert (refused.status, "line 2" in refused.problem) == (409, True)
    assert str(folder.parent).encode() not in found.body + refused.body


@pytest.mark.parametrize(
    "name", ["..%2Fx", "%2Fetc%2Fx", "..", ".hidden", "a%5Cb", "%00", "x" * 101, "a%2F..%2Fb"]
)
def test_no_name_leads_out_of_the_folder(web: Served, folder: Path, name: str) -> None:
    """Neither to read, nor to write, nor to start one."""
    folder.mkdir()
    (folder.parent / "x.mission.toml").write_text(
        'mission = 1\nname = "x"\n[[step]]\ndo = "wait"\nseconds = 1\n'
    )
    before = sorted(folder.parent.rglob("*.toml"))
    assert web.ask("PUT", f"missions/{name}", {"mission": mission(TURN)}).status in (404, 405, 422)
    assert web.get(f"missions/{name}").status in (200, 404, 422)  # ".." is the API's own list
    assert web.delete(f"missions/{name}").status in (404, 405, 422)
    assert web.post("mission-runs", {"file": f"{folder.parent}/x"}).status == 404
    assert sorted(folder.parent.rglob("*.toml")) == before


def test_what_is_wrong_is_said_in_the_language_of_the_request(web: Served) -> None:
    body = {"mission": mission({"do": "fly"})}
    refused = web.ask("PUT", "missions/round", body, headers={"accept-language": "zh"})
    assert refused.status == 422
    assert any("一" <= letter <= "鿿" for letter in refused.problem), refused.problem


def test_hostile_texts_are_data(web: Served) -> None:
    """Control characters of a text are shown as such, and nothing of it is taken as a template."""
    save(web, {**ASK, "text": "<b>{who}</b>\x1b[2J\u202e"}, name="{mission}\x07")
    run = reaches(web, start(web), "asking")
    assert "\x1b" not in run["question"]["text"] + run["mission"]
    assert run["question"]["text"].startswith("<b>{who}</b>")
    web.post("mission-queue/stop")
    assert journal(web)[-1][0] in ("stop the mission", "mission {mission}\\x07")


# -- runs ----------------------------------------------------------------------------------------------------


def test_a_mission_is_started_answered_and_ends_in_the_journal(web: Served) -> None:
    save(web, {**TURN, "degrees": "$angle"}, ASK, TURN, parameters={"angle": 10})
    with PageClient(web.port) as page:
        key = {"Idempotency-Key": "one"}
        begun = web.post("mission-runs", {"file": "round", "parameters": {"angle": 30}}, headers=key)
        again = web.post("mission-runs", {"file": "round", "parameters": {"angle": 30}}, headers=key)
        assert again.json["id"] == begun.json["id"], "nothing is started twice"
        run = begun.json["id"]
        asked = reaches(web, run, "asking")
        assert asked["question"] == {
            "text": "Loaded?", "answers": ["Yes", "No"], "default": "", "unknown": False, "seconds_left": None,
        }  # fmt: skip
        assert [step["state"] for step in asked["steps"]] == ["done", "", ""]
        assert asked["steps"][0]["values"] == {"degrees": 30}
        page.wait(
            lambda d: (
                d["t"] == "state" and any(one["question"] for one in d.get("missions", {}).get("runs", ()))
            )
        )
        wrong = web.post(f"mission-runs/{run}/answer", {"answer": "Perhaps"})
        assert (wrong.status, "Yes" in wrong.problem) == (409, True)
        late = web.post(f"mission-runs/{run}/answer", {"answer": "Yes", "step": 0})
        assert (late.status, "answered already" in late.problem) == (409, True)
        assert web.post(f"mission-runs/{run}/answer", {"answer": "Yes", "step": 1}).status == 200
        assert reaches(web, run, "done")["done"]
        until(lambda: ("mission Round", "done") in journal(web), what="its end in the journal")
        assert ("answer Yes", "done") in journal(web)
        page.wait(lambda d: d["t"] == "journal" and any(one["key"] == "mission" for one in d["entries"]))
    assert web.post(f"mission-runs/{run}/answer", {"answer": "Yes"}).status == 409


def test_a_parameter_that_does_not_fit_is_refused(web: Served) -> None:
    save(web, {**TURN, "degrees": "$angle"}, parameters={"angle": 10})
    for given in ({"angle": "far"}, {"other": 1}, {"angle": 1e9}):
        assert web.post("mission-runs", {"file": "round", "parameters": given}).status == 422
    assert web.get("mission-runs").json["runs"] == []


def test_a_queue_is_ordered_shortened_and_emptied(web: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(TokenBucket, "take", lambda *_: True)  # many commands in a second
    save(web, WAIT)
    save(web, TURN, file="turn", name="Turn")
    first = start(web)
    reaches(web, first, "running")
    a, b, c = (start(web, "turn") for _ in range(3))
    assert [run["state"] for run in web.get("mission-runs").json["runs"]] == ["running", *["queued"] * 3]
    moved = web.ask("PATCH", f"mission-runs/{c}", {"place": 0}).json["runs"]
    assert [run["id"] for run in moved] == [first, c, a, b]
    assert web.delete(f"mission-runs/{a}").status == 204
    assert web.delete(f"mission-runs/{a}").status == 404
    assert web.delete(f"mission-runs/{first}").status == 409, "it has begun"
    assert web.post("mission-queue/clear").status == 200
    assert [run["id"] for run in web.get("mission-runs").json["runs"]] == [first]
    start(web, "turn")
    web.post("mission-queue/stop")
    assert [run["state"] for run in web.get("mission-runs").json["runs"]] == ["stopped", "queued"]
    assert web.get("mission-runs").json["paused"], "a stop pauses the queue"
    assert web.post("mission-queue/resume").status == 200
    until(lambda: web.get("mission-runs").json["runs"][-1]["state"] == "done", what="the queue goes on")


def test_a_pause_and_a_resume(web: Served) -> None:
    """By another client than the one who has started it, while the mission has the lease."""
    save(web, WAIT)
    run = start(web)
    until(lambda: web.get("lease").json["holder"] == "mission Round", what="the lease")
    with PageClient(web.port) as page:
        page.of("hello")
        headers = {"x-woosh-session": page.session}
        assert web.post("mission-queue/pause", headers=headers).status == 200
        assert web.get(f"mission-runs/{run}").json["state"] == "paused"
        assert web.post("mission-queue/resume", headers=headers).status == 200
    reaches(web, run, "running")
    assert ("pause the missions", "done") in journal(web)


def test_a_start_needs_the_lease_and_a_stop_does_not(web: Served, chassis: Chassis) -> None:
    save(web, WAIT)
    assert chassis.lease.acquire("the night shift")
    refused = web.post("mission-runs", {"file": "round"})
    assert (refused.status, refused.json["holder"]) == (409, "the night shift")
    chassis.lease.release("the night shift")
    run = start(web)
    until(lambda: web.get("lease").json["holder"] == "mission Round", what="the lease")
    for _ in range(12):  # the rate of commands is not that of stops
        assert web.post("mission-queue/stop", headers={"x-woosh-session": "of nobody"}).status == 200
    assert reaches(web, run, "stopped")["text"]
    until(lambda: web.get("lease").json["holder"] is None, what="the end of the lease")


def test_the_stop_of_the_robot_ends_the_run(web: Served, chassis: Chassis) -> None:
    save(web, {"do": "move", "metres": 3}, TURN)
    run = start(web)
    chassis.measured_velocity.wait_for(lambda velocity: velocity.vx > 0.05, timeout=20)
    assert web.post("stop").json["stands_still"] is True
    assert reaches(web, run, "stopped")["step"] == 0
    assert web.get("mission-runs").json["paused"]
    until(lambda: ("mission Round", "stopped") in journal(web), what="its end in the journal")


@pytest.mark.promise("a STOP while a mission is carried out")
@pytest.mark.parametrize("verb", ["run", "resume"])
def test_a_request_that_waits_for_a_thread_lets_nothing_begin_after_a_stop(
    web: Served, chassis: Chassis, sim: SimulatedChassis, monkeypatch: pytest.MonkeyPatch, verb: str
) -> None:
    """It has arrived before the stop, and is carried out after it: it is refused, and nothing moves."""
    save(web, TURN)
    if verb == "resume":
        web.post("mission-queue/pause")
        chassis.missions.append(chassis.missions.load("round"))
    answers: list[Any] = []
    where, body = ("mission-runs", {"file": "round"}) if verb == "run" else ("mission-queue/resume", None)
    with held(monkeypatch, Missions, verb) as (came, go_on):
        thread, _ = in_thread(lambda: answers.append(web.post(where, body)))
        assert came.wait(10.0)
        assert web.post("stop").json["stands_still"] is True
        go_on.set()
        thread.join(10.0)
    assert answers[0].status == 409, answers
    assert "stopped the robot" in answers[0].problem
    assert chassis.missions.state.run is None
    assert sim.world.motion is None


def test_progress_comes_as_events(web: Served) -> None:
    """Each event has all runs, so that one who comes late misses nothing."""
    save(web, TURN, ASK)
    with closing(http.client.HTTPConnection("127.0.0.1", web.port, timeout=30)) as connection:
        connection.request("GET", "/api/v1/mission-events")
        lines = (line.decode() for line in connection.getresponse())
        events = (json.loads(line.removeprefix("data: ")) for line in lines if line.startswith("data: "))
        assert next(events)["runs"] == []
        run, seen = start(web), set()
        for event in events:
            seen |= {one["state"] for one in event["runs"]}
            if "asking" in seen:
                break
        assert "running" in seen
        web.post(f"mission-runs/{run}/answer", {"answer": "Yes"})
        assert any(event["runs"][-1]["done"] for event in events)


# -- a kill, and two servers ---------------------------------------------------------------------------------


def test_a_run_that_was_interrupted_asks_a_person_and_moves_nothing_before(
    web: Served, chassis: Chassis, sim: SimulatedChassis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The state at a moment of the step is what a kill leaves."""
    save(web, {"do": "move", "metres": 3}, TURN)
    run = start(web)
    chassis.measured_velocity.wait_for(lambda velocity: velocity.vx > 0.05, timeout=20)
    shutil.copytree(tmp_path / "state", tmp_path / "left")
    web.post("mission-queue/stop")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "left"))
    with Chassis(sim.master_uri) as other, serving(other, missions=tmp_path / "missions") as again:
        with PageClient(again.port) as page:
            page.wait(lambda d: d["t"] == "state" and d.get("missions", {}).get("runs"))
        found = again.get(f"mission-runs/{run}").json
        assert (found["state"], found["step"]) == ("interrupted", 0)
        assert ("mission Round", "interrupted") in journal(again)
        here = other.pose.wait(timeout=10)
        assert again.post("mission-queue/resume").status == 200
        asked = reaches(again, run, "asking")
        assert asked["question"]["unknown"]
        assert other.pose.wait(timeout=10).distance_to(here) < 0.05, "nothing has moved"
        assert again.post(f"mission-runs/{run}/answer", {"answer": "done", "step": 0}).status == 200
        assert [one["state"] for one in reaches(again, run, "running")["steps"]] == ["done", ""]
        reaches(again, run, "done")


def test_the_second_of_two_servers_says_so_and_hands_on_what_it_is_asked(
    web: Served, sim: SimulatedChassis, folder: Path
) -> None:
    save(web, ASK)
    assert web.get("mission-runs").json["problem"] is None
    with Chassis(sim.master_uri) as other, serving(other, missions=folder) as second:
        assert "another program" in second.get("mission-runs").json["problem"]["text"]
        run = start(second)
        reaches(web, run, "asking")
        assert second.post(f"mission-runs/{run}/answer", {"answer": "Yes"}).status == 200
        reaches(second, run, "done")


def test_a_full_disk_is_said(web: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device", "/secret/place")

    with monkeypatch.context() as disk:
        disk.setattr(Missions, "save", full)
        refused = web.ask("PUT", "missions/round", {"mission": mission(TURN)})
    assert (refused.status, "secret" in refused.problem) == (503, False)
