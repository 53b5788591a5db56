"""Each task of the lesson is one printed page: A4, in a size that can be read at arm's length."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = pytest.mark.slow
TASKS = sorted((Path(__file__).resolve().parents[2] / "docs" / "lesson").glob("task*.md"))
STYLE = "body { font: 11pt/1.4 sans-serif } pre, code { font: 10pt/1.3 monospace }"


def test_there_are_six_in_two_languages() -> None:
    assert len(TASKS) == 12


@pytest.mark.parametrize("page", TASKS, ids=lambda page: page.name)
def test_a_task_is_one_printed_page(page: Path, browser: Browser) -> None:
    markdown = pytest.importorskip("markdown", reason='pip install ".[docs]"')
    body = markdown.markdown(page.read_text("utf-8"), extensions=["fenced_code"])
    tab = browser.new_page()
    tab.set_content(f'<meta charset="utf-8"><style>{STYLE}</style>{body}')
    margin = dict.fromkeys(("top", "bottom", "left", "right"), "15mm")
    printed = tab.pdf(format="A4", margin=margin)
    tab.close()
    assert len(re.findall(rb"/Type\s*/Page\b", printed)) == 1
