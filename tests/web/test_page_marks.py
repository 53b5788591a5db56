"""The marks of the page in a real browser: saved by a new user, changed, taken off; many of them; and control
taken over from a program.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import pytest

from tests.support.browser import DESKTOP, PHONE, person
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.marks import MarkFile, UserMark

if TYPE_CHECKING:
    from pathlib import Path

    from playwright.sync_api import Browser, Page

    from tests.web.conftest import Robot

pytestmark = pytest.mark.slow
MANY = [UserMark(f"Regal {i:02}", Pose2D(-5.0 + i % 9, -3.5 + i // 9), "Halle 2") for i in range(67)]


@pytest.fixture
def file(tmp_path: Path) -> MarkFile:
    return MarkFile(tmp_path / "marks.json")


@pytest.fixture
def url(robot: Robot, file: MarkFile) -> Iterator[str]:
    """The page of the hall with a list of its own."""
    from woosh_pure import web
    from woosh_pure.web.server import WebServer

    with WebServer(web.app(robot.chassis, marks=file), port=0) as server:
        yield server.url


def until(condition: Callable[[], Any], page: Page, seconds: float = 20.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "it did not come true"
        page.wait_for_timeout(50)


def rows(page: Page) -> int:
    return page.locator(".markrow").count()


def save(page: Page) -> None:
    page.click("#confirm button[type=submit]")
    page.wait_for_selector("#confirm", state="hidden")


@pytest.mark.parametrize("size", [pytest.param(PHONE, id="phone"), pytest.param(DESKTOP, id="desktop")])
def test_a_new_user_saves_a_mark_and_drives_there(
    browser: Browser, robot: Robot, url: str, file: MarkFile, size: Any
) -> None:
    """As with `--master`: nothing is there yet. What is saved is in the user's list, and `Go` goes there."""
    with person(browser, url, size, ready="#no-marks:not(.hidden)") as page:
        until(lambda: (page.text_content("#pose-text") or "").startswith("x"), page)
        page.click("#mark-here")
        page.fill("#mark-name", "here")
        save(page)
        page.wait_for_selector(".markrow >> text=here")
        page.wait_for_selector("#no-marks", state="hidden")
        page.click("#mark-place")
        page.fill("#mark-name", "there")
        page.fill("#place-x", "1")
        page.fill("#place-y", "0")
        save(page)
        page.click(".markrow >> text=there")
        save(page)
        page.wait_for_selector("#task >> text=Arrived", timeout=60_000)
    assert robot.away(1.0, 0.0) < 0.3
    file.refresh()
    assert [(mark.name, mark.on_chassis) for mark in file] == [("here", False), ("there", False)]


def test_a_mark_is_renamed_and_deleted(browser: Browser, url: str, file: MarkFile) -> None:
    file.keep([UserMark("A", Pose2D(1.0, 1.0)), UserMark("B")])
    with person(browser, url) as page:
        page.click("button[aria-label='Change A']")
        page.fill("#mark-name", "B")
        assert (
            page.evaluate("document.querySelector('#mark-name').validationMessage")
            == "Another mark has this name."
        )
        page.fill("#mark-name", "仓库 <b>1/2</b>")
        page.fill("#mark-note", "east door")
        save(page)
        page.wait_for_selector(".markrow >> text=仓库 <b>1/2</b>")
        page.click("button[aria-label='Change B']")
        page.click("#mark-delete")
        assert page.inner_text("#confirm-text") == "Delete B from this list?"
        save(page)
        until(lambda: rows(page) == 1, page)
    file.refresh()
    assert list(file) == [UserMark("仓库 <b>1/2</b>", Pose2D(1.0, 1.0), "east door")]


def test_a_mark_that_only_the_robot_knows_is_typed(browser: Browser, robot: Robot, url: str) -> None:
    with person(browser, url, ready="#no-marks:not(.hidden)") as page:
        page.fill("#mark-search", "P1")
        page.click("#mark-other")
        assert page.inner_text("#confirm-text") == "Go to P1?"
        save(page)
        page.wait_for_selector("#task >> text=Arrived", timeout=60_000)
    mark = robot.sim.world.site.marks["P1"].pose
    assert robot.away(mark.x, mark.y) < 0.3


@pytest.mark.parametrize("size", [(320, 640), PHONE, DESKTOP])
def test_many_marks_push_nothing_away(browser: Browser, url: str, file: MarkFile, size: Any) -> None:
    """The list scrolls by itself, a search finds one, and nothing is wider than the screen."""
    file.keep([*MANY, UserMark("R" * 100, note="n" * 150)])
    with person(browser, url, size) as page:
        until(lambda: rows(page) == 68, page)
        high = "document.querySelector('#mark-list').getBoundingClientRect().height"
        assert page.evaluate(high) <= max(216, 0.37 * size[1])
        assert page.evaluate("document.querySelector('#mark-list').scrollHeight") > 2000
        assert page.evaluate("document.documentElement.scrollWidth") <= size[0]
        assert page.evaluate(
            "document.querySelector('#panel').scrollWidth <= document.querySelector('#panel').clientWidth"
        )
        page.fill("#mark-search", "regal 66")
        until(lambda: rows(page) == 2, page)
        page.keyboard.press("Enter")
        assert page.inner_text("#confirm-text") == "Go to Regal 66?"


def test_control_is_taken_over_from_a_program_by_asking_twice(
    browser: Browser, robot: Robot, url: str
) -> None:
    """To go somewhere asks once; the page then asks the person whether to take over."""
    assert robot.chassis.lease.acquire("the night shift")
    with person(browser, url, ready="#no-marks:not(.hidden)") as page:
        page.fill("#mark-search", "A1")
        page.click("#mark-other")
        page.click("#confirm button[type=submit]")
        page.wait_for_selector("#confirm >> text=Take control over from the night shift?")
        assert robot.chassis.lease.holder == "the night shift"
        save(page)
        page.wait_for_selector("#task progress")
        assert robot.chassis.lease.holder != "the night shift"
