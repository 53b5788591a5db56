"""The texts under which people look up their trouble are texts that the code can say."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest

from tools.templates import TABLES
from woosh_pure.language.table import read_table

pytestmark = pytest.mark.whole

ROOT = Path(__file__).resolve().parent.parent
# What other programs say: the shell, Python, and the name of an attribute.
FOREIGN = {"woosh: command not found", "'woosh' is not recognized", "No module named 'rospy'", "close_reason"}


@cache
def said() -> str:
    """Every literal text of the code, each on a line; what is filled in is a NUL."""
    found = []
    for package in ("rosproto", "woosh_pure"):
        for file in (ROOT / package).rglob("*.py"):
            for node in ast.walk(ast.parse(file.read_text("utf-8"))):
                if isinstance(node, ast.JoinedStr):
                    parts = [p.value if isinstance(p, ast.Constant) else "\0" for p in node.values]
                    found.append("".join(map(str, parts)))
                elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                    found.append(node.value)
    return "\n".join(found)


def rows(page: str, title: str) -> list[list[str]]:
    """What stands in backquotes in each cell of the first column of the table below a heading."""
    section = (ROOT / page).read_text("utf-8").partition(f"## {title}")[2].partition("\n## ")[0]
    return [re.findall(r"`([^`]+)`", row) for row in re.findall(r"^\| (.*?) \| ", section, re.MULTILINE)]


def texts(page: str, title: str) -> list[str]:
    return [text for row in rows(page, title) for text in row]


TEXTS = [
    *texts("docs/troubleshooting.md", "By error text"),
    *(text for text in texts("docs/firmware.md", "What errors mean")),
]


def unsaid(text: str) -> list[str]:
    """Pieces of it that no code says; dots and numbers stand for what differs."""
    pieces = re.split(
        r"\.\.\.|'\.\.\.'|\b[\d.]+\d\b|\b\d\b|\b[AB]\b|/\w+|^\w+Error:|^\w+Mismatch:|^FirmwareLimit:", text
    )
    return [words for words in (piece.strip(" ;:,'") for piece in pieces) if words and not is_said(words)]


@pytest.mark.slow  # reads all sources
def test_the_code_says_it() -> None:
    """Word for word, whatever is between what differs."""
    found = {text: unsaid(text) for text in TEXTS if text not in FOREIGN}
    assert {text: words for text, words in found.items() if words} == {}


PLACE = r"\.\.\.|'\.\.\.'|\b[\d.]+\d\b|\b\d\b|/\w+"
"""What stands for a value in a text."""
CHINESE = [
    (english, [text for text in chinese if re.search("[一-鿿]", text)])
    for pages in (
        (("docs/troubleshooting.md", "By error text"), ("docs/troubleshooting.zh-CN.md", "按错误文字查找")),
        (("docs/firmware.md", "What errors mean"), ("docs/firmware.zh-CN.md", "错误的含义")),
    )
    for english, chinese in zip(rows(*pages[0]), rows(*pages[1]), strict=True)
]
"""Of each row: what an English system says, and what a Chinese one."""


@cache
def table() -> list[tuple[str, str]]:
    """Of each row of the tables: the sentence and its translation, with NULs for values."""
    found = [row for path in TABLES for row in read_table(path.read_text("utf-8"), path.name)]
    return [
        (re.sub(r"\{\w+\}", "\0", row.english), re.sub(r"\{\w+\}", "\0", row.translated)) for row in found
    ]


def pieces(text: str, between: str = PLACE) -> list[str]:
    return [words for piece in re.split(between, text) if (words := piece.strip(" ;:,'"))]


@pytest.mark.parametrize("text", [text for _, chinese in CHINESE for text in chinese])
def test_a_chinese_system_says_it(text: str) -> None:
    """Of several sentences, each."""
    said = "\n".join(translated for _, translated in table())
    assert [words for words in pieces(text, f"{PLACE}|[；：]") if words not in said] == []


def test_what_a_chinese_system_says_is_on_its_page() -> None:
    """People look for the text that they see."""
    assert sum(bool(chinese) for _, chinese in CHINESE) > 20
    for english, chinese in CHINESE:
        for text in english:
            words = pieces(text)
            differs = any(all(w in said and w not in there for w in words) for said, there in table())
            assert chinese or not differs, f"{text!r} has a translation"


def is_said(words: str) -> bool:
    """As it stands, or in two pieces with something filled in between."""
    if words in said():
        return True
    cuts = [m.start() for m in re.finditer(" ", words)]
    return any(words[:cut] in said() and words[cut:] in said() for cut in cuts)


def test_there_are_texts() -> None:
    """The headings are still called so."""
    assert len(TEXTS) > 35
