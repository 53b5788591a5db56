"""`woosh doctor`'s look at definitions: which md5sum each part of the chassis speaks, against ours.

Topics are asked of their publishers, services of their providers, goals of the robot's own client of each
action (a server does not tell; its goal topic only accepts or refuses). Only headers are exchanged.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import rosproto
from rosproto.errors import RosError
from rosproto.node import probe_service, probe_topic
from rosproto.sentence import say
from rosproto.transport import Deadline
from woosh_pure import interface
from woosh_pure.doctor.finding import Finding, Level
from woosh_pure.firmware.revisions import revision_label
from woosh_pure.interface.table import Row
from woosh_pure.values.rostypes import message_type, service_type

__all__ = ["check_definitions", "finding_of"]

_ONE_QUESTION = 2.0  # seconds


class _Question(NamedTuple):
    name: str
    node: str
    type: str
    ours: str


def check_definitions(node: rosproto.Node, state: rosproto.node.SystemState) -> Iterator[Finding]:
    """One finding for each definition that differs, or one that says that all agree."""
    asked = differing = 0
    for question in _questions(state):
        theirs = _answer(node, question)
        asked += bool(theirs)
        if theirs not in ("", question.ours):
            differing += 1
            yield finding_of(question.name, question.node, question.type, theirs, question.ours)
    if not differing:
        yield Finding(
            "definition", Level.OK, say("all message definitions agree ({asked} asked)", asked=asked)
        )


def finding_of(name: str, node: str, type_name: str, theirs: str, ours: str) -> Finding:
    """What a differing definition means. Pure."""
    label, note = revision_label(type_name, theirs)
    if label:
        text = say(
            "{name}: {node} has {type} as of firmware {label}",
            name=name,
            node=node,
            type=type_name,
            label=f"{label} ({note})" if note else label,
        )
        advice = "nothing is needed: this revision is known, and values are carried over by field name"
        return Finding("definition", Level.WARNING, text, advice)
    text = say(
        "{name}: {node} has another {type} (md5sum {theirs}, ours {ours})",
        name=name,
        node=node,
        type=type_name,
        theirs=theirs,
        ours=ours,
    )
    advice = (
        "this revision is not known; values are carried over by field name where that is possible. Run "
        "`woosh learn`, which keeps the robot's own definitions, and report both md5sums"
    )
    return Finding("definition", Level.WARNING, text, advice)


def _questions(state: rosproto.node.SystemState) -> Iterator[_Question]:
    for row in interface.ROWS:
        if row.definition_known:
            yield from _questions_of(row, state)


def _questions_of(row: Row, state: rosproto.node.SystemState) -> Iterable[_Question]:
    if row.kind == "service":
        ours = service_type(row.type)._md5sum
        return [_Question(row.name, node, row.type, ours) for node in state.services.get(row.name, [])]
    name, type_name = (row.name, row.type) if row.kind == "topic" else _goal_of(row)
    ours = message_type(type_name)._md5sum
    publishers = state.publishers.get(name, []) if row.flow in ("read", "act") else []
    return [_Question(name, node, type_name, ours) for node in publishers]


def _goal_of(row: Row) -> tuple[str, str]:
    return f"{row.name}/goal", f"{row.type}ActionGoal"


def _answer(node: rosproto.Node, question: _Question) -> str:
    """The md5sum the peer tells; "" when it cannot be asked (other checks tell that)."""
    deadline = Deadline(_ONE_QUESTION)
    try:
        if question.name in _SERVICES:
            return probe_service(node, question.name, deadline).get("md5sum", "")
        return probe_topic(node, question.name, question.node, deadline).md5sum
    except (RosError, OSError):
        return ""


_SERVICES = frozenset(row.name for row in interface.services())
