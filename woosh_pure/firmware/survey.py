"""Reads the definitions of a whole graph: asks each topic and service once, many at the same time.

Only headers are exchanged: no message is received, no service is called, nothing moves.
"""

from __future__ import annotations

import queue
import threading
from collections.abc import Collection
from typing import NamedTuple

import rosproto
from rosproto.errors import RosError
from rosproto.node import probe_service, probe_topic
from rosproto.transport import Deadline

ONE_QUESTION = 3.0  # seconds for one peer


class SurveyAnswer(NamedTuple):
    """A node's answer about its topic or service.

    Attributes:
        kind: "topic" or "service".
        name: Resolved name.
        type: "package/Type"; "" when nobody answered.
        md5sum: Its md5sum.
        definition: Full text; always "" for a service, which does not tell it.
        peer: The node that answered.
        error: Why there is no answer; "" when there is.
    """

    kind: str
    name: str
    type: str = ""
    md5sum: str = ""
    definition: str = ""
    peer: str = ""
    error: str = ""


def survey(
    node: rosproto.Node,
    *,
    timeout: float = 30.0,
    parallel: int = 8,
    kinds: Collection[str] = ("topic", "service"),
) -> list[SurveyAnswer]:
    """Ask every topic that somebody publishes and every service, each once.

    A topic with several publishers is answered by the first that can be reached.

    Args:
        node: In whose name to ask.
        timeout: Seconds for the whole survey; the answers of the rest have an `error`.
        parallel: Most questions at a time.
        kinds: What to ask: "topic", "service", or both.

    Returns:
        Topics, then services, by name.

    Raises:
        ConnectionLost, RosTimeout, MasterError: The master cannot be asked.
    """
    deadline = Deadline(timeout)
    state = node.master.get_system_state(timeout=min(timeout, 10.0))
    questions: queue.SimpleQueue[tuple[str, str, list[str]]] = queue.SimpleQueue()
    for kind, table in (("topic", state.publishers), ("service", state.services)):
        for name, peers in table.items() if kind in kinds else ():
            others = [peer for peer in peers if peer != node.name]
            if others:
                questions.put((kind, name, others))
    answers: list[SurveyAnswer] = []

    def work() -> None:
        while True:
            try:
                kind, name, peers = questions.get_nowait()
            except queue.Empty:
                return
            ask = _ask_topic if kind == "topic" else _ask_service
            answers.append(ask(node, name, peers, deadline))

    workers = [
        threading.Thread(target=work, name=f"woosh:survey {i}", daemon=True) for i in range(max(1, parallel))
    ]
    for worker in workers:
        worker.start()
    for worker in workers:
        while worker.is_alive():
            worker.join(0.1)  # in slices: on Windows a join cannot be interrupted by Ctrl-C
    return sorted(answers, key=lambda answer: (answer.kind != "topic", answer.name))


def _ask_topic(node: rosproto.Node, name: str, peers: list[str], deadline: Deadline) -> SurveyAnswer:
    error = "not asked: the time was up"
    for peer in peers:
        if deadline.expired:
            break
        try:
            reply = probe_topic(node, name, peer, deadline.at_most(ONE_QUESTION))
        except (RosError, OSError) as problem:
            error = str(problem)
            continue
        return SurveyAnswer("topic", name, reply.type_name, reply.md5sum, reply.message_definition, peer)
    return SurveyAnswer("topic", name, peer=peers[0], error=error)


def _ask_service(node: rosproto.Node, name: str, peers: list[str], deadline: Deadline) -> SurveyAnswer:
    if deadline.expired:
        return SurveyAnswer("service", name, peer=peers[0], error="not asked: the time was up")
    try:
        header = probe_service(node, name, deadline.at_most(ONE_QUESTION))
    except (RosError, OSError) as problem:
        return SurveyAnswer("service", name, peer=peers[0], error=str(problem))
    return SurveyAnswer("service", name, header.get("type", ""), header.get("md5sum", ""), "", peers[0])
