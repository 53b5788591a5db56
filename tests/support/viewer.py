"""A plain client of the Foxglove WebSocket protocol by its published specification, for tests."""

from __future__ import annotations

import json
import struct
import time
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

from tests.support.websocket import connect

__all__ = ["Viewer"]

SECONDS = 10.0


class Viewer:
    """One connection; a wait that times out reports the received messages.

    Attributes:
        channels: Topic -> its currently advertised channel.
        services: Name -> its currently advertised service.
        came: All other received messages not yet consumed: documents, and tuples for binary messages.
    """

    def __init__(self, url: str, protocol: str = "foxglove.sdk.v1", **options: Any) -> None:
        self._stack = ExitStack()
        connection = connect(url, subprotocols=[protocol], max_size=None, **options)
        self.socket: Any = self._stack.enter_context(connection)
        self.channels: dict[str, dict[str, Any]] = {}
        self.services: dict[str, dict[str, Any]] = {}
        self.came: list[Any] = []
        self._next = 0
        self._topics: dict[int, str] = {}
        self._subscriptions: dict[str, int] = {}
        self.info = self.wait(lambda one: isinstance(one, dict) and one["op"] == "serverInfo")

    # -- receiving ------------------------------------------------------------------------------------------

    def wait(self, wanted: Callable[[Any], bool], seconds: float = SECONDS) -> Any:
        """The first received or future message that satisfies `wanted`."""
        end = time.monotonic() + seconds
        while True:
            for place, one in enumerate(self.came):
                if wanted(one):
                    return self.came.pop(place)
            self._read(end)

    def until(self, condition: Callable[[], bool], seconds: float = SECONDS) -> None:
        """Read until the condition holds."""
        end = time.monotonic() + seconds
        while not condition():
            self._read(end)

    def _read(self, end: float) -> None:
        left = end - time.monotonic()
        try:
            data = self.socket.recv(timeout=max(0.0, left))
        except TimeoutError:
            raise AssertionError(f"it did not come; what did: {str(self.came)[:2000]}") from None
        if isinstance(data, bytes):
            self.came.append(self._binary(data))
            return
        one = json.loads(data)
        if one["op"] == "advertise":
            self.channels.update({channel["topic"]: channel for channel in one["channels"]})
        elif one["op"] == "unadvertise":
            gone = set(one["channelIds"])
            self.channels = {t: c for t, c in self.channels.items() if c["id"] not in gone}
        elif one["op"] == "advertiseServices":
            self.services.update({service["name"]: service for service in one["services"]})
        elif one["op"] == "unadvertiseServices":
            gone = set(one["serviceIds"])
            self.services = {n: s for n, s in self.services.items() if s["id"] not in gone}
        self.came.append(one)

    def _binary(self, data: bytes) -> tuple[Any, ...]:
        if data[0] == 1:
            number, stamp = struct.unpack_from("<IQ", data, 1)
            return "message", self._topics.get(number, ""), data[13:], stamp
        if data[0] == 2:
            return "time", struct.unpack_from("<Q", data, 1)[0]
        if data[0] == 3:
            _, call, length = struct.unpack_from("<III", data, 1)
            return "response", call, data[13 + length :]
        if data[0] == 4:
            request, status, length = struct.unpack_from("<IBI", data, 1)
            text = data[10 : 10 + length].decode()
            return "asset", request, status, text, data[10 + length :]
        return "unknown", data

    def message(self, topic: str, seconds: float = SECONDS) -> bytes:
        """The next message of a topic."""
        data: bytes = self.wait(
            lambda one: isinstance(one, tuple) and one[:2] == ("message", topic), seconds
        )[2]
        return data

    def document(self, op: str, seconds: float = SECONDS, **fields: Any) -> dict[str, Any]:
        """The next document with that `op` and those fields."""

        def fits(one: Any) -> bool:
            return (
                isinstance(one, dict)
                and one["op"] == op
                and all(one.get(name) == value for name, value in fields.items())
            )

        found: dict[str, Any] = self.wait(fits, seconds)
        return found

    def status(self, *words: str, seconds: float = SECONDS) -> str:
        """The text of the next status that contains all `words`."""
        found: dict[str, Any] = self.wait(
            lambda one: (
                isinstance(one, dict) and one["op"] == "status" and all(w in one["message"] for w in words)
            ),
            seconds,
        )
        return str(found["message"])

    # -- sending --------------------------------------------------------------------------------------------

    def send(self, op: str, **fields: Any) -> None:
        self.socket.send(json.dumps({"op": op, **fields}))

    def offered(self, topic: str) -> dict[str, Any]:
        """Wait for the channel of a topic."""
        self.until(lambda: topic in self.channels)
        return self.channels[topic]

    def subscribe(self, topic: str) -> None:
        channel = self.offered(topic)
        self._next += 1
        self._topics[self._next] = topic
        self._subscriptions[topic] = self._next
        self.send("subscribe", subscriptions=[{"id": self._next, "channelId": channel["id"]}])

    def unsubscribe(self, topic: str) -> None:
        self.send("unsubscribe", subscriptionIds=[self._subscriptions.pop(topic)])

    def advertise(self, topic: str, kind: str, schema: str = "", encoding: str = "ros1") -> int:
        self._next += 1
        more = {"schema": schema, "schemaEncoding": "ros1msg"} if schema else {}
        channel = {"id": self._next, "topic": topic, "encoding": encoding, "schemaName": kind, **more}
        self.send("advertise", channels=[channel])
        return self._next

    def publish(self, channel: int, data: bytes) -> None:
        self.socket.send(b"\x01" + struct.pack("<I", channel) + data)

    def call(self, service: str, data: bytes, call: int = 1) -> None:
        self.until(lambda: service in self.services)
        number = self.services[service]["id"]
        self.socket.send(b"\x02" + struct.pack("<III", number, call, 4) + b"ros1" + data)

    def close(self) -> None:
        self._stack.close()

    def __enter__(self) -> Viewer:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()
