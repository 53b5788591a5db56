"""STOP of the page in a real browser: it tries every way to the server, and names the red button when none confirms."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

from tests.support.browser import person
from tests.support.load import crowd
from tests.web.test_page_alone import until
from tests.web.test_page_links import served as another_server
from woosh_pure.outcome import OutcomeKind

if TYPE_CHECKING:
    from playwright.sync_api import Browser

    from tests.web.conftest import Robot
    from tests.web.fake_server import Fake

pytestmark = pytest.mark.slow
RED_BUTTON = "#stop-answer >> text=Use the red button on the robot."
SLACK = 1.0
"""Seconds on top of the one within which it must be said: other tests use the processor."""


@pytest.fixture
def served() -> Iterator[tuple[Fake, str]]:
    for module in ("fastapi", "uvicorn", "websockets", "PIL"):
        pytest.importorskip(module, reason=f'{module} is not installed: pip install ".[web]"')
    from tests.web.fake_server import Fake, Served

    fake = Fake()
    with Served(fake) as server:
        yield fake, server.url


def ways(fake: Fake) -> list[str]:
    return [way for way, path, _ in fake.calls if path == "stop"]


def test_the_open_connection_is_the_first_way_and_enough(browser: Browser, served: tuple[Fake, str]) -> None:
    fake, url = served
    with person(browser, url) as page:
        page.click("#stop")
        page.wait_for_selector("#stop-answer >> text=The robot stands still.")
        assert ways(fake)[0] == "live"


@pytest.mark.promise("STOP in the page")
def test_a_session_that_is_not_known_holds_no_stop_up(browser: Browser, served: tuple[Fake, str]) -> None:
    """Nor does a connection that leads nowhere: what carries no session stops."""
    fake, url = served
    fake.deaf, fake.knows_session = True, False
    with person(browser, url) as page:
        page.click("#stop")
        page.wait_for_selector("#stop-answer >> text=The robot stands still.")
        assert ways(fake)[0] == "refused"
        assert "POST" in ways(fake)
        until(lambda: "beacon" in ways(fake), page)


@pytest.mark.promise("STOP in the page")
def test_the_red_button_is_named_within_a_second(browser: Browser, served: tuple[Fake, str]) -> None:
    """No way confirms: the connection is deaf, and no call is answered. Each of them is tried."""
    fake, url = served
    fake.deaf, fake.stop_delay = True, 4.0
    with person(browser, url) as page:
        began = time.monotonic()
        page.click("#stop")
        page.wait_for_selector(RED_BUTTON)
        assert time.monotonic() - began < 1.0 + SLACK * crowd()
        until(lambda: {"POST", "beacon"} <= set(ways(fake)), page)
        assert ways(fake).count("POST") == 2, "with the session and without"
        page.wait_for_selector("#stop-answer >> text=The robot stands still.", timeout=20_000)


def test_without_a_server_the_red_button_is_named_at_once(browser: Browser, served: tuple[Fake, str]) -> None:
    with person(browser, served[1]) as page:
        page.context.set_offline(True)
        page.click("#stop")
        page.wait_for_selector(RED_BUTTON, timeout=2000)
        page.wait_for_selector("#stop-answer >> text=The stop did not reach the robot.")
        page.wait_for_timeout(2500)  # what is known is not taken back by what is not
        assert "The stop did not reach the robot." in page.inner_text("#stop-answer")


def test_a_stop_that_was_not_confirmed_is_carried_out_when_the_server_is_back(
    browser: Browser, robot: Robot
) -> None:
    """The red answer ends with what is known then; an answer that was closed is not asked for again."""
    with another_server({"sim": robot.chassis}) as first, person(browser, first.url) as page:
        port = first.port
        first.close()
        page.click("#stop")
        page.wait_for_selector(f"{RED_BUTTON} >> nth=0")
        goal = robot.chassis.go_to_mark("B1")
        with another_server({"sim": robot.chassis}, port=port) as second:
            page.wait_for_selector("#stop-answer.ok >> text=The robot stands still.")
            assert goal.done
            page.click("#stop-answer .close")
            second.close()
            page.wait_for_selector("#lost:not(.hidden)")
            page.click("#stop")
            page.wait_for_selector(RED_BUTTON)
            page.wait_for_timeout(
                4000
            )  # until all ways have failed: one of them may still reach the next server
            page.click("#stop-answer .close")
        goal = robot.chassis.go_to_mark("B1")
        with another_server({"sim": robot.chassis}, port=port):
            page.wait_for_selector("#lost", state="hidden")
            page.wait_for_timeout(1500)
            outcome = goal.outcome  # on a busy computer it may have arrived
            assert outcome is None or outcome.kind is OutcomeKind.ARRIVED
            goal.cancel()


def test_a_page_of_a_server_that_was_started_again_stops_at_once(browser: Browser, robot: Robot) -> None:
    """It has the session of before, and has not connected again yet."""
    with another_server({"sim": robot.chassis}) as first, person(browser, first.url) as page:
        port = first.port
        page.evaluate(  # it never connects again
            "() => { window.WebSocket = class { static OPEN = 1; readyState = 0; close() {} }; }"
        )
        first.close()
        goal = robot.chassis.go_to_mark("B1")
        with another_server({"sim": robot.chassis}, port=port):
            page.click("#stop")
            page.wait_for_selector("#stop-answer >> text=The robot stands still.")
            assert goal.done
