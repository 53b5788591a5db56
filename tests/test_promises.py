"""What the pages promise is held by tests, and a test that holds a promise names it:

    @pytest.mark.promise("XML with a DOCTYPE or entities is refused")

The words stand in one sentence of SECURITY.md, in one line of the table in docs/safety.md, or in one fact of
docs/wire.md. `python -m tests.test_promises [WORDS]` lists the promises (with these words), each with its tests.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

pytestmark = pytest.mark.structure

ROOT = Path(__file__).resolve().parent.parent
SECURITY, SAFETY, WIRE = "SECURITY.md", "docs/safety.md", "docs/wire.md"

NO_PROMISE = (
    # What this is about, and how to report something.
    "ROS 1 has no authentication",
    "This project cannot change that",
    "It keeps a program running",
    "**Report** a weakness",
    "Report a fault",
    "You get an answer within a week",
    "A peer announces the host of its node",
    "For the safety of motion see",
    "Each line of it, and each",
    "In short: nothing moves by default",  # docs/safety.md, line by line
    "The watchdog beside the commands",
    # What is not covered, and what is left to the reader.
    "Not covered:",
    "`rosproto.bag.open_bag`, `partitions` and the `bag` verbs fetch",
    "It is data: it only decides",
    "Learn only from a robot",
    "A fleet manager (`woosh vda5050`) is trusted",
    "None of this is an emergency stop",
    # Above a table.
    "`Node(limits=...)`",
    "Definitions that peers send (",
    "Clients of a gateway (",
    "Bags that others made (",
)
"""How the other sentences of SECURITY.md begin."""


def one_line(text: str) -> str:
    return " ".join(text.split())


def sentences(page: str) -> Iterator[str]:
    """Of paragraphs and points, not of headings and tables."""
    for block in re.split(r"\n(?=- |#|\||\n)", page):
        text = one_line(block)
        if text and not text.startswith(("#", "|")):
            yield from re.split(r"(?<=\.) (?=[A-Z`*])", text.removeprefix("- "))


def lines_of_the_table(page: str) -> Iterator[str]:
    """First cells of docs/safety.md."""
    table = page.partition("| what happens | what stops, and how |")[2].partition("\n\n")[0]
    for row in table.splitlines()[2:]:
        yield row.removeprefix("| ").partition(" | ")[0]


def facts(page: str) -> Iterator[str]:
    """Numbered points of docs/wire.md, without their numbers."""
    for fact in re.split(r"^\d+\. ", page, flags=re.MULTILINE)[1:]:
        yield one_line(fact.partition("\n#")[0])


def promises_of(security: str, safety: str, wire: str) -> list[str]:
    """Each promise of the pages with these texts."""
    return [
        *(text for text in sentences(security) if not text.startswith(NO_PROMISE)),
        *lines_of_the_table(safety),
        *facts(wire),
    ]


def markers(source: str) -> Iterator[tuple[str, str]]:
    """(name of the test, words) of each promise that the tests in a file are marked with."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            for mark in node.decorator_list:
                if isinstance(mark, ast.Call) and ast.unparse(mark.func) == "pytest.mark.promise":
                    for words in mark.args:
                        yield node.name, str(ast.literal_eval(words))


@cache
def pages() -> tuple[str, str, str]:
    security, safety, wire = ((ROOT / page).read_text("utf-8") for page in (SECURITY, SAFETY, WIRE))
    return security, safety, wire


@cache
def marked() -> list[tuple[str, str]]:
    """(test, words) of all tests."""
    found = []
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        source = path.read_text("utf-8")
        if path != Path(__file__) and "mark.promise" in source:
            found += [
                (f"{path.relative_to(ROOT).as_posix()}::{name}", words) for name, words in markers(source)
            ]
    return found


def without_a_test(promises: list[str], marked: list[tuple[str, str]]) -> list[str]:
    return [promise for promise in promises if not any(words in promise for _, words in marked)]


def in_vain(promises: list[str], marked: list[tuple[str, str]]) -> list[tuple[str, str]]:
    """Marks whose words stand in no promise, or in several, so that nobody knows which is meant."""
    return [(test, words) for test, words in marked if sum(words in promise for promise in promises) != 1]


def test_the_pages_are_read() -> None:
    """As many as there were, at least: a changed heading must not hide a table."""
    security, safety, wire = pages()
    assert len(promises_of(security, "", "")) > 80
    assert len(list(lines_of_the_table(safety))) > 30
    assert len(list(facts(wire))) > 60


def test_every_promise_has_a_test() -> None:
    """Mark a test of it; what promises nothing stands in NO_PROMISE."""
    assert without_a_test(promises_of(*pages()), marked()) == []


def test_every_mark_names_one_promise() -> None:
    """The words of a mark are on the page: who rewrites a promise looks at its tests."""
    assert in_vain(promises_of(*pages()), marked()) == []


def test_what_promises_nothing_is_there() -> None:
    assert [b for b in NO_PROMISE if not any(s.startswith(b) for s in sentences(pages()[0]))] == []


def test_the_watch_sees_what_is_missing() -> None:
    """A check that cannot fail checks nothing."""
    promises = promises_of(
        "# A\n\n- Nothing moves. It is\n  bounded.\n", "", "1. A fact, with\n   two lines.\n\n## B\n"
    )
    assert promises == ["Nothing moves.", "It is bounded.", "A fact, with two lines."]
    source = '@pytest.mark.promise("Nothing moves", "is gone")\ndef test_it(): pass\n'
    found = list(markers(source))
    assert found == [("test_it", "Nothing moves"), ("test_it", "is gone")]
    assert without_a_test(promises, found) == promises[1:]
    assert in_vain(promises, found) == [("test_it", "is gone")]
    assert in_vain(["It is bounded.", "It is bounded, too."], [("test_it", "It is bounded")]) != []


if __name__ == "__main__":
    wanted = " ".join(sys.argv[1:])
    for promise in promises_of(*pages()):
        if wanted in promise:
            print(promise, *(f"    {test}" for test, words in marked() if words in promise), sep="\n")
