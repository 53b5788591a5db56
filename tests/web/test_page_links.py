"""The page in a browser when the way to the robot is barred, slow or cut: tokens, several robots, lost links."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import pytest

from tests.support.browser import PHONE, person
from tests.support.load import crowd
from tests.support.proxy import FaultProxy
from tests.web.conftest import marks

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web.conftest import Robot
    from woosh_pure.web.server import WebServer

pytestmark = pytest.mark.slow
TOKEN = "made-by-chance-7319"
SLACK = 1.5
"""Seconds on top of the two within which it must be said: other tests use the processor."""


@contextmanager
def served(robots: Any, port: int = 0, **options: Any) -> Iterator[WebServer]:
    """Another server for a chassis that is there."""
    from woosh_pure import web
    from woosh_pure.web.server import WebServer

    with WebServer(web.app(robots, marks=marks(), **options), port=port) as server:
        yield server


def until(condition: Callable[[], Any], page: Page, seconds: float = 20.0) -> Any:
    deadline = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < deadline, "it did not come true"
        page.wait_for_timeout(50)
    return found


def said_lost(page: Page, began: float, text: str) -> None:
    """In words, within two seconds; and all that is old looks old."""
    page.wait_for_selector(f"#lost:not(.hidden) >> text={text}")
    assert time.monotonic() - began < 2.0 + SLACK * crowd()
    assert "gone" in (page.get_attribute("body", "class") or "")
    grey = page.evaluate(
        """(() => { const probe = document.createElement("p"); probe.className = "quiet"; document.body.append(probe);
        const { color } = getComputedStyle(probe); probe.remove(); return color; })()"""
    )
    old = """['#state', '#battery'].map((one) => { const style = getComputedStyle(document.querySelector(one));
    return [style.color, style.textDecorationLine]; })"""
    assert page.evaluate(old) == [[grey, "none"]] * 2, "grey, and not crossed out"
    assert "grayscale" in page.evaluate("getComputedStyle(canvas).filter")


def said_back(page: Page) -> None:
    """By itself, without a touch."""
    page.wait_for_selector("#lost", state="hidden")
    assert "gone" not in (page.get_attribute("body", "class") or "")


def test_a_wrong_token_in_the_address_is_said_to_be_wrong(browser: Browser, robot: Robot) -> None:
    with (
        served({"sim": robot.chassis}, token=TOKEN) as server,
        person(browser, server.url, path="#token=another-one", ready="#token-input") as page,
    ):
        assert page.inner_text("#token .why") == "This is not the token."
        page.fill("#token-input", TOKEN)
        page.click("#token-use")
        page.wait_for_selector(".markrow")


def test_a_token_is_asked_for_until_it_is_right_and_then_kept(browser: Browser, robot: Robot) -> None:
    """A wrong one is said to be wrong; the right one opens the page at once, and again after a reload."""
    with (
        served({"sim": robot.chassis}, token=TOKEN) as server,
        person(browser, server.url, PHONE, ready="#token-input") as page,
    ):
        assert page.evaluate("document.activeElement.id") == "token-input"
        assert page.get_attribute("#token-input", "type") == "password"
        page.check("#token-shown")
        assert page.get_attribute("#token-input", "type") == "text"
        page.keyboard.press("Escape")
        assert page.is_visible("#token"), "there is nothing behind it"
        assert "the whole address, with #token=" in page.inner_text("#token")
        page.wait_for_selector("#lost >> text=This page is not let in")
        page.fill("#token-input", "this is a guess")
        page.keyboard.press("Enter")
        page.wait_for_selector("#token >> text=This is not the token.")
        page.fill("#token-input", f" {TOKEN} ")
        page.tap("#token-use")
        page.wait_for_selector(".markrow")
        assert page.is_hidden("#token")
        page.reload()
        page.wait_for_selector(".markrow")
        assert page.is_hidden("#token")
        assert TOKEN not in page.evaluate(
            "JSON.stringify([localStorage, sessionStorage, document.cookie, location])"
        )


def test_a_token_in_the_address_is_used_and_taken_out(browser: Browser, robot: Robot) -> None:
    """As `woosh web --token` prints it."""
    with (
        served({"sim": robot.chassis}, token=TOKEN) as server,
        person(browser, server.url, path=f"#token={TOKEN}") as page,
    ):
        assert page.url == server.url


def test_each_robot_has_its_page_and_its_orders(browser: Browser, robot: Robot) -> None:
    """The switch leads to the other one, whose goals are its own; and back."""
    from woosh_pure import Chassis, SimulatedChassis

    with (
        SimulatedChassis(speed=3, full_graph=False) as yard,
        Chassis(yard.master_uri) as second,
        served({"hall": robot.chassis, "back-yard": second}) as server,
        person(browser, server.url) as page,
    ):
        began = robot.place
        page.wait_for_selector("#robots:not(.hidden)")
        assert page.inner_text("#robot-name") == "hall"
        page.select_option("#robots select", "back-yard")
        page.wait_for_url("**/robots/back-yard/")
        page.wait_for_selector("#robot-name >> text=back-yard")
        page.click(".markrow >> text=A1")
        page.click("#confirm button[type=submit]")
        page.wait_for_selector("#task >> text=Arrived", timeout=60_000)
        assert yard.pose.distance_to(yard.world.site.marks["A1"].pose) < 0.3
        assert robot.away(*began) < 0.05
        page.select_option("#robots select", "hall")
        page.wait_for_selector("#robot-name >> text=hall")
        assert page.url == server.url
        page.click("#tabbutton-log")
        page.wait_for_selector("#journal >> text=Nothing yet.")


def test_a_class_is_seen_in_one_table_and_reset_by_one_button(browser: Browser, robot: Robot) -> None:
    """What each simulated robot does; its name leads to its page, from the page of each."""
    from woosh_pure import Chassis, SimulatedChassis

    with (
        SimulatedChassis(speed=3, full_graph=False) as yard,
        Chassis(yard.master_uri) as second,
        served(
            {"hall": robot.chassis, "yard": second}, simulator={"hall": robot.sim, "yard": yard}
        ) as server,
        person(browser, server.url, path="robots/yard/") as page,
    ):
        page.click("#tabbutton-sim")
        page.wait_for_selector("#class tr:has-text('hall') >> text=idle")
        page.wait_for_selector("#class tr:has-text('yard') >> text=%")
        yard.add_obstacle(3.0, 0.0)
        robot.chassis.go_to_mark("B1")
        page.wait_for_selector("#class tr:has-text('hall') >> text=In a task")
        resets = robot.sim.resets, yard.resets
        page.click("#class-reset")
        until(lambda: (robot.sim.resets, yard.resets) == (resets[0] + 1, resets[1] + 1), page)
        assert yard.world.obstacles == []
        page.click("#class a >> text=hall")
        page.wait_for_selector("#robot-name >> text=hall")
        assert page.url == server.url


def test_a_link_that_is_cut_is_said_and_comes_back(browser: Browser, robot: Robot) -> None:
    """Three seconds without a byte, while it drives to a mark: the page goes on where the robot is by then."""
    with (
        FaultProxy("127.0.0.1", robot.server.port) as proxy,
        person(browser, f"http://127.0.0.1:{proxy.port}/", PHONE) as page,
    ):
        page.tap(".markrow >> text=B1")
        page.tap("#confirm button[type=submit]")
        page.wait_for_selector("#task progress")
        proxy.stall()
        began = time.monotonic()
        said_lost(page, began, "No answer from the server")
        page.wait_for_timeout(max(0.0, 3000 - 1000 * (time.monotonic() - began)))
        proxy.resume()
        said_back(page)
        page.wait_for_selector("#task >> text=Arrived", timeout=60_000)


def test_a_stop_without_a_link_says_so(browser: Browser, robot: Robot) -> None:
    """The one who presses must not believe that it stops."""
    with (
        FaultProxy("127.0.0.1", robot.server.port) as proxy,
        person(browser, f"http://127.0.0.1:{proxy.port}/", PHONE) as page,
    ):
        proxy.stall()
        page.tap("#stop")
        page.wait_for_selector("#stop-answer.bad >> text=Use the red button on the robot.", timeout=5000)
        proxy.refusing = True
        proxy.reset()  # before anything goes on: else the stop that waits could still arrive
        proxy.resume()
        page.wait_for_selector("#stop-answer.bad >> text=The stop did not reach the robot.")


def test_a_server_that_was_started_again_is_found(browser: Browser, robot: Robot) -> None:
    """Said within two seconds; nothing of the old one's list is shown as if the new one had done it."""
    with FaultProxy("127.0.0.1", 9) as proxy, served({"sim": robot.chassis}) as first:
        proxy.retarget("127.0.0.1", first.port)
        with person(browser, f"http://127.0.0.1:{proxy.port}/") as page:
            page.click(".markrow >> text=W1")
            page.click("#confirm button[type=submit]")
            page.click("#tabbutton-log")
            page.wait_for_selector("#journal >> text=Go to W1")
            first.close()
            said_lost(page, time.monotonic(), "No answer from the server")
            with served({"sim": robot.chassis}) as second:
                proxy.retarget("127.0.0.1", second.port)
                said_back(page)
                page.wait_for_selector("#journal >> text=Nothing yet.")


def test_a_robot_that_is_lost_is_said_by_a_server_that_lives(browser: Browser, robot: Robot) -> None:
    """Its values look old, why it would not move is not known any more, and all comes back."""
    with person(browser, robot.url, language="zh-CN", scheme="dark") as page:
        page.click("#tabbutton-health")
        robot.sim.press_emergency_stop()
        page.wait_for_selector("#notices >> text=急停已按下。")
        page.wait_for_selector("#tab-health >> text=现在不能移动。")
        robot.sim.fall_silent(4.0)
        page.wait_for_selector("#lost:not(.hidden) >> text=机器人已失联")
        page.wait_for_selector("#tab-health >> text=不能确定。")
        assert page.inner_text("#notices") == ""
        assert page.locator("td.old").count() > 5
        said_back(page)
        page.wait_for_selector("#notices >> text=急停已按下。")
        until(lambda: page.locator("td.old").count() == 0, page)
