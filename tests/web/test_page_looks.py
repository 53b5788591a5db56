"""How the page looks: contrast by the numbers of WCAG AA, the order of the keyboard, nothing that jumps or is cut."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import pytest

from tests.support.browser import PHONE, each_appearance, person
from tests.web.test_page_fits import TABS, start

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web.fake_server import Fake

pytestmark = pytest.mark.slow
_SEVERE = {"code": 100200300402, "level": "SEVERE", "text": "motor overheated", "text_zh": "电机过热"}
_WARNING = {"code": 100200300403, "level": "WARNING", "text": "fan slow", "text_zh": "风扇变慢"}
_REASON = {"key": "emergency_stop", "text": "the emergency stop is pressed", "blocking": True, "doubt": False}

_CONTRASTS = """
() => {
  const read = (text) => {
    const found = text.match(/[\\d.]+%?/g).map((one) => (one.endsWith("%") ? 2.55 * parseFloat(one) : Number(one)));
    return {r: found[0], g: found[1], b: found[2], a: found.length > 3 ? found[3] : 1};
  };
  const over = (top, below) => ({
    r: top.r * top.a + below.r * (1 - top.a), g: top.g * top.a + below.g * (1 - top.a),
    b: top.b * top.a + below.b * (1 - top.a), a: 1,
  });
  const ground = (element) => {
    const layers = [];
    for (let one = element; one; one = one.parentElement) {
      const colour = read(getComputedStyle(one).backgroundColor);
      if (colour.a > 0) layers.push(colour);
      if (colour.a === 1) break;
    }
    return layers.reverse().reduce((below, top) => over(top, below), {r: 255, g: 255, b: 255, a: 1});
  };
  const part = (value) => (value <= 10.31 ? value / 255 / 12.92 : ((value / 255 + 0.055) / 1.055) ** 2.4);
  const light = ({r, g, b}) => 0.2126 * part(r) + 0.7152 * part(g) + 0.0722 * part(b);
  const ratio = (one, other) => {
    const [high, low] = [light(one), light(other)].sort((x, y) => y - x);
    return (high + 0.05) / (low + 0.05);
  };
  const poor = [];
  let count = 0;
  for (const element of document.querySelectorAll("body *")) {
    const own = [...element.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim());
    const seen = element.checkVisibility({opacityProperty: true, visibilityProperty: true});
    const icon = element.tagName === "svg";
    if (!(own || icon) || !seen || element.closest(":disabled") || element.closest(".unseen, noscript")) continue;
    const style = getComputedStyle(element);
    let opacity = 1;
    for (let one = element; one; one = one.parentElement) opacity *= Number(getComputedStyle(one).opacity);
    const below = ground(element);
    const found = ratio(over({...read(style.color), a: opacity}, below), below);
    const large = parseFloat(style.fontSize) >= 24 || (parseFloat(style.fontSize) >= 18.66 && Number(style.fontWeight) >= 700);
    count += 1;
    if (found < (icon || large ? 3 : 4.5)) {
      poor.push(`${element.tagName} .${element.getAttribute("class")} "${element.textContent.trim().slice(0, 30)}" ${found.toFixed(2)}`);
    }
  }
  return [count, poor];
}
"""

_CUT = """
() => [...document.querySelectorAll("button, a.button, h2, strong, .fact, .badge, p, th, td, label > span")].filter((one) => {
  if (!one.checkVisibility() || one.closest(".unseen") || one.id === "robot-name") return false;
  return one.scrollWidth > one.clientWidth + 1 && getComputedStyle(one).display !== "inline";
}).map((one) => one.outerHTML.slice(0, 100))
"""


@pytest.fixture(scope="module")
def served() -> Iterator[tuple[Fake, str]]:
    for module in ("fastapi", "uvicorn", "websockets", "PIL"):
        pytest.importorskip(module, reason=f'{module} is not installed: pip install ".[web]"')
    from tests.web.fake_server import Fake, Served

    fake = Fake()
    fake.ready = {"answer": "no", "text": _REASON["text"], "reasons": [_REASON]}
    fake.faults = {"known": True, "present": True, "text": "", "active": [_SEVERE, _WARNING]}
    with Served(fake) as server:
        yield fake, server.url


def good(page: Page, where: str) -> None:
    """Everything that is written can be read."""
    count, poor = page.evaluate(_CONTRASTS)
    assert count > 15, where
    assert poor == [], where
    assert page.evaluate(_CUT) == [], where


@each_appearance
def test_what_is_written_can_be_read(
    browser: Browser, served: tuple[Fake, str], size: Any, language: str, scheme: str
) -> None:
    """WCAG AA: 4.5 to 1 for text, 3 to 1 for large text and icons; nothing is cut; also when it is old."""
    fake, url = served
    fake.goals, fake.lost, fake.stands = [], None, False
    with person(browser, url, size, language=language, scheme=scheme) as page:
        page.wait_for_selector("#notices .notice")
        for tab in TABS:
            page.click(f"#tabbutton-{tab}")
            good(page, tab)
        page.click("#tabbutton-drive")
        page.click("#drive-on")
        page.check("#warning-check")
        good(page, "the warning")
        page.click("#warning-yes")
        page.wait_for_selector(".pad")
        good(page, "the pad")
        page.click("#tabbutton-go")
        page.click(".markrow >> text=A1")
        good(page, "a question that offers no Start")
        start(page, fake)
        page.wait_for_selector("#task progress")
        page.click("#stop")
        page.wait_for_selector("#stop-answer.bad")
        good(page, "a task, and a stop that did not stop")
        fake.lost = 0.0
        page.wait_for_selector("#lost:not(.hidden)")
        for tab in ("go", "health"):
            page.click(f"#tabbutton-{tab}")
            good(page, f"{tab}, lost")
    fake.lost = None


def test_the_keyboard_goes_from_top_to_bottom(browser: Browser, served: tuple[Fake, str]) -> None:
    """Skip to STOP, the head, the map and its tools, STOP, the tabs, then the panel; and each step can be seen."""
    fake, url = served
    fake.goals, fake.lost = [], None
    with person(browser, url) as page:
        page.wait_for_selector("#fault-chip:not(.hidden)")
        order: list[str] = []
        for _ in range(27):
            page.keyboard.press("Tab")
            one = page.evaluate(
                """(() => { const one = document.activeElement; const style = getComputedStyle(one);
                return [one.id || one.className, style.outlineStyle, parseFloat(style.outlineWidth)]; })()"""
            )
            assert one[1] != "none", one
            assert one[2] >= 2, one
            order.append(one[0])
        head = [
            "skip",
            "fault-chip",
            "language",
            "canvas",
            "zoom-in",
            "zoom-out",
            "follow",
            "fit",
            "costmap",
            "stop",
        ]
        assert order[:10] == head
        assert order[10] == "tabbutton-go", "one stop for all tabs: arrow keys go between them"
        assert order[11:20] == ["mark-search", *["markrow", "plain"] * 4], "each mark, and what changes it"
        ways = ["mark-here", "mark-place", "choose-place", "charge", "choose-pose", "amount-move", ""]
        assert order[20:] == ways


def test_nothing_moves_by_itself_where_that_is_not_wanted(browser: Browser, served: tuple[Fake, str]) -> None:
    """With "reduce motion" no animation runs; and while values come nothing of the panel changes its place."""
    fake, url = served
    fake.goals, fake.lost = [], None
    with person(browser, url, PHONE) as page:
        page.wait_for_selector("#notices .notice")
        page.wait_for_timeout(300)
        places = (
            "[...document.querySelectorAll('#top > *, #tabs button, .markrow, #stop, .notice')].map((one) => "
            "JSON.stringify(one.getBoundingClientRect()))"
        )
        before = page.evaluate(places)
        page.wait_for_timeout(1500)
        assert page.evaluate(places) == before
        assert page.evaluate("document.getAnimations().length") == 0
