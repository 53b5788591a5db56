"""The page on narrow screens, with the longest that a robot can say: nothing is wider than the screen, and axe-core
finds nothing in its views. And the robot's symbol, which is found on every ground.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import pytest

from tests.support.browser import each_appearance, person
from tests.support.web_peers import npm_module

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web.fake_server import Fake

pytestmark = pytest.mark.slow
LONG = "warehouse-north-hall-2-transport-robot-number-17"
WORD = "Wareneingangskontrollbereichsleitung4711"
TABS = ("go", "missions", "drive", "camera", "health", "log", "sim")
_REASONS = [
    {"key": key, "text": WORD, "values": {}, "blocking": True, "doubt": False}
    for key in ("emergency_stop", "manual_mode", "a key that nobody knows")
]
_FAULTS = [
    {"code": 100200300402, "level": "SEVERE", "text": f"motor {WORD}", "text_zh": "电机过热" * 8},
    {"code": 100200300403, "level": "WARNING", "text": "fan slow", "text_zh": "风扇变慢"},
]

_WIDER = """
() => {
  const wide = document.documentElement.clientWidth;
  const seen = [...document.querySelectorAll("body *")].filter((one) =>
    one.checkVisibility() && !one.closest(".unseen, .skip, option"));
  const out = seen.filter((one) => {
    const { left, right, width } = one.getBoundingClientRect();
    return width > 0 && (left < -0.5 || right > wide + 0.5);
  });
  const scrolls = seen.filter((one) =>
    ["auto", "scroll"].includes(getComputedStyle(one).overflowX) && one.scrollWidth > one.clientWidth);
  return [document.documentElement.scrollWidth - wide, ...[...out, ...scrolls].map((one) => one.outerHTML.slice(0, 120))];
}
"""


@pytest.fixture
def served(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Fake, str]]:
    """Two robots with long names, marks with long names, faults, and somebody else who has control."""
    for module in ("fastapi", "uvicorn", "websockets", "PIL"):
        pytest.importorskip(module, reason=f'{module} is not installed: pip install ".[web]"')
    from tests.web import fake_server

    marks = [{**mark, "name": f"{mark['name']} {WORD}", "note": WORD} for mark in fake_server.MARKS]
    monkeypatch.setattr(fake_server, "MARKS", marks)
    fake = fake_server.Fake()
    fake.robots = [LONG, f"{LONG}-b"]
    fake.missions = [fake_server.mission_file("round", WORD)]
    fake.robot_state, fake.charging, fake.stands = "UNINITIALISED", True, False
    fake.ready = {"answer": "no", "text": "", "reasons": _REASONS}
    fake.faults = {"known": True, "present": True, "text": "", "active": _FAULTS}
    with fake_server.Served(fake) as server:
        yield fake, server.url


def start(page: Page, fake: Fake) -> None:
    """Start what is asked for, while nothing hinders the robot for a moment."""
    hindrances, fake.ready = fake.ready, {"answer": "yes", "text": "", "reasons": []}
    page.click("#confirm button[type=submit]:enabled")
    fake.ready = hindrances
    page.wait_for_selector("#notices .notice.bad")


def views(page: Page, fake: Fake) -> Iterator[str]:
    """Each view of the page, one after the other."""
    page.wait_for_selector("#fault-chip:not(.hidden)")
    page.wait_for_selector("#notices .notice")
    for tab in TABS:
        page.click(f"#tabbutton-{tab}")
        yield tab
    yield from mission_views(page, fake)
    fake.holder, fake.asking = f"page 7 at {WORD}", []
    page.click("#tabbutton-drive")
    page.wait_for_selector(".lease button.ask")
    yield "somebody else has control"
    fake.holder = None
    page.wait_for_selector(".lease button:not(.ask)")
    page.click("#drive-on")
    page.check("#warning-check")
    yield "the warning"
    page.click("#warning-yes")
    page.wait_for_selector(".pad")
    yield "the pad"
    fake.asking = [f"page 7 at {WORD}"]
    page.wait_for_selector("#notices .row")
    yield "somebody asks for control"
    page.click("#tabbutton-go")
    page.click(".markrow")
    yield "a question that offers no Start"
    start(page, fake)
    page.wait_for_selector("#task progress")
    yield "a task"
    page.click("#choose-place")
    yield "a place is chosen"
    page.click("#confirm .plain")
    page.click("#charge")
    yield "a charger is chosen"
    page.click("#confirm .plain")
    page.click("#stop")
    page.wait_for_selector("#stop-answer.bad")
    yield "a stop that did not stop"
    page.click("#stop-answer .close")
    page.click(".markrow >> text=D9")
    start(page, fake)
    page.wait_for_selector(".toast.bad")
    yield "a refusal"
    fake.goals[-1].update(done=True, state="failed", reasons=_REASONS, stands_still=False)
    page.wait_for_selector("#task.bad")
    yield "a task that failed"
    fake.lost = 0.0
    page.wait_for_selector("#lost:not(.hidden)")
    for tab in ("go", "health"):
        page.click(f"#tabbutton-{tab}")
        yield f"{tab}, lost"


def mission_views(page: Page, fake: Fake) -> Iterator[str]:
    """Those of the tab Missions, and of the card of a run."""
    from tests.web.fake_server import mission_run

    page.click("#tabbutton-missions")
    page.click("#missions .saved .primary")
    yield "the parameters of a mission"
    page.click("#confirm .plain")
    page.click("#missions .saved .plain")
    page.click("#mission-steps li:nth-child(2) summary")
    yield "the editor of a mission"
    page.click("#editor .row .plain")
    fake.runs = [
        mission_run("done", id="5", done=True, steps=[]),
        mission_run("queued", id="8", mission=WORD, steps=[]),
    ]
    page.wait_for_selector("#mission-runs .entry")
    yield "a mission in the queue"
    fake.runs.append(mission_run("asking", mission=WORD))
    fake.runs[-1]["question"].update(text=f"{WORD} {WORD}", answers=[WORD, "a", "b", "c", "d"])
    page.wait_for_selector("#mission .question")
    yield "a mission asks"
    page.click("#tabbutton-log")
    fake.runs[-1] = mission_run("interrupted", mission=WORD)
    page.wait_for_selector("#mission-resume")
    yield "a mission was interrupted"
    fake.runs = []
    page.wait_for_selector("#mission", state="hidden")


@pytest.mark.parametrize("language", ["en-US", "zh-CN"])
@pytest.mark.parametrize(
    "size", [(320, 568), (360, 740), (390, 844), (568, 320), (740, 360), (768, 1024)], ids=str
)
def test_nothing_scrolls_sideways(
    browser: Browser, served: tuple[Fake, str], size: tuple[int, int], language: str
) -> None:
    """Neither the page nor a part of it; and what the head shows is not cut."""
    fake, url = served
    with person(browser, url, size, language=language) as page:
        for view in views(page, fake):
            assert page.evaluate(_WIDER) == [0], view
            cut = """['#state', '#battery', '#fault-chip', '#language'].filter((one) => {
            const found = document.querySelector(one); return found.scrollWidth > found.clientWidth + 1 || found.scrollHeight > found.clientHeight + 1; })"""
            assert page.evaluate(cut) == [], view


@each_appearance
def test_axe_finds_nothing(
    browser: Browser, served: tuple[Fake, str], size: Any, language: str, scheme: str
) -> None:
    """No rule of axe-core is broken in any view, the question for the token among them."""
    axe = npm_module("axe-core/axe.min.js").read_text("utf-8")
    fake, url = served

    def found(page: Page) -> Any:
        return page.evaluate(
            """async () => (await axe.run(document, { resultTypes: ["violations"] })).violations
            .map(({ id, nodes }) => [id, ...nodes.map(({ html }) => html.slice(0, 120))])"""
        )

    with person(browser, url, size, language=language, scheme=scheme) as page:
        page.evaluate(axe)
        for view in views(page, fake):
            assert found(page) == [], view
    fake.needs_token, fake.lost = True, None
    with person(browser, url, size, language=language, scheme=scheme, ready="#token[open]") as page:
        page.evaluate(axe)
        assert found(page) == [], "the token"


_SYMBOL = """
async () => {
  const { drawRobot, paintOf } = await import(new URL("js/map_layers.js", location.href).href);
  const { MapViewport } = await import(new URL("js/map_viewport.js", location.href).href);
  const paint = paintOf(document.body);
  const style = getComputedStyle(document.documentElement);
  const part = (value) => (value <= 10.31 ? value / 255 / 12.92 : ((value / 255 + 0.055) / 1.055) ** 2.4);
  const light = (r, g, b) => 0.2126 * part(r) + 0.7152 * part(g) + 0.0722 * part(b);
  const small = [];
  for (const ground of ["free", "wall", "unknown"]) for (const old of [false, true]) {
    const canvas = document.createElement("canvas");
    canvas.width = canvas.height = 120;
    const context = canvas.getContext("2d");
    context.fillStyle = style.getPropertyValue(`--map-${ground}`).trim();
    context.fillRect(0, 0, 120, 120);
    const [r, g, b] = context.getImageData(0, 0, 1, 1).data;
    const below = light(r, g, b);
    const view = new MapViewport();
    view.resize(120, 120);
    view.scale = 2;
    drawRobot(context, view, paint, { x: 0, y: 0, yaw: 0.4 }, old);
    const { data } = context.getImageData(0, 0, 120, 120);
    const seen = [];
    for (let i = 0; i < data.length; i += 4) {
      const [low, high] = [light(data[i], data[i + 1], data[i + 2]), below].sort((x, y) => x - y);
      if ((high + 0.05) / (low + 0.05) >= 3) seen.push([(i / 4) % 120, Math.floor(i / 480)]);
    }
    const extent = (at) => (seen.length ? Math.max(...seen.map((one) => one[at])) - Math.min(...seen.map((one) => one[at])) + 1 : 0);
    if (Math.min(extent(0), extent(1)) < 20 || seen.length < 100) small.push([ground, old, extent(0), extent(1), seen.length]);
  }
  return small;
}
"""


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_robot_is_found_on_every_ground(browser: Browser, served: tuple[Fake, str], scheme: str) -> None:
    """As small as the map goes, new or old: what stands out from floor, wall and the unknown by 3 to 1 is 20 px wide."""
    with person(browser, served[1], scheme=scheme) as page:
        assert page.evaluate(_SYMBOL) == []
