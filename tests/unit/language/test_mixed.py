"""No English words stand inside a Chinese sentence: a value that is prose is a sentence of its own."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

import pytest

from tools.templates import ROOT, _called, _sources, _tree
from woosh_pure.language.table import translator_for

pytestmark = [pytest.mark.structure, pytest.mark.slow]
SAYING = {"say", "both", "led", "advice", "counted"}
PROSE = re.compile(r"^ (and|or|nor|and no|but) $|[a-z]{2,} [a-z]{2,}")
COMMAND = re.compile(r"^(woosh|rosproto|pip|rosrun) ")


def plain_texts(node: ast.AST) -> Iterator[ast.Constant]:
    """The constants of a value that are not sentences of their own."""
    if isinstance(node, ast.Call) and _called(node) in SAYING:
        return
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        yield node
    for child in ast.iter_child_nodes(node):
        yield from plain_texts(child)


def prose_values() -> Iterator[str]:
    for path in _sources():
        for node in ast.walk(_tree(path)):
            if not (isinstance(node, ast.Call) and _called(node) in {"say", "line", "advice"}):
                continue
            for word in node.keywords:
                for text in plain_texts(word.value):
                    if PROSE.search(text.value) and not COMMAND.search(text.value):
                        yield f"{path.relative_to(ROOT)}:{node.lineno}: {word.arg}={text.value!r}"


def test_a_value_that_is_prose_is_a_sentence() -> None:
    """A plain text as a value stays English in a translated sentence; make it one with `say`."""
    assert list(prose_values()) == []


def test_a_list_and_a_choice_of_near_names_have_no_english_words() -> None:
    from rosproto.sentence import hint

    [both] = hint("stat", ["status", "start"])
    assert both == "did you mean start or status?" or both == "did you mean status or start?"
    assert " or " not in translator_for("zh").say(both)
