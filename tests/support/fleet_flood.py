"""A program that floods a vehicle with stateRequests, and cancels its order: one of its own, so that what it costs is
not the vehicle's. Prints the time of this computer's monotonic clock at which the broker had the cancel."""

from __future__ import annotations

import json
import sys
import time
from typing import Any

import paho.mqtt.client as mqtt


def message(prefix: str, name: str, kind: str) -> str:
    """Instant actions with one of a kind."""
    _, _, manufacturer, serial = prefix.split("/")
    action: dict[str, Any] = {
        "actionId": name,
        "actionType": kind,
        "blockingType": "NONE",
        "actionParameters": [],
    }
    header = {"headerId": 1, "timestamp": "2026-01-01T00:00:00.00Z", "version": "2.1.0"}
    return json.dumps({**header, "manufacturer": manufacturer, "serialNumber": serial, "actions": [action]})


def main(port: int, prefix: str, requests: int, rate: float) -> None:
    client = mqtt.Client(mqtt.CallbackAPIVersion.VERSION2)
    client.connect("127.0.0.1", port)
    client.loop_start()
    topic = f"{prefix}/instantActions"
    began = time.monotonic()
    for n in range(requests):
        info = client.publish(topic, message(prefix, f"s{n}", "stateRequest"))
        if rate:
            time.sleep(max(0.0, began + (n + 1) / rate - time.monotonic()))
            if n == requests // 2:
                info = client.publish(topic, message(prefix, "stop", "cancelOrder"))
                info.wait_for_publish(30.0)
                print(time.monotonic(), flush=True)
    if not rate:
        info = client.publish(topic, message(prefix, "stop", "cancelOrder"))
        info.wait_for_publish(30.0)
        print(time.monotonic(), flush=True)
    info.wait_for_publish(30.0)
    client.disconnect()
    client.loop_stop()


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2], int(sys.argv[3]), float(sys.argv[4]))
