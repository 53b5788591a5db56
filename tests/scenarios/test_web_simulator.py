"""The simulation behind a served robot: what the API does to it, and that no real robot has any of it."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.support.waiting import until

pytest.importorskip("fastapi", reason="needs the extra `web`")
pytest.importorskip("uvicorn", reason="needs the extra `web`")
pytest.importorskip("websockets", reason="needs the extra `web`")

from tests.support.web import PageClient, Served, serving
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.enums import RobotState

TOKEN = "a-long-secret"


@pytest.fixture
def web(chassis: Chassis, sim: SimulatedChassis) -> Iterator[Served]:
    with serving(chassis, simulator=sim, token=TOKEN) as served:
        yield served


def change(web: Served, **what: object) -> None:
    answer = web.post("simulator", what)
    assert answer.status == 204, answer


def test_each_change_reaches_the_simulated_robot(
    web: Served, chassis: Chassis, sim: SimulatedChassis
) -> None:
    """The chassis tells of them as a real one would; a reset takes them back."""
    change(web, do="press_emergency_stop")
    until(lambda: sim.world.emergency_stop and not chassis.readiness())
    change(web, do="release_emergency_stop", battery=10.0, speed=2.0)
    until(lambda: bool(chassis.readiness()))
    until(lambda: chassis.battery.wait(10.0).percent == 10)
    assert sim.speed == 2.0
    change(web, obstacle={"x": 2.0, "y": 1.0})
    assert [(x, y) for x, y, _ in sim.world.obstacles] == [(2.0, 1.0)]
    change(web, do="remove_obstacles", teleport={"x": 1.0, "y": 0.0, "yaw": 1.0})
    assert (sim.world.obstacles, sim.pose.x, sim.pose.yaw) == ([], 1.0, 1.0)
    change(web, teleport={"x": 0.5, "y": 0.0})
    assert sim.pose.yaw == 0.0, "as in each place of the API"
    change(web, do="lose_localization")
    until(lambda: sim.world.robot_state is RobotState.UNINITIALISED)
    change(web, do="reset")
    until(lambda: sim.world.robot_state is RobotState.IDLE)
    assert sim.pose == sim.world.site.start
    entries = web.get("journal").json
    assert entries[0]["what"] == 'change the simulation: {"do":"press_emergency_stop"}'
    assert {entry["key"] for entry in entries} == {"simulate"}


def test_what_cannot_be_done_is_refused_in_words(web: Served, sim: SimulatedChassis) -> None:
    wall = web.post("simulator", {"teleport": {"x": 90.0, "y": 0.0}})
    assert wall.status == 422
    assert "wall" in wall.problem
    assert web.post("simulator", {"speed": 0.01}).status == 422
    assert "known: " in web.post("simulator", {"obstacles": []}).problem
    assert sim.world.obstacles == []


def test_the_rules_of_commands_are_those_of_all(web: Served, sim: SimulatedChassis) -> None:
    """Token, origin and rate; but no lease, because anybody in a room can press the emergency stop."""
    stranger = Served(web.port)
    assert stranger.post("simulator", {"do": "reset"}).status == 401
    foreign = web.post("simulator", {"do": "reset"}, headers={"origin": "http://elsewhere.example"})
    assert foreign.status == 403
    with PageClient(web.port, additional_headers={"authorization": f"Bearer {TOKEN}"}) as page:
        assert page.of("hello")["simulator"] == {"speed": sim.speed}
        page.say(t="lease", op="ask")
        until(lambda: web.get("lease").json["holder"] is not None)
        change(web, obstacle={"x": 2.0, "y": 1.0})
    statuses = [web.post("simulator", {"do": "remove_obstacles"}).status for _ in range(20)]
    assert 429 in statuses


def test_a_robot_without_a_simulator_says_so(chassis: Chassis) -> None:
    """Also beside one that has it."""
    with serving({"one": chassis, "two": chassis}) as web:
        answer = web.post("simulator", {"do": "reset"})
        assert answer.status == 409
        assert "woosh --sim web" in answer.problem
        with PageClient(web.port) as page:
            assert page.of("hello")["simulator"] is None


def test_each_of_several_robots_has_its_own(chassis: Chassis, sim: SimulatedChassis) -> None:
    with serving({"one": chassis, "two": chassis}, simulator={"two": sim}) as web:
        assert web.post("simulator", {"do": "reset"}).status == 409
        assert web.post("robots/two/simulator", {"battery": 50.0}).status == 204
