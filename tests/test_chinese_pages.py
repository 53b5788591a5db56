"""The Chinese pages stay in step with the English ones: headings, code, commands, tables, names, links."""

from __future__ import annotations

import ast
import re
from collections import Counter
from pathlib import Path

import pytest

pytestmark = pytest.mark.structure

ROOT = Path(__file__).resolve().parent.parent
CHINESE = sorted([*ROOT.glob("*.zh-CN.md"), *(ROOT / "docs").glob("*.zh-CN.md")])
FENCE = re.compile(r"^```(\w*)([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
MOST_OWNERS_NEED = {
    "README", "tutorial", "safety", "tour", "chassis", "simulator", "firmware", "all-commands", "comparison", "troubleshooting",
}  # fmt: skip


def test_what_an_owner_needs_is_there_in_chinese() -> None:
    assert {page.name.removesuffix(".zh-CN.md") for page in CHINESE} >= MOST_OWNERS_NEED


@pytest.fixture(params=CHINESE, ids=lambda page: page.name.removesuffix(".zh-CN.md"))
def pages(request: pytest.FixtureRequest) -> tuple[str, str]:
    """The texts of an English page and of its twin."""
    page: Path = request.param
    return english_of(page).read_text("utf-8"), page.read_text("utf-8")


def english_of(page: Path) -> Path:
    """Where the English twin is."""
    return page.with_name(page.name.replace(".zh-CN.md", ".md"))


def test_headings(pages: tuple[str, str]) -> None:
    """The same levels in the same order."""
    levels = [re.findall(r"^(#+) ", FENCE.sub("", page), re.MULTILINE) for page in pages]
    assert levels[0] == levels[1]


@pytest.mark.parametrize("kind", ["- ", r"\d+\. ", r"\*\*"])
def test_paragraphs(pages: tuple[str, str], kind: str) -> None:
    """As many points of lists, and paragraphs that begin in bold."""
    english, chinese = (len(re.findall(f"^{kind}", FENCE.sub("", p), re.MULTILINE)) for p in pages)
    assert english == chinese


def test_code(pages: tuple[str, str]) -> None:
    """The same programs but for comments and texts, run or not run alike."""
    english, chinese = ([(kind, flags, bare(code)) for kind, flags, code in FENCE.findall(p)] for p in pages)
    assert english == chinese


def bare(code: str) -> str:
    """A program without its comments and the texts that people read."""
    tree = ast.parse(code)
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and not NAME.fullmatch(node.value):
            node.value = "..."
    return ast.dump(tree)


NAME = re.compile(r"[/~]\w+(/\w+)*|\w+/\w+|[A-Z]\d|[\d.:]+")  # of topics, types, marks, chassis


def test_commands(pages: tuple[str, str]) -> None:
    """The same indented lines but for what stands in quotes (the name of a network card)."""
    english, chinese = (
        [
            re.sub(r'"[^"]*"', '""', line)
            for line in re.findall(r"^ {4}(\S.*)$", FENCE.sub("", p), re.MULTILINE)
        ]
        for p in pages
    )
    assert english == chinese


def test_tables(pages: tuple[str, str]) -> None:
    """The same rows: as many cells, and the same names and marks in each."""
    english, chinese = (
        [cells(row) for row in re.findall(r"^\|.*\|$", FENCE.sub("", p), re.MULTILINE)] for p in pages
    )
    for ours, theirs in zip(english, chinese, strict=True):
        assert ours == theirs


def cells(row: str) -> list[tuple[list[str], str]]:
    """Of each cell: the names in it, and the Y, P, N or - that it begins with."""
    parts = re.split(r"(?<!\\)\|", row)[1:-1]
    return [(names(part), (re.match(r" (\*\*N\*\*|[YPN-])(?=[ （])", part) or [""])[0]) for part in parts]


def names(text: str) -> list[str]:
    """What stands in backquotes, sorted: languages put words in another order."""
    return sorted(re.findall(r"`([^`]+)`", text))


def test_names_in_the_text(pages: tuple[str, str]) -> None:
    """Every verb, option and topic that one page names, the other names too."""
    english, chinese = (Counter(names(re.sub(r"<!--.*?-->", "", FENCE.sub("", page)))) for page in pages)
    # The Chinese page shows the network card by its Chinese name.
    assert {name for name in english.keys() ^ chinese.keys() if name.isascii()} <= {"Ethernet"}


LINK = re.compile(r"\[(?!English\]|中文|教程\])[^]]*\]\(([^)#\s]+)")


def test_links(request: pytest.FixtureRequest, pages: tuple[str, str]) -> None:
    """A Chinese page leads to the same places as the English one, and to Chinese ones where they exist."""
    english, chinese = (Counter(LINK.findall(page)) for page in pages)
    place = request.node.callspec.params["pages"].parent
    assert chinese == Counter(
        in_chinese if (place / (in_chinese := link.replace(".md", ".zh-CN.md"))).exists() else link
        for link in english.elements()
    )


def test_each_page_names_the_other(pages: tuple[str, str]) -> None:
    """A reader who came to the wrong language finds the right one at once."""
    english, chinese = pages
    assert "zh-CN.md)" in english[:1000]
    assert "[English](" in chinese[:1000]
