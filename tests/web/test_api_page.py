"""The page of the API: openapi.json written out, without a word from any other server."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import pytest

from tests.support.waiting import until
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
    if language == "zh-CN":
        assert "开始一个动作。" in shown
        assert not re.search(r"[a-z]{2,} [a-z]{2,} [a-z]{2,} [a-z]{2,}", page.inner_text("main"))
    assert page.evaluate("document.documentElement.scrollWidth") <= 320, "it scrolls sideways"
    assert [url for url in asked if not url.startswith(hall.url)] == []
    assert errors == []
    page.close()


@pytest.mark.slow
def test_a_request_is_tried_and_motion_asks_first(robot: Robot, browser: Browser) -> None:
    """What was refused moves nothing; what was confirmed does; a picture is shown, and a refusal in its words."""
    page = browser.new_page(locale="en", viewport={"width": 320, "height": 640})
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(f"{robot.url}docs/")

    def tried(operation: str) -> str:
        """Send what is filled in; return what came."""
        with page.expect_response(lambda answer: "/api/v1/" in answer.url):
            page.click(f"#{operation} button")
        page.wait_for_selector(f"#{operation} form pre")
        return page.inner_text(f"#{operation} form pre")

    page.click("#get_status summary")
    assert '"robot":"sim"' in tried("get_status").replace(" ", "")
    page.click("#get_picture summary")
    for name, value in (("source", "color"), ("form", "jpg"), ("width", "64")):
        page.fill(f"#get_picture-{name}", value)
    assert tried("get_picture").startswith("200")
    page.wait_for_selector("#get_picture form img")
    page.click("#get_goal summary")
    page.fill("#get_goal-goal", "no/such goal")
    assert "404" in tried("get_goal")
    questions: list[str] = []
    answers = iter(["dismiss", "accept", "dismiss"])

    def asked(dialog: Any) -> None:
        questions.append(dialog.message)
        getattr(dialog, next(answers))()

    page.on("dialog", asked)
    page.click("#create_goal summary")
    page.fill("#create_goal textarea", '{"kind": "rotate", "angle": 0.5}')
    page.click("#create_goal button")
    page.wait_for_timeout(300)
    assert page.locator("#create_goal form pre").count() == 0, "it was refused"
    assert tried("create_goal").startswith("201 /api/v1/goals/")
    assert questions == ["This moves the robot. Check that the way is clear. Send it?"] * 2
    page.click("#stop summary")
    assert '"stands_still":true' in tried("stop").replace(" ", "")
    page.click("#control_queue summary")
    page.fill("#control_queue-verb", "stop")
    tried("control_queue")
    assert len(questions) == 2, "a stop asks nothing"
    page.fill("#control_queue-verb", "resume")
    page.click("#control_queue button")
    until(lambda: page.wait_for_timeout(20) or len(questions) == 3)
    assert page.evaluate("document.documentElement.scrollWidth") <= 320, "it scrolls sideways"
    assert errors == []
    page.close()
