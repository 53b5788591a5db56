"""What a node asks its master at the start, in one request, and of masters that know no multicall one by one."""

from __future__ import annotations

from typing import Any

import pytest

from rosproto.errors import ConnectionLost, MasterError, RemoteProtocolError
from rosproto.node import MasterClient
from rosproto.node.parts import GraphSettings, ask_settings

URI = "http://127.0.0.1:11311/"
UNSET: list[object] = [-1, "Parameter is not set", 0]


class Answers:
    """In place of an XML-RPC client: what a master answers, and what it was asked."""

    def __init__(self, answers: dict[str, list[object]], *, multicall: bool = True) -> None:
        self.uri = URI
        self.asked: list[str] = []
        self._answers = answers
        self._multicall = multicall

    def call(self, method: str, *params: Any, timeout: float | None = None, last: Any = None) -> object:
        self.asked.append(method)
        if method != "system.multicall":
            return self._answers[params[1] if method == "getParam" else method]
        if not self._multicall:
            raise MasterError(method, -1, "no such method", uri=URI)
        return [
            [self._answers[c["params"][1] if c["methodName"] == "getParam" else c["methodName"]]]
            for c in params[0]
        ]


def master(
    *, multicall: bool = True, pid: list[object] | None = None, **params: object
) -> tuple[MasterClient, Answers]:
    answers: dict[str, list[object]] = {
        "getPid": pid or [1, "", 4711],
        "/use_sim_time": UNSET,
        "/rosout_disable_topics_generation": UNSET,
    }
    answers.update({f"/{key}": [1, "", value] for key, value in params.items()})
    client = Answers(answers, multicall=multicall)
    return MasterClient(URI, "/n", client=client), client  # type: ignore[arg-type]


@pytest.mark.parametrize("multicall", [True, False])
@pytest.mark.parametrize(
    ("params", "settings"),
    [
        ({}, GraphSettings(simulated=False, rosout_topics=True)),
        ({"use_sim_time": True}, GraphSettings(simulated=True, rosout_topics=True)),
        ({"use_sim_time": "true"}, GraphSettings(simulated=False, rosout_topics=True)),
        ({"rosout_disable_topics_generation": True}, GraphSettings(simulated=False, rosout_topics=False)),
        ({"rosout_disable_topics_generation": False}, GraphSettings(simulated=False, rosout_topics=True)),
    ],
)
def test_the_settings_of_the_graph(
    params: dict[str, object], settings: GraphSettings, multicall: bool
) -> None:
    client, asked = master(multicall=multicall, **params)
    assert ask_settings(client, 5.0) == settings
    singly = ["getPid", "getParam", "getParam"]
    assert asked.asked == ["system.multicall", *([] if multicall else singly)]


def test_what_is_no_master_is_refused() -> None:
    for pid, error in (([0, "no", 0], MasterError), ([1, "", "many"], RemoteProtocolError)):
        with pytest.raises(error, match="getPid"):
            ask_settings(master(pid=pid)[0], 5.0)


def test_a_master_that_is_away_is_not_asked_again() -> None:
    """Only an answer says that multicall is missing."""
    client, asked = master()

    def lost(method: str, *params: object, timeout: float | None = None) -> object:
        asked.asked.append(method)
        raise ConnectionLost("gone", peer=URI)

    asked.call = lost  # type: ignore[method-assign]
    with pytest.raises(ConnectionLost):
        ask_settings(client, 5.0)
    assert asked.asked == ["system.multicall"]
