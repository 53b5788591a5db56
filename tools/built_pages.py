"""A hook of MkDocs: every heading and every block of code of a written page is one of the built page, too.

`--strict` does not see a fence that MkDocs does not know: it becomes text, and what follows it becomes code.
What is found is a warning, which ends a strict build.
"""

from __future__ import annotations

import json
import logging
import re
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

MAX_PAGE_BYTES = 300_000  # bytes of one page; the reference of everything at once had 452,000


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
    """(levels of the headings, code blocks) of a page as it is written: fences, and indented lines."""
    blocks: list[str] = []
    fence = re.compile(r"^```[^\n]*\n(.*?)^```$", re.MULTILINE | re.DOTALL)
    indented = re.compile(r"(?<=\n\n)(?: {4}[^\n]*\n(?:\n(?= {4}))?)+")
    for found in re.finditer(f"{fence.pattern}|{indented.pattern}", text, re.MULTILINE | re.DOTALL):
        blocks.append(
            found[1] if found[1] is not None else re.sub(r"^ {4}", "", found[0], flags=re.MULTILINE)
        )
    prose = fence.sub("", text)
    return [len(marks) for marks in re.findall(r"^(#+) ", prose, re.MULTILINE)], blocks


def lost(docs: Path, site: Path) -> Iterator[str]:
    """Pages whose headings or code blocks differ from the source."""
    for page in sorted([*docs.glob("*.md"), *docs.glob("commands/*.md")]):
        headings, blocks = source(page.read_text("utf-8"))
        built = Counted((site / page.relative_to(docs)).with_suffix(".html").read_text("utf-8"))
        if built.headings != headings:
            yield f"{page.name} has other headings when it is built"
        if [block.split() for block in built.blocks] != [block.split() for block in blocks]:
            yield f"{page.name} has other blocks of code when it is built"


def too_large(site: Path) -> Iterator[str]:
    """Pages that are too large for a phone; classes without their own page."""
    for page in site.rglob("*.html"):
        if page.stat().st_size >= MAX_PAGE_BYTES:
            yield f"{page.relative_to(site)} has {page.stat().st_size} bytes"
    listing = (site / "api/woosh_pure.html").read_text("utf-8")
    for name in ("Chassis", "Feed", "Battery", "Pose2D"):
        if (
            not (site / f"api/woosh_pure/{name}.html").exists()
            or f'href="woosh_pure/{name}.html"' not in listing
        ):
            yield f"{name} has no page of its own, or is not listed"


def not_found(site: Path) -> Iterator[str]:
    """English and segmented Chinese words that the search does not find."""
    index = json.loads((site / "search/search_index.json").read_text("utf-8"))
    words = {page["location"]: page["text"] for page in index["docs"]}
    if index["config"]["lang"] != ["en", "zh"] or r"\u200b" not in index["config"]["separator"]:
        yield "the search is not made for English and Chinese"
    if "Chassis" not in words["chassis.html"]:
        yield "the search does not know Chassis"
    if "\u200b" not in words["chassis.zh-CN.html"]:
        yield "Chinese is not cut into words: is jieba installed?"


def on_post_build(config: Any, **_: Any) -> None:
    log = logging.getLogger("mkdocs.hooks.built_pages")
    docs, site = Path(config.docs_dir), Path(config.site_dir)
    for found in (*lost(docs, site), *too_large(site), *not_found(site)):
        log.warning(found)
