"""examples/web, a page in plain JavaScript from another origin: it shows the robot, sends it to a mark, and stops it."""

from __future__ import annotations

import http.server
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from tests.web.conftest import Robot, marks

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from woosh_pure.web.server import WebServer

pytestmark = pytest.mark.slow
PAGE = Path(__file__).resolve().parents[2] / "examples" / "web"


class _Files(http.server.SimpleHTTPRequestHandler):
    """As `python -m http.server --directory examples/web`, without its log."""

    def log_message(self, format: str, *_: Any) -> None:
        pass


@pytest.fixture(scope="module")
def origin() -> Iterator[str]:
    """The page's own server."""
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), partial(_Files, directory=str(PAGE))) as files:
        thread = threading.Thread(target=files.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True)
        thread.start()
        yield f"http://127.0.0.1:{files.server_port}"
        files.shutdown()
        thread.join(10)


@contextmanager
def served(robot: Robot, **options: Any) -> Iterator[WebServer]:
    """A server of this robot."""
    from woosh_pure import web
    from woosh_pure.web.server import WebServer

    app = web.app({"sim": robot.chassis}, marks=marks(), **options)
    with WebServer(app, port=0) as server:
        yield server
    web.close(app)


@contextmanager
def opened(browser: Browser, origin: str, server: WebServer, hash: str = "") -> Iterator[Page]:
    """The page; no script of it fails."""
    page, errors = browser.new_page(locale="en-US"), []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(f"{origin}/?server={server.url.rstrip('/')}{hash}")
    yield page
    page.close()
    assert errors == []


def says(page: Page, selector: str, text: str) -> None:
    """Wait until the element has the text."""
    page.wait_for_function(
        "([selector, text]) => document.querySelector(selector).textContent.includes(text)",
        arg=[selector, text],
        timeout=20_000,
    )


def test_it_shows_the_robot_sends_it_to_a_mark_and_stops_it(
    robot: Robot, browser: Browser, origin: str
) -> None:
    """With a token, too: the event stream is read by fetch, which can send it."""
    with (
        served(robot, origins=[origin], token="a-long-token") as server,
        opened(browser, origin, server, "#token=a-long-token") as page,
    ):
        says(page, "#state", "87 % charged.")
        page.click("#marks button:text-is('P1')")
        says(page, "#goal", "arrived")
        assert robot.away(-0.5, 2.5) < 0.3
        page.click("#marks button:text-is('B1')")
        robot.chassis.measured_velocity.wait_for(lambda velocity: velocity.vx > 0.1, timeout=20)
        page.click("#stop")
        says(page, "#stopped", "stopped: ")
        assert robot.speed < 0.01
        says(page, "#goal", "cancelled")


def test_a_lost_connection_is_shown_and_stop_says_that_it_is_not_confirmed(
    robot: Robot, browser: Browser, origin: str
) -> None:
    with served(robot, origins=[origin]) as server, opened(browser, origin, server) as page:
        says(page, "#state", "87 % charged.")
        page.wait_for_selector("#lost", state="hidden")
        server.__exit__(None, None, None)
        says(page, "#lost", "No connection to the robot")
        page.wait_for_selector("#marks button:disabled")
        assert page.is_enabled("#stop")
        page.click("#stop")
        says(page, "#stopped", "NOT confirmed")


def test_a_robot_that_falls_silent_is_shown_although_the_server_answers(
    robot: Robot, browser: Browser, origin: str
) -> None:
    with served(robot, origins=[origin]) as server, opened(browser, origin, server) as page:
        page.wait_for_selector("#marks button:enabled")
        page.wait_for_selector("#lost", state="hidden")
        robot.sim.fall_silent(8.0)
        says(page, "#lost", "it has sent nothing for two seconds")
        page.wait_for_selector("#lost", state="hidden", timeout=30_000)  # it is heard again


def test_without_origin_the_page_is_not_let_in(robot: Robot, browser: Browser, origin: str) -> None:
    with served(robot) as server, opened(browser, origin, server) as page:
        says(page, "#lost", "No connection to the robot")
        page.click("#stop")
        says(page, "#stopped", "NOT confirmed")


_PICTURE = """
(address) => new Promise((done) => {
  const image = new Image();
  image.onload = () => done(image.naturalWidth);
  image.onerror = () => done(0);
  image.src = address;
})
"""
_FRAME = """
(address) => {
  const frame = document.createElement("iframe");
  Object.assign(frame, { src: address, width: 700, height: 600, id: "robot" });
  document.body.append(frame);
}
"""


def test_a_page_of_origin_frames_the_page_and_shows_pictures(
    robot: Robot, browser: Browser, origin: str
) -> None:
    """The page in the frame is a whole one: it is connected, and its STOP is answered."""
    with served(robot, origins=[origin]) as server, opened(browser, origin, server) as page:
        for picture in ("map.png", "camera/color.jpg"):
            assert page.evaluate(_PICTURE, f"{server.url}api/v1/{picture}") > 50
        page.evaluate(_FRAME, server.url)
        frame = page.frame_locator("#robot")
        frame.locator(".markrow").first.wait_for()
        frame.locator("#stop").click()
        frame.locator("#stop-answer.ok").wait_for(timeout=20_000)


@pytest.mark.parametrize("others", [(), ("https://elsewhere.example",)], ids=["none", "another"])
def test_a_page_of_another_origin_frames_nothing_and_sees_no_picture(
    robot: Robot, browser: Browser, origin: str, others: tuple[str, ...]
) -> None:
    with served(robot, origins=others) as server, opened(browser, origin, server) as page:
        assert page.evaluate(_PICTURE, f"{server.url}api/v1/map.png") == 0
        page.evaluate(_FRAME, server.url)
        page.wait_for_timeout(1500)
        assert page.frame_locator("#robot").locator("#stop").count() == 0


def test_a_referer_that_only_looks_like_an_origin_is_not_one(robot: Robot) -> None:
    """A longer name, another port, or what is no address."""
    from tests.support.web import Served

    with served(robot, origins=["http://robot.example"]) as server:
        for referer, policy in (
            ("http://robot.example/page", "cross-origin"),
            ("http://robot.example.evil.example/", "same-origin"),
            ("http://robot.example:81/", "same-origin"),
            ("http://user@robot.example/", "same-origin"),
            ("http://[", "same-origin"),
            ("", "same-origin"),
        ):
            answer = Served(server.port).get("map.png", headers={"referer": referer})
            assert answer.headers["cross-origin-resource-policy"] == policy, referer
