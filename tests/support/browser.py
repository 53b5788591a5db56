"""Headless Chromium for tests of the page: Debian's `chromium`, driven by Playwright's Python package.

The program is that of $WOOSH_CHROMIUM, else `chromium`, `chromium-browser` or `google-chrome` in PATH (Debian:
`apt-get install chromium`); `pip install playwright` for the driver. Playwright's own browsers are not needed.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import pytest

from tests.support.ros_process import require

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

__all__ = ["DESKTOP", "PHONE", "chromium", "chromium_program", "each_appearance", "opened", "person"]

PHONE, DESKTOP = (390, 844), (1280, 800)

each_appearance = pytest.mark.parametrize(
    ("size", "language", "scheme"),
    [
        pytest.param(PHONE, "en-US", "dark", id="phone-en-dark"),
        pytest.param(PHONE, "zh-CN", "light", id="phone-zh-light"),
        pytest.param(DESKTOP, "en-US", "light", id="desktop-en-light"),
        pytest.param(DESKTOP, "zh-CN", "dark", id="desktop-zh-dark"),
    ],
)
"""Both sizes, languages and colour schemes, each at least twice."""


def chromium() -> str:
    """Return the program; skip the running test if it, or its driver, is not installed."""
    require(find_spec("playwright") is not None, "playwright is not installed (pip install playwright)")
    return chromium_program()


def chromium_program() -> str:
    """Return the program; skip the running test if it is not installed."""
    names = ("chromium", "chromium-browser", "google-chrome")
    found = os.environ.get("WOOSH_CHROMIUM") or next(filter(None, map(shutil.which, names)), None)
    require(found is not None, "no Chromium: neither $WOOSH_CHROMIUM nor chromium in PATH")
    assert found is not None
    return found


@contextmanager
def opened() -> Iterator[Browser]:
    """A browser without a window."""
    program = chromium()
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def person(
    browser: Browser,
    url: str,
    size: tuple[int, int] = DESKTOP,
    *,
    language: str = "en-US",
    scheme: Any = "light",
    path: str = "",
    ready: str = ".markrow",
    context_options: Any = None,
) -> Iterator[Page]:
    """Open the page and wait for its element `ready`. At the end, check that the page reported no error and sent
    no request to other servers.
    """
    problems: list[str] = []
    context = browser.new_context(
        viewport={"width": size[0], "height": size[1]},
        locale=language,
        color_scheme=scheme,
        has_touch=size == PHONE,
        reduced_motion="reduce",
        **(context_options or {}),
    )
    try:
        page = context.new_page()
        page.set_default_timeout(20_000)
        page.on("pageerror", lambda error: problems.append(str(error)))
        page.on("request", lambda request: _own(request.url, url, problems))
        page.on("console", lambda line: _told(line, problems))
        page.goto(url + path)
        page.wait_for_selector(ready)
        yield page
        if not page.is_closed():
            page.close(run_before_unload=True)
    finally:
        context.close()
    assert problems == []


def _own(asked: str, url: str, problems: list[str]) -> None:
    own = asked.replace("ws://", "http://").startswith((url, "blob:"))
    if not own:
        problems.append(f"asked outside: {asked}")


def _told(line: Any, problems: list[str]) -> None:
    # The browser reports refused requests itself; tests check the page's message about them.
    if (
        line.type == "error"
        and "Failed to load resource" not in line.text
        and "WebSocket connection" not in line.text
    ):
        problems.append(line.text)
