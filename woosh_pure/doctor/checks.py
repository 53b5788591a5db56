"""Checks and findings of `woosh doctor`: definitions that differ from ours, nodes that cannot be reached.

Topics are asked of their publishers, services of their providers, goals of the robot's own client of each
action (a server does not tell; its goal topic only accepts or refuses). Only headers are exchanged.
"""

from __future__ import annotations

import socket
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import rosproto
from rosproto.errors import ConnectionLost, MasterError, RosError, RosTimeout
from rosproto.node import probe_service, probe_topic
from rosproto.sentence import both, led, say
from rosproto.transport import Deadline, HostNames, connect, hosts_advice, parse_uri
from woosh_pure import interface
from woosh_pure.firmware.versions import revision_label
from woosh_pure.interface.schema import Row
from woosh_pure.values.messages import message_type, service_type


class Level(Enum):
    """The severity of a finding."""

    OK = "ok"
    WARNING = "warning"
    PROBLEM = "PROBLEM"


@dataclass(frozen=True, slots=True)
class Finding:
    """What one check found.

    Attributes:
        check: Its name, for programs.
        level: Its severity.
        text: The finding.
        advice: The remedy; "" if none is needed.
    """

    check: str
    level: Level
    text: str
    advice: str = ""

    def document(self) -> dict[str, str]:
        """For JSON, in English."""
        level = self.level.value.lower()
        return {"check": self.check, "level": level, "text": str(self.text), "advice": str(self.advice)}


def ok(check: str, text: str, **values: object) -> Finding:
    return Finding(check, Level.OK, say(text, **values))


def warn(check: str, text: str, advice: str = "", **values: object) -> Finding:
    return Finding(check, Level.WARNING, say(text, **values), advice)


def bad(check: str, text: str, advice: str, **values: object) -> Finding:
    return Finding(check, Level.PROBLEM, say(text, **values), advice)


_ONE_QUESTION = 2.0  # seconds


class _Question(NamedTuple):
    name: str
    node: str
    type: str
    ours: str


def check_definitions(node: rosproto.Node, state: rosproto.node.SystemState) -> Iterator[Finding]:
    """One finding for each definition that differs, or one that says that all agree."""
    asked = differing = 0
    known = (row for row in interface.ROWS if row.definition_known)
    for question in (question for row in known for question in _questions_of(row, state)):
        theirs = _answer(node, question)
        asked += bool(theirs)
        if theirs not in ("", question.ours):
            differing += 1
            yield finding_of(question.name, question.node, question.type, theirs, question.ours)
    if not differing:
        yield ok("definition", "all message definitions agree ({asked} asked)", asked=asked)


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
        advice = "nothing to do: this revision is known, and values are carried over by field name"
        return warn("definition", text, advice)
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
    return warn("definition", text, advice)


def _questions_of(row: Row, state: rosproto.node.SystemState) -> Iterable[_Question]:
    if row.kind == "service":
        ours = service_type(row.type)._md5sum
        return [_Question(row.name, node, row.type, ours) for node in state.services.get(row.name, [])]
    name, type_name = row.name, row.type
    if row.kind == "action":
        name, type_name = f"{row.name}/goal", f"{row.type}ActionGoal"
    ours = message_type(type_name)._md5sum
    publishers = state.publishers.get(name, []) if row.flow in ("read", "act") else []
    return [_Question(name, node, type_name, ours) for node in publishers]


def _answer(node: rosproto.Node, question: _Question) -> str:
    """The peer's md5sum; "" if it does not answer (other checks report that)."""
    deadline = Deadline(_ONE_QUESTION)
    try:
        if question.name in _SERVICES:
            return probe_service(node, question.name, deadline).get("md5sum", "")
        return probe_topic(node, question.name, question.node, deadline).md5sum
    except (RosError, OSError):
        return ""


_SERVICES = frozenset(row.name for row in interface.services())


# -- the nodes of the chassis: whether each can be reached where it says it is -------------------------------
#
# Each cause is reported once, with all its nodes: a robot that announces an unknown host name has twenty of
# them.

_SHOWN = 5


def chassis_nodes(state: rosproto.node.SystemState) -> list[str]:
    """Nodes that provide something of the chassis's interface."""
    wanted = {row.name for row in interface.ROWS}
    tables = (state.publishers, state.services)
    return sorted({node for table in tables for name in table if name in wanted for node in table[name]})


def check_nodes(
    client: rosproto.MasterClient, state: rosproto.node.SystemState, hosts: HostNames, timeout: float
) -> Iterator[Finding]:
    """One finding for each cause, or one that says that all can be reached."""
    nodes = chassis_nodes(state)
    unknown: dict[str, dict[str, str]] = {}  # host name -> node -> why the master's address does not do
    others: dict[str, list[str]] = {}  # problem -> nodes
    for node in nodes:
        try:
            host, port = parse_uri(client.lookup_node(node))
        except (RosError, ValueError) as error:
            reason = error.text if isinstance(error, MasterError) else error
            untold = say("the master cannot tell where it is: {error}", error=reason)
            others.setdefault(untold, []).append(node)
            continue
        problem = _reach(host, port, hosts, timeout)
        if host in hosts.unknown:
            unknown.setdefault(host, {})[node] = problem
        elif problem:
            others.setdefault(problem, []).append(node)
    for host, found in unknown.items():
        yield unresolved(host, found, hosts)
    for problem, found_nodes in others.items():
        yield bad("node", led(name_list(found_nodes), problem), _RESTART)
    if not others and not any(any(found.values()) for found in unknown.values()):
        yield ok("node", "{count} nodes of the chassis can be reached", count=len(nodes))


_RESTART = "it may have crashed: restart the robot"


def unresolved(host: str, found: dict[str, str], hosts: HostNames) -> Finding:
    """Nodes that announce an unknown host name; `found`: why the master's address does not do."""
    address = hosts.resolve(host)[0]
    text = say(
        "{nodes} announce the host name {host}, which does not resolve here",
        nodes=name_list(found),
        host=host,
    )
    silent = [node for node, problem in found.items() if problem]
    if silent:
        if len(silent) == len(found):
            tried = say(
                "the master's address {address} was tried, and does not answer for them", address=address
            )
        else:
            tried = say(
                "the master's address {address} was tried, and does not answer for {nodes}",
                address=address,
                nodes=name_list(silent),
            )
        text = both(text, tried)
    else:
        used = "the master's address {address} answers for all of them, and is used"
        text = both(text, say(used, address=address))
    level = Level.PROBLEM if silent else Level.WARNING
    return Finding("node", level, text, hosts_advice(host, address, sure=len(silent) < len(found)))


def name_list(nodes: Iterable[str]) -> str:
    """ "/a", or "17 nodes (/a, /b, /c, /d, /e and 12 more)"."""
    names = sorted(nodes)
    if len(names) == 1:
        return names[0]
    if len(names) <= _SHOWN:
        return say("{count} nodes ({names})", count=len(names), names=names)
    more = "{count} nodes ({names} and {more} more)"
    return say(more, count=len(names), names=names[:_SHOWN], more=len(names) - _SHOWN)


def _reach(host: str, port: int, hosts: HostNames, timeout: float) -> str:
    """Why the address does not answer; "" if it does."""
    sock: socket.socket | None = None
    try:
        sock = connect(host, port, Deadline(timeout), hosts=hosts)
    except RosTimeout:
        return say("nothing answers at {host} within {seconds:g} s", host=host, seconds=timeout)
    except ConnectionLost as error:
        refused = isinstance(error.__cause__, ConnectionRefusedError)
        return (
            say("nobody listens on the ports they announce at {host}", host=host) if refused else str(error)
        )
    finally:
        if sock is not None:
            sock.close()
    return ""
