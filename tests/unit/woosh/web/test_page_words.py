"""The page has words, in both languages, for every key that the server may send."""

from __future__ import annotations

import re
from pathlib import Path
from string import Formatter

import pytest

from woosh_pure.enums import RobotMode, RobotState, TaskState
from woosh_pure.outcome import OutcomeKind
from woosh_pure.reasons import ReasonKey
from woosh_pure.web.goals import COMMANDS
from woosh_pure.web.http_errors import KINDS

PAGE = Path(__file__).parents[4] / "woosh_pure" / "web" / "page" / "js"


def words(language: str) -> dict[str, str]:
    """The dictionary of the page: one key and its text on a line."""
    found: dict[str, str] = {}
    for name in (f"words_{language}.js", f"words_{language}_marks.js", f"words_{language}_state.js"):
        found |= re.findall(r'^  "([^"]+)": "(.+)",$', (PAGE / name).read_text("utf-8"), re.MULTILINE)
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
        *(f"problem.{kind}" for _, _, kind in KINDS),
    ]
    assert [key for key in asked if key not in known] == []


@pytest.mark.parametrize("language", ["en", "zh"])
def test_the_words_of_a_command_show_values_that_it_has(language: str) -> None:
    known = words(language)
    for key, template in COMMANDS.items():
        has = {name for _, name, _, _ in Formatter().parse(template) if name}
        shown = {name for _, name, _, _ in Formatter().parse(known[f"what.{key}"]) if name}
        assert shown <= has, key
