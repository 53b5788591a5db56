"""A small fleet manager for tests: sends given messages, and keeps received ones."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any

import pytest

__all__ = ["Master", "came_back", "errors", "order_over", "statuses"]

PLACES = {"n1": (0.0, 0.0), "n2": (1.0, -0.5), "n3": (3.0, 1.0)}


def order_over(
    name: str, way: str, *, update: int = 0, first: int = 0, released: int = 99, actions: dict[str, Any] | None = None,
    edge: dict[str, Any] | None = None,
) -> dict[str, Any]:  # fmt: skip
    """An order over places of the simulated hall."""
    found: dict[str, Any] = {
        "headerId": 1, "timestamp": "2026-01-01T00:00:00.00Z", "version": "2.1.0", "manufacturer": "Woosh",
        "serialNumber": "A-17", "orderId": name, "orderUpdateId": update, "nodes": [], "edges": [],
    }  # fmt: skip
    names = way.split()
    for n, each in enumerate(names):
        x, y = PLACES[each]
        found["nodes"].append(
            {
                "nodeId": each, "sequenceId": first + 2 * n, "released": n < released,
                "nodePosition": {"x": x, "y": y, "mapId": "hall", "allowedDeviationXY": 0.3},
                "actions": (actions or {}).get(each, []),
            }
        )  # fmt: skip
        if n:
            found["edges"].append(
                {
                    "edgeId": names[n - 1] + each, "sequenceId": first + 2 * n - 1, "released": n < released,
                    "startNodeId": names[n - 1], "endNodeId": each, "actions": [], **(edge or {}),
                }
            )  # fmt: skip
    return found


class Master:
    """Connected with a broker; use it in a `with` block."""

    def __init__(self, port: int, prefix: str = "uagv/v2/Woosh/A-17") -> None:
        mqtt = pytest.importorskip("paho.mqtt.client", reason="paho-mqtt is not installed")
        self.prefix, self.port = prefix, port
        self.heard: list[tuple[float, str, dict[str, Any], bool]] = []
        self._changed = threading.Condition()
        self.client = mqtt.Client(mqtt.CallbackAPIVersion.VERSION2)
        self.client.on_connect = lambda client, *_: client.subscribe(f"{prefix}/#", 1)
        self.client.on_message = self._on_message
        self.client.reconnect_delay_set(1, 1)

    def __enter__(self) -> Master:
        self.client.connect("127.0.0.1", self.port)
        self.client.loop_start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.client.disconnect()
        self.client.loop_stop()

    def _on_message(self, client: Any, data: Any, message: Any) -> None:
        topic = message.topic.rpartition("/")[2]
        if topic in ("order", "instantActions"):
            return
        with self._changed:
            self.heard.append((time.monotonic(), topic, json.loads(message.payload), message.retain))
            self._changed.notify_all()

    def send(self, topic: str, data: Any, *, retain: bool = False) -> None:
        """Publish bytes as they are, and an object with the names of the vehicle that its topic has."""
        if isinstance(data, dict):
            _, _, manufacturer, serial = self.prefix.split("/")
            data = {**data, "manufacturer": manufacturer, "serialNumber": serial}
        payload = data if isinstance(data, (bytes, str)) else json.dumps(data)
        self.client.publish(f"{self.prefix}/{topic}", payload, retain=retain)

    def instant(self, name: str, kind: str, **parameters: Any) -> None:
        given = [{"key": key, "value": value} for key, value in parameters.items()]
        order = order_over("", "n1")
        action = {"actionId": name, "actionType": kind, "blockingType": "NONE", "actionParameters": given}
        header = {
            key: order[key] for key in ("headerId", "timestamp", "version", "manufacturer", "serialNumber")
        }
        self.send("instantActions", {**header, "actions": [action]})

    def all(self, topic: str = "state") -> list[dict[str, Any]]:
        with self._changed:
            return [each for _, name, each, _ in self.heard if name == topic]

    def until(
        self, accept: Callable[[dict[str, Any]], bool], seconds: float = 20.0, *, topic: str = "state", after: float = 0.0
    ) -> dict[str, Any]:  # fmt: skip
        """Return the newest message of a topic, as soon as it fulfils the condition."""
        deadline = time.monotonic() + seconds
        with self._changed:
            while True:
                found = [each for at, name, each, _ in self.heard if name == topic and at >= after]
                if found and accept(found[-1]):
                    return found[-1]
                left = deadline - time.monotonic()
                assert left > 0.0, f"not within {seconds} s; the last: {found[-1:]}"
                self._changed.wait(left)


def came_back(master: Master) -> bool:
    """Whether the broker has reported the vehicle's lost connection, and the vehicle its return."""
    told = [message["connectionState"] for message in master.all("connection")]
    return told[-2:] == ["CONNECTIONBROKEN", "ONLINE"]


def errors(state: dict[str, Any]) -> list[str]:
    return [error["errorType"] for error in state["errors"]]


def statuses(state: dict[str, Any]) -> dict[str, str]:
    return {each["actionId"]: each["actionStatus"] for each in state["actionStates"]}
