"""`chassis.robot_api`: what it asks, what it refuses to send, and that nothing is asked before somebody wants it."""

from __future__ import annotations

import asyncio
import threading
from typing import Any

import pytest

from rosproto.errors import RosTimeout
from tests.support.robot_api_peer import ANSWERS, ApiPeer, Refused
from woosh_pure import Chassis
from woosh_pure.errors import ApiRefused, ChassisError, MotionRefused
from woosh_pure.robot_api import api, wire
from woosh_pure.robot_api.api import RobotApi
from woosh_pure.robot_api.http import ApiRequests, api_address
from woosh_pure.robot_api.values import Scene, Statistics

NOBODY = "127.0.0.1:1"  # no master: nothing here needs one


def robot_api(peer: ApiPeer) -> RobotApi:
    return Chassis(NOBODY, robot_api=peer.address).robot_api


def test_nothing_is_asked_before_somebody_asks() -> None:
    with ApiPeer() as peer:
        chassis = Chassis(NOBODY, robot_api=peer.address)
        assert chassis.robot_api is chassis.robot_api
        assert peer.connections == 0
        assert chassis.robot_api.available()
        assert peer.connections == 1


def test_switched_off_it_says_so_and_asks_nothing() -> None:
    off = Chassis(NOBODY, robot_api=False).robot_api
    assert not off.available()
    for ask in (off.marks, off.facts, off.identity, lambda: off.switch_map("hall")):
        with pytest.raises(ChassisError, match=r"switched off \(robot_api=False\)"):
            ask()


def test_by_default_it_is_the_usual_port_of_the_same_host() -> None:
    assert "http://10.1.2.3:5480/" in repr(Chassis("http://10.1.2.3:11311", robot_api=None).robot_api)


def test_an_invalid_address_is_refused_at_once() -> None:
    with pytest.raises(ValueError, match="expected host:port"):
        Chassis(NOBODY, robot_api="somewhere:port")


def test_maps_are_named() -> None:
    with ApiPeer() as peer:
        robot = robot_api(peer)
        assert robot.scene() == Scene("hall", ("ground",), "ground", 12)
        hall, yard = robot.scenes()
        assert (hall.maps, hall.current_map, yard.maps, yard.current_map) == (
            ("ground", "upper"), "ground", ("yard",), "",
        )  # fmt: skip
        robot.marks("yard")
        assert peer.asked[-1] == ("woosh.map.SceneDataEasy", {"name": "yard"})


def test_history_is_sorted_by_time() -> None:
    with ApiPeer() as peer:
        robot = robot_api(peer)
        assert [record.task_id for record in robot.task_history()] == [-5, 140103000000]
        assert robot.task_history()[0].message == "no\\x1b[31m way"
        assert [event.code for event in robot.events()] == [110201000013]
        assert len(robot.unresolved()) == 1


def test_statistics_read_all_pages_of_tasks() -> None:
    def count(request: str, body: dict[str, Any]) -> Any:
        page = body.get("taskPage", 0)
        tasks = [{"state": 1}] * 100 if page < 2 else [{"state": 2}, {"state": 3}]
        days = [{"mileage": {"start": 100, "end": 350}, "buckets": [{"start": 10, "end": 70}]}]
        return {"operations": {"ops": days}, "tasks": {"ts": tasks}, "taskQty": 202, "abnormalQty": 4}

    with ApiPeer({**ANSWERS, "woosh.robot.CountData": count}) as peer:
        assert robot_api(peer).statistics() == Statistics(250.0, 60.0, 200, 1, 1, 4)
        assert [body.get("taskPage", 0) for _, body in peer.asked[1:]] == [0, 1, 2]


@pytest.mark.promise("a request by `chassis.robot_api` or `woosh api`")
def test_what_moves_the_robot_is_never_sent_by_a_raw_request() -> None:
    """The verbs know how to stop it; a raw request does not."""
    with ApiPeer() as peer:
        robot = robot_api(peer)
        for name, kind in wire.requests().items():
            if kind.kind == "move":
                with pytest.raises(MotionRefused, match="use the verbs of Chassis"):
                    robot.request(name, change=True)
        assert peer.asked == []


def test_what_changes_something_needs_a_word_of_its_own() -> None:
    with ApiPeer() as peer:
        robot = robot_api(peer)
        with pytest.raises(ValueError, match="give change=True"):
            robot.request("setting.Sound", {"mute": True})
        assert peer.asked == []
        assert robot.request("Sound", {"mute": True}, change=True) == {"mute": True, "volume": 40}
        assert peer.asked[-1] == ("woosh.robot.setting.Sound", {"mute": True})


def test_a_request_is_found_by_its_last_word_and_a_wrong_one_is_told_near_ones() -> None:
    with ApiPeer() as peer:
        robot = robot_api(peer)
        assert robot.request("Scene")["mapName"] == "ground"
        with pytest.raises(ValueError, match=r"near names: woosh\.robot\.Scene"):
            robot.request("Scenes")
        with pytest.raises(ValueError, match=r"near names: woosh.map.Delete, woosh.map.mark.storage.Delete"):
            robot.request("Delete")
        with pytest.raises(ValueError, match="has no field 'nam'"):
            robot.request("SceneData", {"nam": "x"})


def test_an_older_device_state_is_not_known() -> None:
    """Before version 1.1.1 it was one number, of another meaning."""
    with ApiPeer({**ANSWERS, "woosh.robot.DeviceState": {"state": 3}}) as peer:
        facts = robot_api(peer).facts()
        assert (facts.emergency_stop, facts.localised, facts.taskable) == (None, None, True)


# -- switching the map


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Looks often."""
    monkeypatch.setattr(api, "SETTLED_SECONDS", 0.0)
    monkeypatch.setattr(api, "_LOOK_SECONDS", 0.01)


class Switching:
    """A robot that names the new map after some looks, and is localised after some more."""

    def __init__(self, named_after: int = 2, localised_after: int = 2) -> None:
        self.left, self.lost = named_after, localised_after
        self.scene = dict(ANSWERS["woosh.robot.Scene"])
        self.wanted: dict[str, Any] = {}
        more = {"SwitchMap": self.switch, "Scene": self.say_scene, "DeviceState": self.say_device}
        self.answers = {**ANSWERS, **{f"woosh.robot.{name}": script for name, script in more.items()}}

    def switch(self, request: str, body: dict[str, Any]) -> Any:
        self.wanted = body
        return {}

    def say_scene(self, request: str, body: dict[str, Any]) -> Any:
        if self.wanted:
            self.left -= 1
            if self.left < 0:
                self.scene.update(
                    sceneName=self.wanted["sceneName"], mapName=self.wanted.get("mapName") or "first"
                )
        return self.scene

    def say_device(self, request: str, body: dict[str, Any]) -> Any:
        self.lost -= 1
        return {"hardware": 0, "software": int(self.lost < 0)}


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("name", ["yard", ""])
def test_a_switch_ends_when_the_robot_names_the_map_and_is_localised(name: str) -> None:
    robot = Switching()
    with ApiPeer(robot.answers) as peer:
        scene = robot_api(peer).switch_map("yard", name)
        assert scene == Scene("yard", (name or "first",), name or "first", 12, localised=True)
        assert peer.requests.count("SwitchMap") == 1


@pytest.mark.usefixtures("quick")
def test_a_switch_says_that_the_robot_is_not_localised(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(api, "LOCALISED_SECONDS", 0.3)
    with ApiPeer(Switching(localised_after=10**6).answers) as peer:
        assert robot_api(peer).switch_map("yard", "yard").localised is False
    with ApiPeer({**Switching().answers, "woosh.robot.DeviceState": {"state": 1}}) as peer:
        assert robot_api(peer).switch_map("yard", "yard").localised is None


@pytest.mark.usefixtures("quick")
def test_a_switch_that_is_never_seen_says_which_map_is_in_use() -> None:
    robot = Switching(named_after=10**6)
    with ApiPeer(robot.answers) as peer, pytest.raises(RosTimeout, match="the robot uses ground of hall"):
        robot_api(peer).switch_map("yard", timeout=0.3)


@pytest.mark.usefixtures("quick")
def test_a_switch_is_refused_while_the_robot_is_busy_and_nothing_is_sent() -> None:
    with ApiPeer({**ANSWERS, "woosh.robot.RobotState": {"state": 4}}) as peer:
        with pytest.raises(MotionRefused, match="nothing was sent: the robot is in task"):
            robot_api(peer).switch_map("yard")
        assert "SwitchMap" not in peer.requests


@pytest.mark.promise("`chassis.robot_api.switch_map`, another map chosen")
@pytest.mark.usefixtures("quick")
def test_a_switch_needs_a_free_base() -> None:
    def drive_is_open(what: str) -> None:
        raise MotionRefused(f"{what} refused")

    with ApiPeer() as peer:
        robot = RobotApi(ApiRequests(api_address(peer.address)), drive_is_open)
        with pytest.raises(MotionRefused, match="switch_map refused"):
            robot.switch_map("yard")
        assert peer.asked == []


@pytest.mark.usefixtures("quick")
def test_a_refused_switch_has_the_robots_words() -> None:
    def refuse(request: str, body: dict[str, Any]) -> Any:
        raise Refused("no such scene")

    with ApiPeer({**ANSWERS, "woosh.robot.SwitchMap": refuse}) as peer:
        with pytest.raises(ApiRefused, match="no such scene"):
            robot_api(peer).switch_map("nowhere")
        with pytest.raises(ValueError, match="give the name of a scene"):
            robot_api(peer).switch_map(" ")


def test_the_awaited_one_does_not_block_the_loop() -> None:
    answer = threading.Event()

    async def both(peer: ApiPeer) -> list[str]:
        robot = Chassis(NOBODY, robot_api=peer.address).aio
        marks = asyncio.ensure_future(robot.robot_api.marks())
        await asyncio.sleep(0)
        assert not marks.done()
        answer.set()
        return [mark.name for mark in await marks]

    with ApiPeer(wait=lambda request: answer.wait(30.0)) as peer:
        assert asyncio.run(both(peer))[0] == "A1"
