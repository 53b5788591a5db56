"""One order of N nodes for `tests.benchmarks fleet --only orders`: the order machine, its file and the state messages.

Prints a JSON object: seconds of processor time (also those of the state messages), bytes written to the file, and number and bytes of the state
messages. No broker, no chassis: each drive has ten poses and ends at its node, where A actions run, one after the other.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Any

POSES = 10
SPACING = 2.0  # m
BEFORE = {
    "headerId": 1, "timestamp": "2026-01-01T00:00:00.00Z", "version": "2.1.0", "manufacturer": "W", "serialNumber": "1",
}  # fmt: skip


def order_of(size: int, actions: int) -> dict[str, Any]:
    def of(n: int) -> list[dict[str, Any]]:
        return [
            {"actionId": f"a{n}-{k}", "actionType": "beep", "blockingType": "HARD", "actionParameters": []}
            for k in range(actions)
        ]

    nodes = [
        {"nodeId": f"n{n}", "sequenceId": 2 * n, "released": True, "actions": of(n),
         "nodePosition": {"x": SPACING * n, "y": 0.0, "theta": 0.0, "mapId": "hall"}}
        for n in range(size)
    ]  # fmt: skip
    edges = [
        {"edgeId": f"e{n}", "sequenceId": 2 * n + 1, "released": True, "actions": [],
         "startNodeId": f"n{n}", "endNodeId": f"n{n + 1}"}
        for n in range(size - 1)
    ]  # fmt: skip
    return {**BEFORE, "orderId": "o", "orderUpdateId": 0, "nodes": nodes, "edges": edges}


def writer_of_states(version: str) -> Callable[[Any, Any, dict[str, object]], str]:
    from woosh_pure.fleet import published_messages

    if hasattr(published_messages, "StateMessages"):
        return published_messages.StateMessages(version).text
    return lambda *given: json.dumps(published_messages.state_message(*given, version), separators=(",", ":"))


def written() -> int:
    lines = dict(line.split(": ") for line in Path("/proc/self/io").read_text().splitlines())
    return int(lines["wchar"])


def main(size: int, actions: int) -> None:
    from woosh_pure.fleet import Store
    from woosh_pure.fleet.chassis_facts import ChassisFacts
    from woosh_pure.fleet.messages.parsing import read_order
    from woosh_pure.fleet.order import events
    from woosh_pure.fleet.order.action_states import Scope, SupportedAction
    from woosh_pure.fleet.order.vehicle_limits import AgvPosition, Capabilities
    from woosh_pure.fleet.persistent_order import PersistentOrder

    limits = Capabilities(actions={"beep": SupportedAction("beep", (Scope.NODE,))})
    given = order_of(size, actions)
    state_text = writer_of_states("2.1.0")
    with tempfile.TemporaryDirectory() as folder:
        order = PersistentOrder(limits, Store(Path(folder), "W", "1"), "benchmark")
        standing = events.StandingMeasured(True)
        waiting: deque[Any] = deque(
            [events.ModeChanged("AUTOMATIC"), events.PositionMeasured(AgvPosition(0.0, 0.0, 0.0)), standing]
        )
        messages = message_bytes = count = 0
        told = 0.0
        before, began = written(), time.process_time()
        waiting.append(read_order(given))
        while waiting:
            count += 1
            for effect in order.apply(waiting.popleft()):
                if isinstance(effect, events.PublishState):
                    start = time.process_time()
                    text = state_text(order.state, ChassisFacts(), BEFORE).encode()
                    told += time.process_time() - start
                    messages, message_bytes = messages + 1, message_bytes + len(text)
                elif isinstance(effect, events.Drive):
                    assert effect.node.position is not None
                    end = effect.node.position.x
                    waiting.extend(
                        events.PositionMeasured(AgvPosition(end - SPACING * (POSES - n) / POSES, 0.0, 0.0))
                        for n in range(1, POSES + 1)
                    )
                    waiting += [events.DriveEnded(effect.token, True), standing]
                elif isinstance(effect, events.BeginAction):
                    waiting += [events.ActionEnded(effect.action.id, True), standing]
        seconds = time.process_time() - began
        assert not order.state.executing
        assert order.state.last_node == f"n{size - 1}", order.state.last_node
        found = {
            "seconds": seconds - told, "told": told, "events": count, "written": written() - before, "messages": messages,
            "message_bytes": message_bytes,
        }  # fmt: skip
        print(json.dumps(found))


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
