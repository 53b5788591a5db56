"""The texts under which people look up their trouble are texts that the code can say."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest

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


def texts(page: str, title: str) -> list[str]:
    """What stands in backquotes in the first column of the table below a heading."""
    section = (ROOT / page).read_text("utf-8").partition(f"## {title}")[2].partition("\n## ")[0]
    rows = re.findall(r"^\| (.*?) \| ", section, re.MULTILINE)
    return [text for row in rows for text in re.findall(r"`([^`]+)`", row)]


TEXTS = [
    *texts("docs/troubleshooting.md", "By error text"),
    *(text for text in texts("docs/firmware.md", "What errors mean")),
]


@pytest.mark.parametrize("text", [text for text in TEXTS if text not in FOREIGN])
def test_the_code_says_it(text: str) -> None:
    """Dots and numbers stand for what differs; whatever is between them is in the code, word for word."""
    for piece in re.split(
        r"\.\.\.|'\.\.\.'|\b[\d.]+\d\b|\b\d\b|\b[AB]\b|/\w+|^\w+Error:|^\w+Mismatch:|^FirmwareLimit:", text
    ):
        words = piece.strip(" ;:,'")
        assert not words or is_said(words), f"{words!r} of {text!r}"


def is_said(words: str) -> bool:
    """As it stands, or in two pieces with something filled in between."""
    if words in said():
        return True
    cuts = [m.start() for m in re.finditer(" ", words)]
    return any(words[:cut] in said() and words[cut:] in said() for cut in cuts)


def test_there_are_texts() -> None:
    """The headings are still called so."""
    assert len(TEXTS) > 35
