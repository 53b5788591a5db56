"""The page in Chromium over a poor radio link: 200 ms each way, 30 kB/s, outages of two seconds and more."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import pytest

from tests.support.browser import PHONE, person
from tests.support.slow_link import SlowLink
from tests.support.web import Velocities
from tests.web.test_page_links import said_back, said_lost, until
from tests.web.test_page_robot import allow

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web.conftest import Robot

pytestmark = pytest.mark.slow
_SIZES = """
() => performance.getEntriesByType("resource").reduce(([sent, meant], one) =>
  [sent + one.encodedBodySize, meant + one.decodedBodySize], [0, 0])
"""
"""The bytes of what has come, as they were sent and as they are meant."""
RATE = 30_000
PROMISED = 0.5


@contextmanager
def far(browser: Browser, robot: Robot, latency: float) -> Iterator[tuple[Page, SlowLink]]:
    """Somebody with a phone, who goes far away once the page has come."""
    with (
        SlowLink("127.0.0.1", robot.server.port, latency=0.0, rate=10_000_000) as link,
        person(browser, f"http://127.0.0.1:{link.port}/", PHONE) as page,
    ):
        link.latency, link.rate = latency, RATE
        yield page, link


def test_stop_works_before_the_rest_of_the_page_has_come(browser: Browser, robot: Robot) -> None:
    """It can be seen first, so it has to work first; and it is answered when the page is there."""
    with SlowLink("127.0.0.1", robot.server.port, latency=0.2, rate=RATE) as link:
        context = browser.new_context(viewport={"width": PHONE[0], "height": PHONE[1]}, locale="en-US")
        try:
            page = context.new_page()
            goal = robot.chassis.go_to_mark("B1")
            page.goto(f"http://127.0.0.1:{link.port}/", wait_until="commit")
            painted = "performance.getEntriesByName('first-contentful-paint')[0]?.startTime ?? 0"
            first_paint = until(lambda: page.evaluate(painted), page)
            assert first_paint < 8000, "about 10 kB and three ways there and back"
            assert page.get_attribute("#stop", "data-early") == "waits"
            page.locator("#stop").dispatch_event("pointerdown", {"button": 0})
            assert page.inner_text("#stop-answer") == "Stopping…"
            until(lambda: robot.speed < 0.02, page)
            assert page.locator(".markrow").count() == 0, "the rest is still under way"
            page.wait_for_selector("#stop-answer >> text=The robot stands still.", timeout=40_000)
            assert goal.done
            sent, meant = page.evaluate(_SIZES)
            assert sent < meant / 2.0, "compressed"
            assert sent < 120_000
        finally:
            context.close()


def test_it_stays_usable_and_says_what_is_old(browser: Browser, robot: Robot) -> None:
    """Poses go on coming beside the costmap; an outage is said in words and is over by itself; STOP is answered."""
    with far(browser, robot, 0.2) as (page, link):
        page.tap(".markrow >> text=B1")
        page.tap("#confirm button[type=submit]")
        page.wait_for_selector("#task progress")
        page.click("#costmap")
        seen: set[str] = set()
        page.evaluate("window.shown = 0; new MutationObserver(() => (window.shown += !document.querySelector('#lost')"
                      ".classList.contains('hidden'))).observe(document.querySelector('#lost'), {attributes: true})")  # fmt: skip
        for _ in range(15):
            page.wait_for_timeout(200)
            seen.add(page.evaluate("document.querySelector('#pose-text').textContent"))
        assert len(seen) >= 5, "the costmap is in no pose's way"
        assert page.evaluate("window.shown") == 0, "a slow link is no lost one"
        link.outage(4.0)
        said_lost(page, time.monotonic(), "No answer from the server")
        said_back(page)
        began = time.monotonic()
        page.tap("#stop")
        page.wait_for_selector("#stop-answer >> text=The robot stands still.")
        assert time.monotonic() - began < 8.0
        assert robot.speed < 0.02


def test_an_outage_while_driving_is_a_zero_in_time(browser: Browser, robot: Robot) -> None:
    """The finger stays on the pad, and what it sent arrives three seconds later: nothing of it moves the robot. The
    connection lives on, and the page says why the drive is over.
    """
    with far(browser, robot, 0.05) as (page, link), Velocities(robot.sim.master_uri) as witness:
        allow(page)
        box = page.locator(".pad").bounding_box()
        assert box is not None
        for _ in range(6):  # a busy computer lets go
            since = time.monotonic()
            page.mouse.move(box["x"] + 110, box["y"] + 110)
            page.mouse.down()
            page.mouse.move(box["x"] + 110, box["y"] + 30)
            if witness.moves(since):
                break
            page.mouse.up()
        else:
            pytest.fail("this computer is too busy to hold anything")
        link.outage(3.0)
        began = time.monotonic()
        assert witness.seconds_to_zero(began, watch=4.0) < PROMISED
        page.wait_for_selector(".drivestate.bad", timeout=5000)
        page.mouse.up()
        assert "Connected again" not in page.inner_text("#toasts")


def test_who_is_too_far_away_is_told_that_driving_is_refused(browser: Browser, robot: Robot) -> None:
    """400 ms there and back: what the driver sees is too old to drive by. Nothing is sent to the robot."""
    with far(browser, robot, 0.25) as (page, _), Velocities(robot.sim.master_uri) as witness:
        allow(page)
        box = page.locator(".pad").bounding_box()
        assert box is not None
        page.mouse.move(box["x"] + 110, box["y"] + 30)
        page.mouse.down()
        page.wait_for_selector(".drivestate >> text=the network is too slow to drive through")
        page.mouse.up()
        assert not any(vx or wz for _, vx, wz in witness.heard)
