"""The page has words, in both languages, for every key that the server may send."""

from __future__ import annotations

import ast
import re
from pathlib import Path
from string import Formatter

import pytest

pytest.importorskip("pydantic", reason="needs the extra `web`")

from woosh_pure.enums import RobotMode, RobotState, TaskState
from woosh_pure.outcome import OutcomeKind
from woosh_pure.reasons import ReasonKey
from woosh_pure.web.goals import COMMANDS
from woosh_pure.web.http_errors import KINDS, REFUSAL_KINDS, STATUS_KINDS

PAGE = Path(__file__).parents[4] / "woosh_pure" / "web" / "page" / "js"


def words(language: str) -> dict[str, str]:
    """The dictionary of the page: one key and its text on a line."""
    found: dict[str, str] = {}
    for path in PAGE.glob(f"words_{language}*.js"):
        found |= re.findall(r'^  "([^"]+)": "(.+)",$', path.read_text("utf-8"), re.MULTILINE)
    return found


@pytest.mark.parametrize("language", ["en", "zh"])
def test_each_key_has_words(language: str) -> None:
    known = words(language)
    asked = [
        *(f"state.{one}" for one in RobotState),
        *(f"mode.{one}" for one in RobotMode),
        *(f"goal.{one}" for one in (*TaskState, *OutcomeKind)),
        *(f"why.{one}" for one in ReasonKey),
        *(f"todo.{one}" for one in ReasonKey if one is not ReasonKey.CALL),
        *(f"what.{one}" for one in COMMANDS),
    ]
    assert [key for key in asked if key not in known] == []


def kinds_of_problems() -> set[str]:
    """The keys given to `Problem` in the sources, those of refusals, and those that follow from a status."""
    found = {kind for _, _, kind in KINDS} | set(REFUSAL_KINDS.values())
    for path in (PAGE.parents[1]).rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if not (isinstance(node, ast.Call) and ast.unparse(node.func) == "Problem"):
                continue
            status, _, *kind = (getattr(arg, "value", None) for arg in node.args)
            text = kind[0] if kind else STATUS_KINDS.get(status, "")
            found |= {text} if isinstance(text, str) and text else set()
    return found


@pytest.mark.parametrize("language", ["en", "zh"])
def test_each_problem_has_words(language: str) -> None:
    kinds = kinds_of_problems()
    assert {"mark-exists", "too-many-tokens", "not-this-server", "timeout"} <= kinds
    assert [kind for kind in sorted(kinds) if f"problem.{kind}" not in words(language)] == []


@pytest.mark.parametrize("language", ["en", "zh"])
def test_the_words_of_a_command_show_values_that_it_has(language: str) -> None:
    known = words(language)
    for key, template in COMMANDS.items():
        has = {name for _, name, _, _ in Formatter().parse(template) if name}
        shown = {name for _, name, _, _ in Formatter().parse(known[f"what.{key}"]) if name}
        assert shown <= has, key
