"""A command that is interrupted while it calls the master leaves nothing registered there, at whichever call it is.

The signal is raised in the main thread, where Python handles signals: before a request is sent, when it has been sent, and when
its answer has come but is not read yet. Every call of the command is interrupted in turn, those of its end too.
"""

from __future__ import annotations

import itertools
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from msgdefs.std_msgs.msg import String
from rosproto import BagWriter, Master, Node
from rosproto.node.graph.master_client import MasterClient
from rosproto.protocol.http import HttpClientConnection
from rosproto.time import Time
from tests.support.options import run

COMMANDS = [
    "bag play {bag} --immediate --delay 0 --quiet --clock",
    "bag record /words --duration 0.1 --quiet -O {folder}/r.bag",
    "topic echo /words -n 1",
    "topic pub --rate 1000 -n 1 /said std_msgs/String hello",
]
MOMENTS = {"not sent": "encode_request", "sent": "next_event", "answered": "receive"}


class Interrupter:
    """Raises a signal at one call of the master by the main thread.

    Attributes:
        left: Calls to let pass; below zero after the one that was interrupted.
    """

    def __init__(self, monkeypatch: pytest.MonkeyPatch, method: str, number: int) -> None:
        self._number, self._asked = number, False
        self.left = -1
        original = {
            name: getattr(HttpClientConnection, name) for name in ("encode_request", "next_event", "receive")
        }

        def watched(name: str) -> Callable[..., Any]:
            def call(connection: HttpClientConnection, *arguments: Any) -> Any:
                if threading.current_thread() is threading.main_thread():
                    if name == "encode_request":
                        self._asked = True
                    if name == method and self._asked:  # once for each call
                        self._asked = False
                        self._count()
                return original[name](connection, *arguments)

            return call

        for name in original:
            monkeypatch.setattr(HttpClientConnection, name, watched(name))

    def _count(self) -> None:
        self.left -= 1
        if self.left == -1:
            signal.raise_signal(self._number)


@pytest.fixture(scope="module")
def graph() -> Iterator[Master]:
    """A master; a latched topic and a subscriber."""
    with (
        Master(host="127.0.0.1", port=0) as master,
        Node("/there", master_uri=master.uri, host="127.0.0.1", rosout=False) as node,
    ):
        node.publisher("/words", "std_msgs/String", latch=True).publish(data="word")
        node.subscriber("/said", "std_msgs/String")
        yield master


@pytest.mark.skipif(sys.platform == "win32", reason="SIGTERM ends a process of Windows at once")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=lambda number: number.name)
@pytest.mark.parametrize("moment", MOMENTS)
@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: " ".join(command.split()[:2]))
def test_nothing_stays_registered(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, graph: Master, command: str, moment: str, number: int
) -> None:
    """Whichever call of the command it is."""
    with BagWriter(tmp_path / "a.bag") as bag:
        bag.write("/t", String(data="t"), Time(10))
        bag.write("/u", String(data="u"), Time(10))
    words = command.format(bag=tmp_path / "a.bag", folder=tmp_path).split()
    interrupter = Interrupter(monkeypatch, MOMENTS[moment], number)
    left = {}
    with MasterClient(graph.uri, "/tool") as master:
        known = {*master.get_system_state().nodes}
        for calls in itertools.count():
            interrupter.left = calls
            result = run("rosproto", [*words, "--master", graph.uri])
            if interrupter.left >= 0:
                break  # it makes no more calls
            interrupter.left = -1
            if nodes := {*master.get_system_state().nodes} - known:
                known |= nodes
                left[calls] = (nodes, result)
    assert (result.code, calls > 0, left) == (0, True, {}), result
