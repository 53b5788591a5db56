"""The tab Missions in a real browser: a round is made, started, answered on a small phone, ended, and seen by all."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from tests.support.browser import DESKTOP, person
from tests.support.waiting import until
from tests.web.test_page_small import _MISSED

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web.conftest import Robot
    from woosh_pure.missions import Missions

pytestmark = pytest.mark.slow
SMALL = (320, 568)
ROUND = {
    "mission": 1,
    "name": "Round",
    "step": [
        {"do": "rotate", "degrees": 20},
        {
            "do": "ask",
            "text": "Is it loaded?",
            "answers": {"Yes, it is": "next", "No": "stop", "Later": "end"},
        },
        {"do": "wait", "seconds": 600},
    ],
}


@pytest.fixture
def missions(robot: Robot, tmp_path: Path) -> Iterator[Missions]:
    """The missions of the hall, in a folder of this test; none is under way."""
    found = robot.chassis.missions
    found.files = tmp_path / "missions"
    found.clear()
    yield found
    found.stop()


def open_tab(page: Page) -> None:
    page.click("#tabbutton-missions")
    page.wait_for_selector("#missions")


def begin(page: Page) -> None:
    """Start the only mission."""
    open_tab(page)
    page.click("#missions .saved .primary")
    page.click("#confirm [type=submit]")


def missed(page: Page, *selectors: str) -> Any:
    """Those that a finger on their middle would not hit."""
    return page.evaluate(_MISSED, list(selectors))


def test_a_round_is_made_started_answered_and_ends_in_the_log(
    browser: Browser, robot: Robot, missions: Missions
) -> None:
    """On the smallest phone, with nothing but the page: three steps, the first by a touch of a mark on the map."""
    with person(browser, robot.url, SMALL) as page:
        open_tab(page)
        page.click("#mission-new")
        page.fill("#mission-name", "Round")
        box = page.locator("#canvas").bounding_box()
        assert box is not None
        for at in range(
            400
        ):  # where the pins are depends on the map; a touch beside them, or before it, does nothing
            page.mouse.click(box["x"] + 20 + at % 8 * 36, box["y"] + 60 + at // 8 % 5 * 18)
            if page.locator("#step-0-mark").count():
                break
        mark = page.input_value("#step-0-mark")
        assert mark in robot.sim.world.site.marks
        page.click("#mission-add")
        page.select_option("#step-1", "ask")
        page.fill("#step-1-text", "Is it loaded?")
        for at, answer in enumerate(("Yes", "No")):
            page.fill(f"#step-1-answers-{at}", answer)
        page.fill("#step-1-answers-1-to", "stop")
        page.click("#mission-add")
        page.select_option("#step-2", "wait")
        page.fill("#step-2-seconds", "much")
        page.click("#mission-save")
        page.wait_for_selector("#editor .why >> text=seconds")
        page.fill("#step-2-seconds", "0.2")
        page.click("#mission-save")
        page.wait_for_selector("#missions .saved >> text=Round")
        (stored,) = missions.list()
        assert stored.mission is not None
        assert [step.data() for step in stored.mission.steps] == [
            {"do": "go_to_mark", "mark": mark},
            {"do": "ask", "text": "Is it loaded?", "answers": {"Yes": "next", "No": "stop"}},
            {"do": "wait", "seconds": 0.2},
        ]
        begin(page)
        page.wait_for_selector("#mission .steps [aria-current]")
        page.wait_for_selector("#mission .question >> text=Is it loaded?", timeout=60_000)
        yes = "#mission fieldset button:first-child"
        assert missed(page, "#mission .question", yes, "#mission-pause", "#mission-stop", "#stop") == []
        page.click(yes)
        page.wait_for_selector("#mission", state="hidden")
        assert "Done" in page.inner_text("#mission-runs")
        page.click("#tabbutton-log")
        page.wait_for_selector("#journal .entry.ok >> text=Mission Round")
    place = robot.sim.world.site.marks[mark].pose
    assert robot.away(place.x, place.y) < 0.3


def test_every_page_sees_a_run_and_can_pause_answer_and_end_it(
    browser: Browser, robot: Robot, missions: Missions
) -> None:
    """Also one that is opened later, on another tab; the page that has started it may be closed."""
    missions.save("round", ROUND)
    with person(browser, robot.url, DESKTOP) as page:
        begin(page)
        page.wait_for_selector("#mission .question")
    with person(browser, robot.url, SMALL) as page:
        page.click("#tabbutton-health")
        page.wait_for_selector("#mission .question >> text=Is it loaded?")
        assert missed(page, "#mission .question", "#mission-stop", "#stop") == []
        page.click("#mission >> text=Yes, it is")
        page.wait_for_selector("#mission >> text=Step 3 of 3")
        page.click("#mission-pause")
        page.click("#mission-resume")
        page.click("#mission-stop")
        page.wait_for_selector("#mission", state="hidden")
    until(lambda: robot.chassis.lease.holder is None, what="the end of the lease")
    run = missions.state.run
    assert run is not None
    assert run.phase.value == "stopped"


def test_stop_ends_a_run_and_pauses_the_queue(browser: Browser, robot: Robot, missions: Missions) -> None:
    missions.save("round", {**ROUND, "step": [{"do": "move", "metres": 3}]})
    with person(browser, robot.url, SMALL) as page:
        begin(page)
        begin(page)
        robot.chassis.measured_velocity.wait_for(lambda velocity: velocity.vx > 0.05, timeout=20)
        page.click("#stop")
        page.wait_for_selector("#stop-answer.ok")
        page.wait_for_selector("#queue-resume")
        assert robot.speed < 0.02
        page.click("#mission-runs .entry.running .close")
        page.wait_for_selector("#queue-resume", state="detached")


def test_a_new_mission_does_not_replace_one_of_its_name(
    browser: Browser, robot: Robot, missions: Missions
) -> None:
    """The editor stays open, and says so."""
    missions.save("round", ROUND)
    with person(browser, robot.url) as page:
        open_tab(page)
        page.click("#mission-new")
        page.fill("#mission-name", "round")
        page.click("#mission-add")
        page.fill("#step-0-mark", "A1")
        page.click("#mission-save")
        page.wait_for_selector("#editor .why >> text=of this name already")
    assert missions.load("round").name == ROUND["name"]
