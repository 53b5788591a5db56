"""What a finger on a phone does to the page: a swipe that scrolls sets nothing."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import pytest

from tests.support.browser import PHONE, person
from tests.support.load import crowd
from tests.web.test_page_alone import allow, hold, served, until  # noqa: F401 (a fixture)

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web.fake_server import Fake

pytestmark = pytest.mark.slow
SMALL_PHONE: Any = {"width": 375, "height": 667}


def swipe(page: Page, start: tuple[float, float], by: tuple[float, float]) -> None:
    """Put one finger down, move it in ten steps, and lift it, as the screen of a phone reports it."""
    device = page.context.new_cdp_session(page)
    steps = [{"x": start[0] + by[0] * i / 10, "y": start[1] + by[1] * i / 10} for i in range(11)]
    for i, point in enumerate(steps):
        kind = "touchMove" if i else "touchStart"
        device.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [point]})
        page.wait_for_timeout(16)
    device.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})


def test_a_swipe_that_scrolls_leaves_the_speed(browser: Browser, served: tuple[Fake, str]) -> None:  # noqa: F811
    """Wherever it begins on the slider; a drag along the slider sets the speed, and so do the keys."""
    with person(browser, served[1], PHONE) as page:
        page.set_viewport_size(SMALL_PHONE)
        allow(page)
        slider = page.locator("#speed")
        panel = page.locator("#panel")
        for part in (0.1, 0.5, 0.9):
            slider.scroll_into_view_if_needed()
            box = slider.bounding_box()
            assert box is not None
            at = (box["x"] + part * box["width"], box["y"] + box["height"] / 2)
            before = panel.evaluate("(panel) => panel.scrollTop")
            for distance in (90, -90):
                swipe(page, at, (4, distance))
                page.wait_for_timeout(100)
                if panel.evaluate("(panel) => panel.scrollTop") != before:
                    break
            else:
                pytest.fail("it did not scroll")
            assert slider.input_value() == "0.5", part
        slider.scroll_into_view_if_needed()
        box = slider.bounding_box()
        assert box is not None
        swipe(page, (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2), (60, 2))
        until(lambda: float(slider.input_value()) > 0.5, page)
        set_ = float(slider.input_value())
        slider.press("ArrowLeft")
        assert float(slider.input_value()) == pytest.approx(set_ - 0.1)


CALL = {
    "key": "call",
    "text": "another motion of this program",
    "values": {},
    "blocking": True,
    "doubt": False,
}
GOAL = {"id": "1", "kind": "mark", "who": "a program", "state": "running", "done": False}


def test_the_pad_names_one_reason_until_it_is_let_go(browser: Browser, served: tuple[Fake, str]) -> None:  # noqa: F811
    """In the language of the page, also of one that is changed meanwhile; then it says what is so now."""
    fake, url = served
    with person(browser, url, PHONE) as page:
        allow(page)
        for goals, english, chinese in (
            ([GOAL], "A task is under way.", "有任务正在进行。"),
            ([], "STOP was pressed.", "按了停止。"),
        ):
            fake.goals = goals
            page.wait_for_selector("#task progress", state="attached" if goals else "hidden")
            fake.drive = {
                "state": "refused",
                "reason": "refused",
                "kind": "motion-refused",
                "reasons": [CALL],
            }
            hold(page)
            page.wait_for_selector(f".drivestate >> text=Ended: {english} Let go")
            page.evaluate("document.querySelector('#language').click()")
            page.wait_for_selector(f".drivestate >> text=已结束：{chinese}")
            page.evaluate("document.querySelector('#language').click()")
            page.mouse.up()
            page.wait_for_selector(
                f".drivestate >> text={'A task is under way' if goals else 'Ready to drive'}"
            )
        fake.drive = {"state": "driving"}
        hold(page)
        page.wait_for_selector(".drivestate.driving")
        page.keyboard.press("Escape")
        page.wait_for_selector(".drivestate >> text=Ended: STOP was pressed.")
        page.mouse.up()
        page.wait_for_selector(".drivestate >> text=Ready to drive")


def test_a_robot_that_stands_on_its_way_is_said_to_stand(browser: Browser, served: tuple[Fake, str]) -> None:  # noqa: F811
    """Within three seconds, and no longer than it stands; not while its velocity is not known."""
    fake, url = served
    with person(browser, url, PHONE) as page:
        fake.goals = [{**GOAL, "metres_left": 5.1}]
        page.wait_for_selector("#task >> text=5.1 m left")
        fake.moves = False
        began = time.monotonic()
        page.wait_for_selector("#task >> text=It stands at present; something may be in the way.")
        assert 1.5 < time.monotonic() - began < 3.5 * crowd()
        fake.moves = True
        page.wait_for_selector("#task >> text=5.1 m left")


def test_health_does_not_say_ready_above_a_refusal(browser: Browser, served: tuple[Fake, str]) -> None:  # noqa: F811
    fake, url = served
    with person(browser, url, PHONE) as page:
        page.click("#tabbutton-health")
        page.wait_for_selector(".answerline.ok")
        refused = {"key": "refused", "text": "refused", "values": {}, "blocking": False, "doubt": False}
        fake.ready = {"answer": "yes", "text": "", "reasons": [refused]}
        page.wait_for_selector("#tab-health >> text=It refused the last motion.")
        assert page.inner_text(".answerline") == "Not known for certain."
