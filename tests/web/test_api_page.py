"""The page of the API: openapi.json written out, without a word from any other server."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.web.conftest import Robot

if TYPE_CHECKING:
    from playwright.sync_api import Browser


@pytest.mark.slow
@pytest.mark.parametrize("language", ["en", "zh-CN"])
def test_every_operation_is_shown_and_nothing_is_fetched_from_elsewhere(
    hall: Robot, browser: Browser, language: str
) -> None:
    page = browser.new_page(locale=language, viewport={"width": 320, "height": 640})
    asked: list[str] = []
    errors: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.on("console", lambda said: errors.append(said.text) if said.type == "error" else None)
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(f"{hall.url}docs")
    page.wait_for_selector("details")
    paths = page.evaluate("fetch('../openapi.json').then((answer) => answer.json())")["paths"]
    wanted = {
        operation["operationId"]
        for path, item in paths.items()
        for operation in item.values()
        if "/robots/{robot}/" not in path
    }
    assert set(page.eval_on_selector_all("details", "all => all.map((one) => one.id)")) == wanted
    page.click("#create_goal summary")
    shown = page.inner_text("#create_goal")
    old = "旧名称" if language == "zh-CN" else "old name"
    for text in ("""-d '{"kind":"mark","mark":"A1"}'""", "number, -10 ... 10", "Idempotency-Key", old):
        assert text in shown
    assert page.evaluate("document.documentElement.scrollWidth") <= 320, "it scrolls sideways"
    assert [url for url in asked if not url.startswith(hall.url)] == []
    assert errors == []
    page.close()
