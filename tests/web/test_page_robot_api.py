"""What the robot names by its Robot API, on the page: its marks, its map with a choice of all, its outline."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import pytest

from tests.support.browser import DESKTOP, PHONE, person
from tests.support.robot_api_peer import ANSWERS, ApiPeer
from tests.web.test_page_marks import until
from woosh_pure import Chassis
from woosh_pure.maps.marks import UserMark
from woosh_pure.robot_api import api

if TYPE_CHECKING:
    from playwright.sync_api import Browser

    from tests.web.conftest import Robot

pytestmark = pytest.mark.slow


@pytest.fixture
def peer() -> Iterator[ApiPeer]:
    with ApiPeer() as robot:
        yield robot


@pytest.fixture
def url(robot: Robot, peer: ApiPeer) -> Iterator[str]:
    """The page of the hall, whose robot has a Robot API, with one mark on the user's list."""
    from woosh_pure import web
    from woosh_pure.web.server import WebServer

    own = UserMark("home", None, "mine")
    with (
        Chassis(robot.sim.master_uri, robot_api=peer.address) as chassis,
        WebServer(web.app(chassis, marks=[own]), port=0) as server,
    ):
        yield server.url


def test_the_robots_marks_are_searched_and_driven_to_and_not_changed(
    browser: Browser, robot: Robot, url: str, peer: ApiPeer
) -> None:
    with person(browser, url, PHONE, ready="#mark-list li:nth-child(5)") as page:
        assert page.locator("#mark-list button[aria-label^='Change']").count() == 1, (
            "that of the user's own mark"
        )
        page.fill("#mark-search", "door")
        until(lambda: page.locator(".markrow strong").all_text_contents() == ["A1", "door"], page)
        assert "shelf by the door" in (page.text_content("#mark-list") or "")
        page.click(".markrow >> text=A1")
        page.click("#confirm button[type=submit]")
        until(lambda: robot.sim.world.tasks.task_id != 0 and robot.speed > 0.0, page)
        page.click("#stop")
        until(lambda: robot.speed == 0.0, page)


def test_another_map_is_chosen_after_a_question(
    browser: Browser, url: str, peer: ApiPeer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(api, "SETTLED_SECONDS", 0.0)

    def switch(request: str, body: dict[str, Any]) -> Any:
        peer.answers["woosh.robot.Scene"] = {
            "sceneName": body["sceneName"],
            "mapName": body["mapName"],
            "version": "1",
        }
        peer.answers["woosh.map.SceneDataEasy"] = {**ANSWERS["woosh.map.SceneDataEasy"], "maps": []}
        return {}

    peer.answers["woosh.robot.SwitchMap"] = switch
    with person(browser, url, DESKTOP, ready="#map-choice select") as page:
        select = page.locator("#map-choice select")
        shown = lambda: select.evaluate("one => one.selectedOptions[0].textContent")  # noqa: E731
        assert select.locator("option").all_text_contents() == [
            "hall · ground",
            "hall · upper",
            "yard · yard",
        ]
        assert shown() == "hall · ground"
        select.select_option("yard · yard")
        page.wait_for_selector("#confirm-text >> text=yard")
        assert shown() == "hall · ground", "nothing is changed before the answer"
        assert "SwitchMap" not in peer.requests
        page.click("#confirm button[type=submit]")
        until(lambda: shown() == "yard · yard", page)
        assert peer.requests.count("SwitchMap") == 1
        until(lambda: page.locator(".markrow strong").all_text_contents() == ["home"], page)
