"""The pad in a real browser: a finger that rests on it commands one velocity, whatever the page does meanwhile."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import pytest

from tests.support.browser import DESKTOP, PHONE, person
from tests.support.load import crowd
from tests.web.test_page_alone import allow, kinds, until

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web.fake_server import Fake

pytestmark = pytest.mark.slow
SIZES = [pytest.param(PHONE, id="phone"), pytest.param(DESKTOP, id="desktop")]
UP = 24
"""Pixels above the middle of the pad: slowly ahead. Each thing below moves more than that."""
BUSY = "this page did not run for a moment"
"""Why a drive may end by itself on a computer that others use, too."""


@pytest.fixture
def served() -> Iterator[tuple[Fake, str]]:
    for module in ("fastapi", "uvicorn", "websockets", "PIL"):
        pytest.importorskip(module, reason=f'{module} is not installed: pip install ".[web]"')
    from tests.web.fake_server import Fake, Served

    fake = Fake()
    with Served(fake) as server:
        yield fake, server.url


class Finger:
    """A finger that rests on the pad; what it commands, as the server hears it."""

    def __init__(self, page: Page, fake: Fake) -> None:
        self.page, self.fake = page, fake

    def down(self) -> None:
        """Hold until two beats have come."""
        for _ in range(10):
            self.box = self.page.locator(".pad").bounding_box()
            assert self.box is not None
            self.x, self.y = self.box["x"] + 110, self.box["y"] + 110 - UP
            self.fake.heard.clear()
            self.page.mouse.move(self.x, self.y)
            self.page.mouse.down()
            until(lambda: len(kinds(self.fake, "beat")) > 1 or kinds(self.fake, "release"), self.page, 10.0)
            if not kinds(self.fake, "release"):
                return
            self.page.mouse.up()
        pytest.fail("this computer is too busy to hold anything")

    def tremble(self, seconds: float = 0.5) -> None:
        """One pixel to and fro, as no finger is still."""
        until_ = time.monotonic() + seconds
        while time.monotonic() < until_:
            for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1), (0, 0)):
                self.page.mouse.move(self.x + x, self.y + y)
            self.page.wait_for_timeout(50)

    @property
    def ended(self) -> bool:
        return bool(kinds(self.fake, "release"))

    def is_steady(self) -> None:
        """Each velocity that was commanded has the sign and the size of the first one, up to the trembling."""
        said = kinds(self.fake, "press", "beat")
        first = said[0]["vx"]
        assert first > 0.01
        for one in said:
            assert abs(one["vx"] - first) < 0.004, [each["vx"] for each in said]
            assert abs(one["wz"]) < 0.03, [each["wz"] for each in said]


def reason(key: str) -> dict[str, Any]:
    return {"key": key, "text": "a sentence " * 20, "blocking": True, "doubt": False}


def ask(fake: Fake) -> None:
    fake.asking = ["page 77 at 192.168.1.20"]


def refuse(fake: Fake) -> None:
    fake.ready = {"answer": "no", "text": "", "reasons": [reason("fault"), reason("bumper"), reason("x")]}


def fail(fake: Fake) -> None:
    fault = {"code": 100200300402, "level": "SEVERE", "text": "motor overheated " * 10, "text_zh": "电机过热"}
    fake.faults = {"known": True, "present": True, "text": "", "active": [fault] * 5}


def begin(fake: Fake) -> None:
    goal = {"id": "9", "kind": "mark", "who": "page 1", "description": "go to mark A1", "state": "running",
            "done": False, "percent": 4.0, "progress": "1.9 m left", "text": "", "can_pause": True}  # fmt: skip
    fake.goals = [goal]


SHOWN: dict[str, tuple[Callable[[Fake], None], str]] = {
    "a request for control": (ask, "#notices >> text=asks for control."),
    "reasons not to move": (refuse, "#notices .notice.bad"),
    "faults": (fail, "#fault-chip:not(.hidden)"),
    "a task": (begin, "#task progress"),
}


@pytest.mark.promise("driving by hand from the page")
@pytest.mark.parametrize("size", SIZES)
def test_what_is_shown_during_a_drive_moves_no_pad(
    browser: Browser, served: tuple[Fake, str], size: Any
) -> None:
    """Notices, faults and tasks come and go: the drive goes on with the velocity that the finger means."""
    fake, url = served
    with person(browser, url, size) as page:
        allow(page)
        for name, (show, selector) in SHOWN.items():
            finger = Finger(page, fake)
            finger.down()
            show(fake)
            page.wait_for_selector(selector)
            finger.tremble()
            finger.is_steady()
            assert page.locator(".pad").bounding_box() == finger.box, name
            if finger.ended:
                assert BUSY in page.inner_text(".drivestate"), name
            page.mouse.up()
        finger.down()
        fake.asking, fake.goals, fake.faults["active"] = [], [], []
        fake.ready = {"answer": "yes", "text": "", "reasons": []}
        page.wait_for_selector("#notices .notice", state="detached")
        finger.tremble()
        finger.is_steady()
        assert page.locator(".pad").bounding_box() == finger.box


def style(page: Page, text: str) -> None:
    page.evaluate(
        "(text) => { const sheet = new CSSStyleSheet(); sheet.replaceSync(text);"
        "document.adoptedStyleSheets = [...document.adoptedStyleSheets, sheet]; }",
        text,
    )


def zoom(page: Page) -> None:
    page.context.new_cdp_session(page).send("Emulation.setPageScaleFactor", {"pageScaleFactor": 1.5})


MOVES: dict[str, Callable[[Page], Any]] = {
    "something is inserted above it": lambda page: page.evaluate(
        "document.querySelector('#panel').prepend('a line', document.createElement('hr'), 'another line')"
    ),
    "the head of the page grows": lambda page: style(page, "#top { height: 120px !important; }"),
    "the pad grows": lambda page: style(page, ".pad { width: 300px !important; height: 300px !important; }"),
    "the pad shrinks": lambda page: style(
        page, ".pad { width: 100px !important; height: 100px !important; }"
    ),
    "the pad is shifted": lambda page: style(page, ".pad { transform: translate(0, -90px); }"),
    "the panel is scrolled": lambda page: page.evaluate(
        "document.querySelector('#panel').append(document.createElement('section'));"
        "document.querySelector('#panel').lastChild.style.height = '3000px';"
        "document.querySelector('#panel').scrollTop = 90"
    ),
    "the window is resized": lambda page: page.set_viewport_size({"width": 700, "height": 900}),
    "the screen is turned": lambda page: page.set_viewport_size(
        {"width": page.viewport_size["height"], "height": page.viewport_size["width"]}  # type: ignore[index]
    ),
    "the page is zoomed": zoom,
}


@pytest.mark.promise("driving by hand from the page")
@pytest.mark.parametrize("way", MOVES)
def test_a_pad_that_moves_ends_the_drive(browser: Browser, served: tuple[Fake, str], way: str) -> None:
    """And until then it commands what the finger meant: no sign and no size changes by itself."""
    fake, url = served
    with person(browser, url, PHONE) as page:
        allow(page)
        finger = Finger(page, fake)
        finger.down()
        MOVES[way](page)
        finger.tremble()
        until(lambda: finger.ended, page, 2.0 * crowd())
        finger.is_steady()
        assert page.inner_text(".drivestate").startswith("Ended: ")
        count = len(kinds(fake, "press", "beat"))
        finger.tremble(0.3)
        assert len(kinds(fake, "press", "beat")) == count, "it is held still, and nothing resumes"
        page.mouse.up()
