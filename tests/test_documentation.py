"""What the documentation says is run: every Python snippet, and the commands README and CI share."""

from __future__ import annotations

import argparse
import ast
import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.extras import needs
from tests.support.robot_pool import RobotPool
from tests.support.warm import WarmPython

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted([*ROOT.glob("README*.md"), *(ROOT / "docs").rglob("*.md")])
FENCE = re.compile(r"^```python\n(?P<code>.*?)^```$", re.MULTILINE | re.DOTALL)


ROBOT_USED = re.compile(r'with Chassis\((?:"169.254.128.2")?\)')


def snippets() -> list[tuple[str, str]]:
    """(places, code) of every fenced Python block, without exception.

    What differs in comments only, as on the page in another language, is one.
    """
    found: dict[str, tuple[str, str]] = {}
    for page in PAGES:
        text = page.read_text("utf-8")
        for match in FENCE.finditer(text):
            line = text.count("\n", 0, match.start()) + 1
            place, code = f"{page.relative_to(ROOT).as_posix()}:{line}", match["code"]
            same = ast.dump(ast.parse(code))
            found[same] = (f"{found[same][0]} {place}", code) if same in found else (place, code)
    return list(found.values())


SNIPPETS = snippets()
INDENTED = re.compile(r"^    ((?:woosh|rosproto) [^\n]*)$", re.MULTILINE)
INLINE = re.compile(r"`((?:woosh|rosproto) [a-z-][^`]*)`")


def commands() -> dict[str, str]:
    """Every complete `woosh` and `rosproto` command in the pages, and one page that has it."""
    found: dict[str, str] = {}
    for page in PAGES:
        text = page.read_text("utf-8")
        name = page.relative_to(ROOT).as_posix()
        for match in (*INDENTED.finditer(text), *INLINE.finditer(text)):
            # Words in capitals and dots stand for something; such a line is an explanation, not a command. A
            # name with a value, as in `--mark DOCK=1.5,0.5,90`, is one.
            if not re.search(r"\.\.\.|[|<>\[]|\b[A-Z]{3,}\b(?!=[-0-9])", match[1]):
                found[match[1].partition("  #")[0].strip()] = name
    return found


def test_the_commands_of_the_pages_are_accepted_by_their_parsers() -> None:
    """No page names a command or an option that does not exist."""
    assert len(commands()) > 150
    assert [(page, line) for line, page in commands().items() if not _is_accepted(line)] == []


def _is_accepted(line: str) -> bool:
    program, *words = shlex.split(line)
    if program == "woosh":
        from woosh_pure.cli.entry import parser_for

        parser = parser_for(words)
    else:
        from rosproto.cli.entry import parser_for

        parser = parser_for(words)
    # A mere mention of a command that wants an argument, as in "see `rosproto topic`", is fine too.
    mention = len(words) <= 2 and not any(word.startswith("-") for word in words)
    return _exit_code(parser, words) == 0 or (mention and _exit_code(parser, [*words, "--help"]) == 0)


def _exit_code(parser: argparse.ArgumentParser, words: list[str]) -> object:
    """How parsing ends: 0 when the words are accepted, or ask for help."""
    try:
        parser.parse_args(words)
    except SystemExit as left:
        return left.code
    return 0


SMALL = """
import woosh_pure
class SimulatedChassis(woosh_pure.SimulatedChassis):
    def __init__(self, **options):
        super().__init__(**{"full_graph": False, **options})
woosh_pure.SimulatedChassis = SimulatedChassis
"""
"""Without the parts of a simulated chassis that carry no content, which cost most of its start."""


EXTRAS = {"Rosbridge": "bridge", "Foxglove": "foxglove", "fastapi": "web", "websockets": "api"}
"""What a snippet imports, and the extra that it needs."""


@pytest.fixture(scope="module")
def python() -> Iterator[WarmPython]:
    with WarmPython() as warm:
        yield warm


@pytest.fixture(scope="module")
def robots() -> Iterator[RobotPool]:
    with RobotPool() as pool:
        yield pool


@pytest.mark.slow
@pytest.mark.parametrize(("place", "code"), SNIPPETS, ids=[place for place, _ in SNIPPETS])
def test_a_snippet_runs(place: str, code: str, python: WarmPython, robots: RobotPool, tmp_path: Path) -> None:
    """A reader who pastes it into a file gets what the page promises: no error."""
    for name, extra in EXTRAS.items():
        if re.search(rf"import .*\b{name}\b|from {name}[. ]", code):
            needs(extra)
    script = tmp_path / "snippet.py"
    robot = robots.take(speed=8.0) if ROBOT_USED.search(code) else None
    if robot is not None:  # what is said of a robot is run on a simulated one
        code = ROBOT_USED.sub(f'with Chassis("{robot.sim.master_uri}")', code)
    script.write_text(code, "utf-8")
    done = python.run(script, tmp_path, before=SMALL)
    if robot is not None:
        robots.give_back(robot)
    assert done.returncode == 0, f"{place}\n{done.stdout}\n{done.stderr}"
