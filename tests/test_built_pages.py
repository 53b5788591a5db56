"""What MkDocs makes of the pages: every heading and every code block of a source is one on the page.

`--strict` does not see a fence that MkDocs does not know: it becomes text, and what follows it becomes code.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

pytest.importorskip("mkdocs", reason='MkDocs is not installed: pip install ".[docs]"')
pytest.importorskip("material", reason='Material for MkDocs is not installed: pip install ".[docs]"')

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted(path.relative_to(ROOT / "docs").as_posix() for path in (ROOT / "docs").glob("*.md"))
LARGEST = 300_000  # bytes of one page; the reference of everything at once had 452,000


def build(folder: Path) -> None:
    """The documentation, strictly."""
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "-d", str(folder)],
        cwd=ROOT, capture_output=True, text=True, timeout=300, env={**os.environ, "NO_MKDOCS_2_WARNING": "1"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


class Counted(HTMLParser):
    """Headings, code blocks and tables of the article on a page."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.headings: list[int] = []
        self.blocks: list[str] = []
        self.tables = 0
        self._inside = self._in_block = False
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag == "article":
            self._inside = True
        elif self._inside and re.fullmatch("h[1-6]", tag):
            self.headings.append(int(tag[1]))
        elif self._inside and tag == "pre":
            self._in_block = True
            self.blocks.append("")
        elif self._inside and tag == "table":
            self.tables += 1

    def handle_endtag(self, tag: str) -> None:
        if tag == "article":
            self._inside = False
        elif tag == "pre":
            self._in_block = False

    def handle_data(self, data: str) -> None:
        if self._in_block:
            self.blocks[-1] += data


def source(text: str) -> tuple[list[int], list[str]]:
    """(levels of the headings, code blocks) of a page as it is written: fences, and lines that are indented."""
    blocks: list[str] = []
    fence = re.compile(r"^```[^\n]*\n(.*?)^```$", re.MULTILINE | re.DOTALL)
    indented = re.compile(r"(?<=\n\n)(?: {4}[^\n]*\n(?:\n(?= {4}))?)+")
    for found in re.finditer(f"{fence.pattern}|{indented.pattern}", text, re.MULTILINE | re.DOTALL):
        blocks.append(
            found[1] if found[1] is not None else re.sub(r"^ {4}", "", found[0], flags=re.MULTILINE)
        )
    prose = fence.sub("", text)
    return [len(marks) for marks in re.findall(r"^(#+) ", prose, re.MULTILINE)], blocks


@pytest.mark.slow
def test_what_is_built_is_what_was_written(tmp_path: Path) -> None:
    """One build, and every look at it."""
    build(tmp_path)
    for name in PAGES:
        keeps_headings_and_code(tmp_path, name)
    classes_have_pages_of_their_own(tmp_path)
    both_languages_can_be_searched(tmp_path)


def keeps_headings_and_code(site: Path, name: str) -> None:
    """As many of each, in the same order, with the same words."""
    headings, blocks = source((ROOT / "docs" / name).read_text("utf-8"))
    built = Counted((site / name).with_suffix(".html").read_text("utf-8"))
    assert built.headings == headings, name
    assert [block.split() for block in built.blocks] == [block.split() for block in blocks], name


def test_a_lost_fence_is_noticed() -> None:
    """What the counting is for: code that became text."""
    _, blocks = source("# A\n\n```python robot\nx = 1\n```\n\n    woosh demo\n\nend\n")
    assert blocks == ["x = 1\n", "woosh demo\n"]
    assert Counted("<article><h1>A</h1><p>```python robot x = 1</p></article>").blocks == []


def classes_have_pages_of_their_own(site: Path) -> None:
    """Small enough to be opened on a phone, and listed where its package is."""
    for page in site.rglob("*.html"):
        assert page.stat().st_size < LARGEST, page.relative_to(site)
    listing = (site / "api/woosh_pure.html").read_text("utf-8")
    for name in ("Chassis", "Feed", "Battery", "Pose2D"):
        assert (site / f"api/woosh_pure/{name}.html").exists()
        assert f'href="woosh_pure/{name}.html"' in listing


def both_languages_can_be_searched(site: Path) -> None:
    """The index knows words of English pages and of Chinese ones, cut apart as Chinese needs it."""
    index = json.loads((site / "search/search_index.json").read_text("utf-8"))
    assert index["config"]["lang"] == ["en", "zh"]
    assert r"\u200b" in index["config"]["separator"]
    words = {page["location"]: page["text"] for page in index["docs"]}
    assert "Chassis" in words["chassis.html"]
    assert "\u200b" in words["chassis.zh-CN.html"], "Chinese is not cut into words: is jieba installed?"
