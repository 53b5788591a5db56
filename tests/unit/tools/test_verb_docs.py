"""Every verb of `Chassis` says its units, frames, errors, and the topic or service behind it."""

from __future__ import annotations

import inspect
import re

import pytest

from tools.interface_page import VERBS
from woosh_pure import Chassis
from woosh_pure.feed.feed import Feed
from woosh_pure.motion.action_goal import ActionHandle, NavigationHandle, StepHandle
from woosh_pure.motion.motion import GoalHandle
from woosh_pure.motion.task import TaskHandle
from woosh_pure.velocity.drive import Drive

WORDS = ("m", "rad", "s", "m/s", "rad/s", "map", "base_link")
SHORT = {"forward", "left", "right"}  # `move` and `rotate` by another name: their docs say the rest
QUESTIONS = {"on_connection", "wait_until", "wait_until_ready", "readiness", "request", "snapshot", "feed"}


def doc_of(name):
    return inspect.getdoc(getattr(Chassis, name)) or ""


def has_word(text, word):
    return re.search(rf"(?<![\w/]){re.escape(word)}(?![\w/])", text) is not None


@pytest.mark.parametrize("verb", VERBS, ids=lambda verb: verb.name)
def test_a_verb_names_what_is_behind_it(verb):
    doc = doc_of(verb.name)
    assert [row for row in verb.rows if row not in doc and row != "/robot_status"] == []


@pytest.mark.parametrize("verb", VERBS, ids=lambda verb: verb.name)
def test_a_verb_says_units_and_frames(verb):
    doc = doc_of(verb.name)
    wanted = [word for word in WORDS if has_word(verb.units, word)]
    assert [word for word in wanted if not has_word(doc, word)] == []


@pytest.mark.parametrize("verb", VERBS, ids=lambda verb: verb.name)
def test_a_verb_says_its_errors(verb):
    doc = doc_of(verb.name)
    assert "Raises:" in doc or "never raises" in doc


@pytest.mark.parametrize("verb", VERBS, ids=lambda verb: verb.name)
def test_a_verb_explains_every_argument(verb):
    doc = doc_of(verb.name)
    parameters = [
        p.name
        for p in list(inspect.signature(getattr(Chassis, verb.name)).parameters.values())[1:]
        if p.kind is not p.VAR_KEYWORD
    ]
    missing = [
        name for name in parameters if not re.search(rf"^ *(\w+, )*{name}(, \w+)*: ", doc, re.MULTILINE)
    ]
    assert missing == []


def test_no_verb_is_missing_from_the_list():
    """Whoever adds a method to `Chassis` puts it into the list of verbs, or says that it is none."""
    methods = {name for name, value in inspect.getmembers(Chassis, inspect.isfunction) if name[0] != "_"}
    assert methods - {verb.name for verb in VERBS} == {*QUESTIONS, *SHORT, "close"}


@pytest.mark.parametrize(
    "kind",
    [Feed, GoalHandle, TaskHandle, ActionHandle, NavigationHandle, StepHandle, Drive],
    ids=lambda k: k.__name__,
)
def test_every_public_member_of_what_verbs_return_is_explained(kind):
    members = [
        (n, m)
        for n, m in inspect.getmembers(kind)
        if n[0] != "_" and (callable(m) or isinstance(m, property))
    ]
    assert [name for name, member in members if not inspect.getdoc(member)] == []
