"""Identifying the process at a node's previous URI, with odd replies. The only socket is one that refuses."""

from __future__ import annotations

from typing import Any

import pytest

from rosproto.errors import MasterError, RemoteProtocolError
from rosproto.master.notifications import Shutdown
from rosproto.master.slave_calls import Verdict, identify
from rosproto.protocol.wire_limits import Limits
from rosproto.transport import Deadline

OLD = Shutdown(
    "http://10.0.0.1:1/", "/arm", "new node registered", frozenset({"/joints"}), frozenset({"/cmd"})
)


class Process:
    """Answers by method; a method it does not have is a fault."""

    uri = OLD.uri

    def __init__(self, **answers: object) -> None:
        self.answers = answers
        self.asked: list[tuple[str, ...]] = []

    def call(self, method: str, caller_id: str, *params: Any, timeout: float | None = None) -> object:
        self.asked.append((method, *map(str, params[:1])))
        answer = self.answers.get(method, MasterError(method, -1, "unknown method name", uri=self.uri))
        if isinstance(answer, Exception):
            raise answer
        return answer


def verdict(process: Process) -> Verdict:
    return identify(process, OLD, Limits(), Deadline(5.0))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("answer", "expected"),
    [
        ([1, "", "/arm"], Verdict.SAME),
        ([1, "", "arm/"], Verdict.SAME),
        ([1, "", "/leg"], Verdict.OTHER),
        ([1, "", ""], Verdict.SAME),
        ([1, "", 7], Verdict.SAME),
        ([-1, "not yours", ""], Verdict.SAME),
        (RemoteProtocolError("no XML"), Verdict.SAME),
    ],
)
def test_a_name_decides_and_what_is_none_leaves_it_to_the_topics(answer: object, expected: Verdict) -> None:
    process = Process(
        getName=answer,
        getPublications=[1, "", [["/joints", "a/B"]]],
        getSubscriptions=[1, "", [["/cmd", "a/B"]]],
    )
    assert verdict(process) is expected


@pytest.mark.parametrize(
    "rows",
    [
        "nonsense",
        [],
        [1, "", 0],
        [1, "", ["/joints"]],
        [1, "", [[7, "a/B"], [], [["/joints"]]]],
        [0, "not now", [["/joints", "a/B"]]],
        MasterError("getPublications", 1, "broken", uri=OLD.uri),
    ],
)
def test_lists_that_are_none_say_nothing_about_the_node(rows: object) -> None:
    """It does not have the topics of the old one, so it is left alone."""
    assert verdict(Process(getPublications=rows, getSubscriptions=rows)) is not Verdict.SAME


@pytest.mark.parametrize(
    "where",
    [
        [1, "", []],
        [1, "", 0],
        [1, "", ["UDPROS", "h", 1]],
        [1, "", ["TCPROS", "127.0.0.1"]],
        [1, "", ["TCPROS", "127.0.0.1", "many"]],
        [1, "", ["TCPROS", "127.0.0.1", None]],
        [1, "", ["TCPROS", "127.0.0.1", 0]],
        [0, "no supported protocol implementations", 0],
    ],
)
def test_a_publication_that_cannot_be_reached_leaves_the_topics_to_decide(where: list[object]) -> None:
    process = Process(
        getPublications=[1, "", [["/rosout", "rosgraph_msgs/Log"], ["/joints", "a/B"]]],
        getSubscriptions=[1, "", [["/cmd", "a/B"]]],
        requestTopic=where,
    )
    assert verdict(process) is Verdict.SAME
    assert [call for call in process.asked if call[0] == "requestTopic"] == [
        ("requestTopic", "/rosout"),  # first: connecting to it has no side effect on a robot
        ("requestTopic", "/joints"),
    ]
