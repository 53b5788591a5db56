"""Recorded traces of the order machine: a seed generates the events of a fleet manager, a chassis and a disk; each event is
recorded with its effects and the changes of the state.

`python -m tests.support.fleet_traces` writes the file of `tests/unit/fleet/order/test_traces.py` anew, after a change that
is meant to change them."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.support.fleet import LIMITS, action, instant, order_json
from woosh_pure.fleet.messages.parsing import Invalid, read_instant_actions, read_order
from woosh_pure.fleet.order import events, first_state, read_state, step
from woosh_pure.fleet.order.errors import Level, Problem
from woosh_pure.fleet.order.vehicle_limits import AgvPosition

__all__ = ["FILE", "SEEDS", "EventSource", "ReplayedMachine", "lines"]

FILE = Path(__file__).resolve().parent.parent / "unit" / "fleet" / "order" / "traces.txt"
SEEDS, EVENTS = range(12), 50
FULL = Problem("storageError", "no space", level=Level.FATAL)
MAPS = ("hall", "hall", "hall", "up")

Event = tuple[Any, ...]


class ReplayedMachine:
    """An order machine that takes events as plain values.

    Attributes:
        asked: The effects of the last event.
    """

    def __init__(self) -> None:
        self.state = first_state(LIMITS)
        self.asked: list[list[Any]] = []

    def apply(self, event: Event) -> None:
        name, *given = event
        if name == "restart":
            self.state = read_state(json.loads(json.dumps(self.state.to_json())), LIMITS)
        self.state, effects = step(self.state, EVENTS_OF[name](*given))
        self.asked = [words(effect, stops=True) for effect in effects.stops]
        self.asked += [["SaveState"]] * effects.saves + [["PublishState"]] * effects.publishes
        self.asked += [words(effect, stops=False) for effect in effects.begins]

    def shown(self) -> dict[str, Any]:
        state = self.state
        kept = state.to_json()
        return {
            "order": f"{state.order_id} {state.update}", "at": f"{state.last_node} {state.last_sequence}",
            "ahead": " ".join(f"{n.id}{n.sequence}{'' if n.released else '?'}" for n in state.nodes),
            "edges": " ".join(f"{e.id}{e.sequence}{'' if e.released else '?'}" for e in state.edges),
            "actions": {a.action.id: f"{a.action.type} {a.status.value}" for a in state.action_states},
            "problems": " ".join(f"{p.kind}:{p.level}" for p in state.problems),
            "waits": " ".join(
                name for name in ("paused", "held", "executing", "wants_base", "at_rest", "waits_for_rest")
                if getattr(state, name)
            ),
            "mode": state.mode, "decision": list(state.decision_point), "motion": state.motion.name,
            "phase": state.phase.name, "disk": [kept[name] for name in ("cancels", "driving", "onEdge")],
        }  # fmt: skip


EVENTS_OF: dict[str, Callable[..., events.Event]] = {
    "order": read_order,
    "instant": lambda *actions: read_instant_actions(instant(*actions)),
    "malformed": lambda: events.MalformedMessage({"headerId": 3}, Invalid("nodes", "a list", "nothing")),
    "position": lambda x, used="hall": events.PositionMeasured(
        None if x is None else AgvPosition(x, 0.0, 0.0, used)
    ),
    "standing": events.StandingMeasured,
    "heard": events.ContactChanged,
    "stopped": events.StopEnded,
    "too fast": lambda: events.DriveTooFast("it was too fast"),
    "drive ended": lambda token, arrived, known: events.DriveEnded(token, arrived, "", known),
    "action ended": lambda name, ok, known: events.ActionEnded(name, ok, "", known),
    "mode": events.ModeChanged,
    "shut down": lambda: events.ShutDown("it was ended"),
    "restart": events.Restarted,
    "retry": events.RetryDue,
    "disk": lambda full: events.DiskFailed(FULL) if full else events.DiskRecovered(),
    "problem": lambda told: events.ProblemChanged("rest", Problem("stillMoving", "") if told else None),
}


def words(effect: Any, *, stops: bool) -> list[Any]:
    """An effect, as plain values; of the end of an action, whether it stops it."""
    name = type(effect).__name__
    if name == "Drive":
        return [name, effect.token, effect.node.id, "" if effect.edge is None else effect.edge.id]
    if name == "BeginAction":
        return [name, effect.action.id]
    if name == "EndAction":
        return [name, effect.action_id, stops]
    return [name, *(getattr(effect, each) for each in effect.__slots__)]


class EventSource:
    """Generates the events of one seed by the effects so far: only what has begun ends.

    Args:
        seed: The random seed.
        machine: The machine that gets the events.
    """

    def __init__(self, seed: int, machine: Any) -> None:
        self.random, self.machine = random.Random(seed), machine
        self.number = 0
        self.x = 0.0
        self.drive: list[Any] | None = None
        self.halting = self.stopping = False
        self.running: list[str] = []
        self.sent: dict[str, Any] | None = None
        self.events: list[Event] = [("mode", "AUTOMATIC"), ("position", 0.0), ("standing", True)]

    def name(self) -> str:
        self.number += 1
        return f"x{self.number}"

    def next(self) -> Event:
        """The next event; call `took` with its effects."""
        while True:
            event = self.events.pop(0) if self.events else self._drawn()
            if event is not None:
                return event

    def took(self, event: Event, asked: list[list[Any]]) -> None:
        """Note the effects of an event."""
        if event[0] == "restart":
            self.drive, self.halting, self.stopping, self.running = None, False, False, []
            self.events = [("mode", "AUTOMATIC"), ("position", self.x)]
        if event[0] == "shut down":
            self.drive, self.running = None, []
            self.events = [("restart",)]
        for name, *given in asked:
            if name == "Drive":
                self.drive, self.halting = given, False
            elif name == "Halt":
                self.halting = True
            elif name == "StopAll":
                self.stopping = True
            elif name == "BeginAction":
                self.running.append(given[0])

    def _drawn(self) -> Event | None:
        draw, shown = self.random, self.machine.shown()
        kind = draw.choices(
            ("drive", "act", "new", "update", "again", "instant", "stand", "moves", "stopped", "lost", "back", "mode",
             "retry", "restart", "end", "disk", "fast", "malformed", "problem", "map"),
            (60, 35, 25, 10, 2, 9, 35, 1, 15, 1, 3, 2, 12, 1, 1, 3, 1, 1, 1, 1),
        )[0]  # fmt: skip
        if kind == "drive":
            return self._of_drive()
        if kind == "act":
            return self._of_action()
        if kind == "new":
            if "executing" in shown["waits"] and draw.random() < 0.9:
                return None
            self.sent = self._order(self.name(), 0, chr(ord("a") + round(self.x / 2.0)), 0)
            return "order", self.sent
        if kind == "update" and self.sent is not None:
            node, sequence = shown["decision"]
            name, update = shown["order"].rsplit(" ", 1)
            self.sent = self._order(
                name, max(0, int(update) + draw.choice((-1, 1, 1, 1))), node or "a", sequence
            )
            return "order", self.sent
        if kind == "again" and self.sent is not None:
            return "order", self.sent
        if kind == "instant":
            return "instant", *(self._instant() for _ in range(draw.choice((1, 1, 1, 2))))
        if kind == "stand" and self.drive is None:
            return "standing", True
        if kind == "stopped" and self.stopping:
            self.stopping = False
            return "stopped", draw.random() < 0.7
        if kind == "lost":
            self.events = [("position", None)]
            return "heard", False
        if kind == "mode" and shown["mode"] == "AUTOMATIC":
            self.events = [self._drawn() or ("retry",), ("mode", "AUTOMATIC")]
            return "mode", "MANUAL"
        if kind == "back":
            self.events = [("position", self.x)]
            return "heard", True
        plain: dict[str, Event] = {
            "moves": ("standing", False), "mode": ("mode", "AUTOMATIC"), "retry": ("retry",), "restart": ("restart",), "end": ("shut down",),
            "disk": ("disk", draw.random() < 0.3), "fast": ("too fast",), "malformed": ("malformed",),
            "problem": ("problem", draw.random() < 0.5), "map": ("position", self.x, draw.choice(MAPS)),
        }  # fmt: skip
        return plain.get(kind)

    def _of_drive(self) -> Event | None:
        if self.drive is None:
            return None
        token, node, _ = self.drive
        place, fate = 2.0 * (ord(node) - ord("a")), self.random.random()
        if fate < 0.25:
            self.x = (self.x + place) / 2.0
            return "position", self.x
        if fate < 0.45:
            self.x = place + 0.4
            return "position", self.x
        self.drive = None
        if self.halting or fate < 0.6:
            return "drive ended", token, False, self.random.random() < 0.7
        self.x = place
        self.events = [("drive ended", token, True, True)]
        return "position", self.x

    def _of_action(self) -> Event | None:
        if not self.running:
            return None
        name = self.random.choice(self.running)
        self.running.remove(name)
        return "action ended", name, self.random.random() < 0.7, self.random.random() < 0.8

    def _instant(self) -> dict[str, Any]:
        draw = self.random
        kind = draw.choice(
            ("cancelOrder", "cancelOrder", "startPause", "stopPause", "stopPause", "stopPause", "stateRequest",
             "factsheetRequest", "beep", "weld", "dock", "unknown")
        )  # fmt: skip
        name = self.name() if draw.random() < 0.9 else f"x{draw.randint(1, self.number or 1)}"
        return action(name, kind, draw.choice(("NONE", "SOFT", "HARD")))

    def _actions(self) -> list[dict[str, Any]]:
        draw = self.random
        return [
            action(
                self.name(),
                draw.choice(("beep", "beep", "weld", "dock", "park")),
                draw.choice(("NONE", "SOFT", "HARD")),
            )
            for _ in range(draw.choice((0, 0, 0, 0, 1, 2)))
        ]

    def _order(self, name: str, update: int, start: str, first: int) -> dict[str, Any]:
        draw = self.random
        way = start + "".join(draw.choice("abcdef") for _ in range(draw.randint(0, 4)))
        deviation = draw.choice((0.0, 0.5, 1.2))
        found = order_json(
            name, update, way, first=first, released=draw.randint(1, len(way)), deviation=deviation
        )
        for element in (*found["nodes"], *found["edges"]):
            element["actions"] = self._actions()
        return found


def brief(event: Event) -> str:
    """An event in a few words; an order by its ids."""
    name, *given = event
    if name == "order":
        data = given[0]
        way = " ".join(
            f"{node['nodeId']}{node['sequenceId']}{'' if node['released'] else '?'}" for node in data["nodes"]
        )
        actions = " ".join(
            f"{a['actionId']}:{a['actionType']}:{a['blockingType']}@{element['sequenceId']}"
            for element in (*data["nodes"], *data["edges"]) for a in element["actions"]
        )  # fmt: skip
        return f"order {data['orderId']} {data['orderUpdateId']}: {way}; {actions}"
    if name == "instant":
        return "instant " + " ".join(f"{a['actionId']}:{a['actionType']}:{a['blockingType']}" for a in given)
    return " ".join((name, *(str(each) for each in given)))


def lines(seed: int, machine: Any, count: int = EVENTS) -> list[str]:
    """The trace of one seed: the event, what it asked for, and what of the machine has changed."""
    source, found = EventSource(seed, machine), [f"seed {seed}"]
    before: dict[str, Any] = {}
    for _ in range(count):
        event = source.next()
        machine.apply(event)
        source.took(event, machine.asked)
        shown = machine.shown()
        changed = {key: value for key, value in shown.items() if before.get(key) != value}
        if "actions" in changed:
            known = before.get("actions", {})
            gone = {name: "" for name in known if name not in shown["actions"]}
            changed["actions"] = {k: v for k, v in shown["actions"].items() if known.get(k) != v} | gone
        found.append(f"{brief(event)} -> {json.dumps(machine.asked)} {json.dumps(changed)}")
        before = shown
    return found


def main() -> None:
    FILE.write_text(
        "\n".join(line for seed in SEEDS for line in lines(seed, ReplayedMachine())) + "\n", "utf-8"
    )


if __name__ == "__main__":
    main()
