"""The QR code of the page's address: for a phone, and with the token only where the page was opened with it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from tests.support.browser import person
from tests.support.web import Served, serving

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web.conftest import Robot

pytestmark = pytest.mark.slow
TOKEN = "a-long-token"
HOST = "robot.localhost"
"""A name that browsers take for this computer, and the page for one of the network."""


def code_of(page: Page) -> Any:
    """Show the code; return the text of which it was made."""
    page.click("#tabbutton-log")
    with page.expect_request("**/api/v1/qr") as asked:
        page.click("#show-qr")
    page.wait_for_selector("#qr:not(.hidden)")
    page.evaluate("document.querySelector('#qr').decode()")
    assert page.evaluate("document.querySelector('#qr').naturalWidth") > 100
    box, view = page.locator("#qr").bounding_box() or {}, page.viewport_size or {}
    assert box["y"] >= 0
    assert box["y"] + box["height"] <= view["height"], "it need not be scrolled to"
    assert abs(box["width"] - box["height"]) < 1, "without bars"
    return asked.value.post_data_json


def test_the_code_has_the_token_only_if_the_address_had_it(robot: Robot, browser: Browser) -> None:
    """It is the user's own then. After a reload the page does not know it, nor does one whose user has typed it."""
    with serving({"sim": robot.chassis}, token=TOKEN, hosts=[HOST]) as web:
        url = f"http://{HOST}:{web.port}/"
        with person(browser, url, path=f"#token={TOKEN}", ready="#no-marks:not(.hidden)") as page:
            assert code_of(page) == {"text": f"{url}#token={TOKEN}"}
            assert "It contains the token" in page.inner_text("#phone")
            page.reload()
            page.wait_for_selector("#no-marks:not(.hidden)")
            assert code_of(page) == {"text": url}
        with person(browser, url, ready="#token[open]") as page:
            page.fill("#token-input", TOKEN)
            page.click("#token-use")
            page.wait_for_selector("#no-marks:not(.hidden)")
            assert code_of(page) == {"text": url}
            assert "token" not in page.inner_text("#phone")


def test_an_address_of_this_computer_is_not_offered_to_a_phone(robot: Robot, browser: Browser) -> None:
    with person(browser, robot.url) as page:
        page.click("#tabbutton-log")
        assert "This address works on this computer only" in page.inner_text("#phone")
        assert page.locator("#show-qr").count() == 0


def test_the_server_draws_any_text_for_who_has_the_token(robot: Robot) -> None:
    with serving({"sim": robot.chassis}, token=TOKEN) as web:
        answer = web.post("qr", {"text": "http://192.0.2.7:8080/"})
        assert answer.headers["content-type"] == "image/svg+xml"
        assert answer.body.startswith(b"<?xml")
        assert b"<svg" in answer.body
        assert answer.headers["cache-control"] == "no-store"
        assert web.post("qr", {"text": "x" * 1001}).status == 422
        assert web.post("qr", {"text": ""}).status == 422
        assert Served(web.port).post("qr", {"text": "x"}).status == 401
