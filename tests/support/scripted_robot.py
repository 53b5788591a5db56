"""A robot of the Robot API by script: it answers over WebSocket, late, refusing or not at all, as a test wants."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Mapping
from types import TracebackType
from typing import Any

from websockets.exceptions import ConnectionClosed
from websockets.sync.server import ServerConnection, serve

from woosh_pure.robot_api import wire

__all__ = ["ScriptedRobot"]

ROBOT = "woosh.robot."
STANDING = {"twist": {"linear": 0, "angular": 0}, "pose": {"x": 1.0, "y": 2.0, "theta": 0.5}, "mileage": 42}
INFO = {
    "state": 2,
    "mode": {"ctrl": 1, "work": 2},
    "poseSpeed": STANDING,
    "battery": {"chargeState": 1, "power": 83, "tempMax": 27},
    "genral": {"version": {"system": "S1", "rc": "1.1.71"}, "driverMethod": 2},
    "deviceState": {"hardware": 0, "software": 1},
    "operationState": {"robot": 1},
    "taskProc": {"robotTaskId": "7", "state": 7},
    "abnormalCodes": {"scs": []},
}
Answer = Callable[[Mapping[str, Any]], "dict[str, Any] | str | None"]
"""Of the body of a request: the body of the answer, a text that refuses, or None for silence."""


class ScriptedRobot:
    """Listens on 127.0.0.1 until the end of its `with` block.

    Attributes:
        answers: By the last word of a type; what is not in it is accepted with an empty body.
        asked: (time, last word of the type, body) of each request.
        topics: What is subscribed.
        silent: While it is set, nothing is answered.
    """

    def __init__(self) -> None:
        self.answers: dict[str, Answer] = {"RobotInfo": lambda _: INFO, "PoseSpeed": lambda _: STANDING}
        self.asked: list[tuple[float, str, dict[str, Any]]] = []
        self.topics: set[str] = set()
        self.silent = threading.Event()
        self.connected = 0
        self._peers: set[ServerConnection] = set()
        self._server = serve(self._talk, "127.0.0.1", 0, compression=None)
        self.port = int(self._server.socket.getsockname()[1])
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)
        self._thread.start()

    @property
    def url(self) -> str:
        return f"ws://127.0.0.1:{self.port}"

    def __enter__(self) -> ScriptedRobot:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._server.shutdown()
        self.drop()
        self._thread.join(5.0)

    def drop(self) -> None:
        """End the connections."""
        for peer in list(self._peers):
            peer.close()

    def of(self, word: str) -> list[dict[str, Any]]:
        """The bodies of the requests of a type."""
        return [body for _, name, body in self.asked if name == word]

    def push(self, word: str, body: Mapping[str, Any]) -> None:
        """Push to all who are connected."""
        name = word if word.startswith("woosh.") else ROBOT + word
        for peer in list(self._peers):
            peer.send(json.dumps({"type": name, "body": body}))

    def _talk(self, peer: ServerConnection) -> None:
        self._peers.add(peer)
        self.connected += 1
        try:
            for text in peer:
                self._answer(peer, json.loads(text))
        except ConnectionClosed:
            pass
        finally:
            self._peers.discard(peer)

    def _answer(self, peer: ServerConnection, frame: dict[str, Any]) -> None:
        name, body = frame["type"], frame.get("body", {})
        if name == wire.SUBSCRIPTION:
            change = self.topics.update if body["sub"] else self.topics.difference_update
            change(body["topics"])
            return
        word = name.rpartition(".")[2]
        self.asked.append((time.monotonic(), word, body))
        made = self.answers.get(word, lambda _: {})(body)
        if made is None or self.silent.is_set():
            return
        ok, said = not isinstance(made, str), made if isinstance(made, str) else ""
        known = wire.requests().get(name)
        answer = {"type": known.answer if known else name, "body": made if ok else {}, "ok": ok, "msg": said}
        peer.send(json.dumps({**answer, "sn": frame["sn"]}))
