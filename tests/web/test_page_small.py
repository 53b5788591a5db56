"""The page on phones, held upright and on the side: each control that a user needs is where a finger finds it.

Hit tests at the sizes of real phones: the topmost element at the middle of a control is the control itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import pytest

from tests.support.browser import person
from tests.web.test_page_fits import TABS

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web.fake_server import Fake

pytestmark = pytest.mark.slow
PHONES = [(568, 320), (640, 360), (667, 375), (740, 360), (812, 375), (844, 390), (915, 412)]
each_phone = pytest.mark.parametrize(
    "size",
    [*PHONES, *((short, long) for long, short in PHONES)],
    ids=lambda size: f"{size[0]}x{size[1]}",
)
MARKS = [
    {"name": f"{'ABC'[n % 3]}{n // 3 + 1}", "x": n - 3.0, "y": 1.0, "yaw": 0.0, "charger": n == 6, "note": ""}
    for n in range(7)
]

_MISSED = """
(selectors) => selectors.filter((selector) => {
  const one = document.querySelector(selector);
  if (one === null) return true;
  const { left, top, width, height } = one.getBoundingClientRect();
  return !one.contains(document.elementFromPoint(left + width / 2, top + height / 2));
})
"""
_HIT_OF = """
(selector) => [...document.querySelectorAll(selector)].filter((one) => {
  const { left, top, width, height } = one.getBoundingClientRect();
  return one.contains(document.elementFromPoint(left + width / 2, top + height / 2));
}).length
"""
_WHOLE = """
(selector) => [...document.querySelectorAll(selector)].filter((one) => {
  const { left, top, width, bottom } = one.getBoundingClientRect();
  return [top + 3, bottom - 3].every((y) => one.contains(document.elementFromPoint(left + width / 2, y)));
}).length
"""
_HIDDEN_LINES = """
(selector) => {
  const one = document.querySelector(selector), range = document.createRange();
  range.selectNodeContents(one);
  return [...range.getClientRects()].filter(({ left, top, width, bottom }) => [top + 2, bottom - 2].some(
    (y) => !one.contains(document.elementFromPoint(left + width / 2, y)))).length;
}
"""
"""The number of its lines that something else covers, or that are out of view."""
_SMALL = """
() => [...document.querySelectorAll("body *")].filter((one) => one.checkVisibility()
  && [...one.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim())
  && parseFloat(getComputedStyle(one).fontSize) < 13).map((one) => one.outerHTML.slice(0, 80))
"""
_SHARE = """
([selector, own]) => {
  const { left, top, width, height } = document.querySelector(selector).getBoundingClientRect();
  let count = 0;
  for (let i = 1; i < 20; i += 1) for (let j = 1; j < 20; j += 1) {
    const found = document.elementFromPoint(left + (width * i) / 20, top + (height * j) / 20);
    count += Boolean(found?.closest(own));
  }
  return count / 361;
}
"""
"""The part of an element whose topmost element is `own`."""


@pytest.fixture
def served(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Fake, str]]:
    """A robot with the seven marks of a hall."""
    for module in ("fastapi", "uvicorn", "websockets", "PIL"):
        pytest.importorskip(module, reason=f'{module} is not installed: pip install ".[web]"')
    from tests.web import fake_server

    monkeypatch.setattr(fake_server, "MARKS", MARKS)
    fake = fake_server.Fake()
    with fake_server.Served(fake) as server:
        yield fake, server.url


def needed(*more: str) -> list[str]:
    """What is in reach at all times, and some more."""
    return ["#stop", "#language", *(f"#tabbutton-{tab}" for tab in TABS), *more]


def missed(page: Page, *more: str) -> Any:
    """Those that a finger on their middle would not hit."""
    return page.evaluate(_MISSED, needed(*more))


def share(page: Page, selector: str, own: str) -> float:
    return float(page.evaluate(_SHARE, [selector, own]))


def switch_on(page: Page) -> None:
    page.click("#tabbutton-drive")
    page.click("#drive-on")
    page.check("#warning-check")
    page.click("#warning-yes")
    page.wait_for_selector(".pad")


@each_phone
def test_each_tab_uses_the_whole_screen(
    browser: Browser, served: tuple[Fake, str], size: tuple[int, int]
) -> None:
    """STOP and the tabs are in reach, the map is a map, and the panel ends at STOP or at the edge of the screen."""
    with person(browser, served[1], size) as page:
        for tab in TABS:
            page.click(f"#tabbutton-{tab}")
            assert missed(page) == [], tab
            panel, chart, stop = (
                page.locator(one).bounding_box() or {} for one in ("#panel", "#map", "#stop-row")
            )
            assert panel["y"] + panel["height"] in (size[1], stop["y"]), tab
            assert panel["height"] >= 190, tab
            assert chart["width"] >= 240, tab
            assert chart["height"] >= 150, tab


@each_phone
def test_the_marks_are_seen(browser: Browser, served: tuple[Fake, str], size: tuple[int, int]) -> None:
    """All seven of a hall, without scrolling; six on the smallest phone."""
    with person(browser, served[1], size) as page:
        assert page.evaluate(_HIT_OF, ".markrow") >= (6 if 320 in size else 7)
        assert missed(page, "#mark-search") == []


@each_phone
def test_the_pad_is_whole(browser: Browser, served: tuple[Fake, str], size: tuple[int, int]) -> None:
    """Driving is switched on without scrolling to the switch; the pad is large enough for a thumb, and all of it is there."""
    with person(browser, served[1], size) as page:
        page.click("#tabbutton-drive")
        assert missed(page, "#drive-on") == []
        switch_on(page)
        pad = page.locator(".pad").bounding_box() or {}
        assert pad["width"] >= 160
        assert pad["width"] == pad["height"]
        assert share(page, ".pad", ".pad") > 0.78, "a circle: pi / 4"
        assert missed(page, ".knob", ".drivestate") == []
        assert (page.locator(".drivestate").bounding_box() or {})["width"] >= 110, "no column of single words"


@each_phone
def test_the_answer_of_stop_lies_over_no_control(
    browser: Browser, served: tuple[Fake, str], size: tuple[int, int]
) -> None:
    """Neither over the switch, the pad, the marks, nor over a question; and it can be closed."""
    fake, url = served
    with person(browser, url, size) as page:
        page.click("#tabbutton-drive")
        page.click("#stop")
        page.wait_for_selector("#stop-answer.ok")
        assert missed(page, "#drive-on", "#stop-answer .close") == []
        assert share(page, "#map", "#stop-answer") == 0.0, "nor over the robot"
        page.click("#tabbutton-go")
        assert page.evaluate(_HIT_OF, ".markrow") >= (6 if 320 in size else 7)
        page.click(".markrow")
        assert page.evaluate(_MISSED, ["#stop", "#confirm [type=submit]", "#confirm .plain"]) == []
        page.click("#confirm .plain")
        page.click("#stop-answer .close")
        switch_on(page)
        fake.stands = False
        page.click("#stop")
        page.wait_for_selector("#stop-answer.bad")
        assert missed(page, ".knob", "#stop-answer .close") == []


@each_phone
def test_while_the_server_is_gone_that_is_what_is_read(
    browser: Browser, served: tuple[Fake, str], size: tuple[int, int]
) -> None:
    """No message lies over the banner, and an open question offers no start."""
    fake, url = served
    with person(browser, url, size) as page:
        page.click(".markrow")
        page.click("#confirm [type=submit]")
        page.wait_for_selector("#task progress")
        page.fill("#mark-search", "D9")
        page.click("#mark-other")
        page.click("#confirm [type=submit] >> text=Start this instead")
        page.wait_for_selector(".toast.bad")
        page.fill("#mark-search", "")
        page.click(".markrow")
        fake.silent = True
        page.wait_for_selector("#lost:not(.hidden)")
        assert page.locator(".toast.bad").count() == 1, "it is still there"
        assert share(page, "#lost", "#lost") > 0.97, "the corners are round"
        page.wait_for_selector("#confirm [type=submit]:disabled")
        assert page.inner_text("#confirm .why") == "Not connected: it would not reach the robot."
        fake.silent = False
        page.wait_for_selector("#confirm [type=submit]:enabled")


@each_phone
def test_a_goal_under_way_leaves_a_mark_in_reach(
    browser: Browser, served: tuple[Fake, str], size: tuple[int, int]
) -> None:
    """One whole mark at least, beside what pauses and cancels the goal."""
    with person(browser, served[1], size) as page:
        page.click(".markrow")
        page.click("#confirm [type=submit]")
        page.wait_for_selector("#task progress")
        assert missed(page, "#pause", "#cancel") == []
        assert page.evaluate(_WHOLE, ".markrow") >= 1


@each_phone
def test_the_warning_is_read_before_it_is_confirmed(
    browser: Browser, served: tuple[Fake, str], size: tuple[int, int]
) -> None:
    """Its title, its first sentence in both languages, and what confirms it are in view at once; the rest scrolls."""
    for language in ("en-US", "zh-CN"):
        with person(browser, served[1], size, language=language) as page:
            page.click("#tabbutton-drive")
            page.click("#drive-on")
            assert missed(page, "#warning-title", "#warning-check", "#warning-yes", "#warning .plain") == []
            assert page.evaluate(_HIDDEN_LINES, "#warning .strong") == 0
            page.locator("#warning p").last.evaluate("(one) => one.scrollIntoView()")
            assert page.evaluate(_HIDDEN_LINES, "#warning p:last-of-type") == 0


def test_a_phone_at_200_percent(browser: Browser, served: tuple[Fake, str]) -> None:
    """Half as many pixels: STOP, the tabs and what ends a goal are in reach, and nothing runs out of the screen."""
    with person(browser, served[1], (195, 422)) as page:
        page.click(".markrow")
        page.click("#confirm [type=submit]")
        page.wait_for_selector("#task progress")
        page.locator("#cancel").scroll_into_view_if_needed()
        assert missed(page, "#pause", "#cancel") == []
        switch_on(page)
        assert missed(page, ".knob") == []
        assert page.evaluate("document.documentElement.scrollWidth") == 195


@each_phone
def test_no_text_is_small(browser: Browser, served: tuple[Fake, str], size: tuple[int, int]) -> None:
    with person(browser, served[1], size) as page:
        for tab in TABS:
            page.click(f"#tabbutton-{tab}")
            assert page.evaluate(_SMALL) == [], tab


@each_phone
def test_a_place_is_chosen_on_a_free_map(
    browser: Browser, served: tuple[Fake, str], size: tuple[int, int]
) -> None:
    """What is to be done stands in the question; the map is free for the finger, and the answers are in reach."""
    with person(browser, served[1], size) as page:
        for choice, words in (("#choose-place", "Press"), ("#choose-pose", "Press")):
            page.click(choice)
            page.wait_for_selector("#confirm #place-x")
            assert share(page, "#map", "#canvas") > 0.9
            assert words in page.inner_text("#confirm")
            numbers = ("#place-x", "#place-y", "#place-heading")
            assert missed(page, "#confirm [type=submit]", "#confirm .plain", *numbers) == []
            page.click("#confirm .plain")
