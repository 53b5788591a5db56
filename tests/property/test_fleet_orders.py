"""Random orders with updates, cancels, pauses, losses of messages, of the robot's position and of our own process: what
must hold always holds, and in the end master and vehicle agree."""

from __future__ import annotations

import random
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.fleet import PureVehicle, action, order_json
from woosh_pure.fleet.chassis_facts import ChassisFacts
from woosh_pure.fleet.messages.parsing import read_order
from woosh_pure.fleet.order.events import (
    BeginAction,
    ContactChanged,
    Drive,
    Effect,
    EndAction,
    Event,
    Halt,
    ModeChanged,
    PositionMeasured,
    PublishState,
    RetryDue,
    ShutDown,
    StandingMeasured,
    StopEnded,
    StoppedByOthers,
)
from woosh_pure.fleet.order.state import OrderState
from woosh_pure.fleet.order.tables import Motion
from woosh_pure.fleet.published_messages import StateMessages

TYPES = ("beep", "weld", "dock", "park")
BLOCKING = ("NONE", "SOFT", "HARD")


class Watched(PureVehicle):
    """A vehicle that checks each effect as it is given out.

    Attributes:
        running: Ids of the actions that run in the world, by their blocking type.
    """

    def __init__(self, **given: Any) -> None:
        self.running: dict[str, str] = {}
        self.to_end: set[str] = set()
        self.ever: set[str] = set()
        self.done: set[str] = set()
        self.messages = StateMessages("2.1.0")
        super().__init__(**given, obeys=False)

    def apply(self, event: Event) -> None:
        self.halted = 0
        super().apply(event)
        drive = self.state.drive
        if drive is not None and drive.token == self.halted:
            assert self.state.motion is Motion.HALTING, "halted before the disk was full, and forgotten"
        for each in self.state.action_states:
            name = each.action.id
            if (
                each.action.type in ("cancelOrder", "startPause")
                and each.status.value == "FINISHED"
                and name not in self.done
            ):
                self.done.add(name)
                assert self.state.standing, f"{name} is FINISHED, and the vehicle was not measured standing"
                assert self.drive is None

    def take(self, effect: Effect) -> None:
        before = self.drive
        super().take(effect)
        state, kept = self.state, self.disk.kept
        if isinstance(effect, BeginAction):
            name = effect.action.id
            assert name not in self.ever, f"{name} began twice"
            self.ever.add(name)
            assert kept is not None
            assert not self.disk.full, "begun without a disk"
            assert any(r["action"]["actionId"] == name and r["status"] != "WAITING" for r in kept["records"])
            record = next(r for r in state.action_states if r.action.id == name)
            assert not (record.of_order and state.held), "of an order that is held"
            assert "HARD" not in self.running.values(), "beside a HARD action"
            if record.blocking == "HARD":
                assert not self.running, f"a HARD action beside {self.running}"
            if record.blocking != "NONE":
                assert before is None, "an action that blocks while it drives"
                assert self.measured, "an action that blocks before it was measured standing"
            if state.moves(record):
                self.measured = False
            self.running[name] = record.blocking
        elif isinstance(effect, Drive):
            assert effect.node.released
            assert effect.node is state.nodes[0]
            assert set(self.running.values()) <= {"NONE"}, f"drives beside {self.running}"
            assert kept is not None
            assert kept["driving"], "driven without a disk"
            assert not self.disk.full or kept == state.to_json(), "driven without a disk"
            assert not state.paused
            assert not state.held
            assert state.mode == "AUTOMATIC"
            assert state.position is not None
            assert state.motion is Motion.DRIVING
            self.measured = False
        elif isinstance(effect, EndAction):
            self.to_end.add(effect.action_id)
        elif isinstance(effect, PublishState):
            given = (state, ChassisFacts(), {})
            fresh = StateMessages("2.1.0").text(*given)
            assert self.messages.text(*given) == fresh, "the state message has what was in an earlier one"
            failing = self.disk.full or self.order_machine.failing
            assert failing or kept in (None, state.to_json()), "published, and not saved"
        elif isinstance(effect, Halt):
            assert before is not None, "nothing to halt"
            self.halted = effect.token

    halted = 0
    measured = False
    """Measured standing after the last end of what moves it."""

    def stand(self) -> None:
        """What the world tells after a while: the stop has ended, the robot stands."""
        if self.drive is None and not any(kind == "HARD" for kind in self.running.values()):
            if self.state.motion is Motion.STOPPING:
                self.apply(StopEnded(True))
            self.measured = True
            self.apply(StandingMeasured(True))

    def stop(self, *, known: bool = True) -> None:
        self.measured = False
        super().stop(known=known)

    def finish(self, action_id: str, ok: bool = True, text: str = "") -> None:
        if any(each.action.id == action_id and self.state.moves(each) for each in self.state.action_states):
            self.measured = False
        self.running.pop(action_id, None)
        self.to_end.discard(action_id)
        super().finish(action_id, ok, text)


class World:
    """A master that plans, a line that loses, a vehicle that may die."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.vehicle = Watched()
        self.number = 0
        self.sent: dict[str, Any] | None = None  # the master's newest order or update

    def name(self) -> str:
        self.number += 1
        return f"x{self.number}"

    def actions(self) -> list[dict[str, Any]]:
        return [
            action(self.name(), self.random.choice(TYPES), self.random.choice(BLOCKING))
            for _ in range(self.random.choice((0, 0, 1, 2)))
        ]

    def send(self, data: dict[str, Any]) -> None:
        for _ in range(self.random.choice((0, 1, 1, 1, 2))):
            self.vehicle.apply(read_order(data))

    def new_order(self) -> None:
        here = self.vehicle.state.position
        start = "a" if here is None else chr(ord("a") + round(here.x / 2.0))
        self.order(self.name(), 0, start, 0)

    def order(self, name: str, update: int, start: str, first: int) -> None:
        way = start + "".join(self.random.choice("abcdef") for _ in range(self.random.randint(0, 4)))
        released = self.random.randint(1, len(way))
        self.sent = order_json(
            name, update, way, first=first, released=released, deviation=self.random.choice((0.0, 0.5, 1.2)),
            node_actions={}, edge_actions={},
        )  # fmt: skip
        for element in (*self.sent["nodes"], *self.sent["edges"]):
            element["actions"] = self.actions()
        self.send(self.sent)

    def update(self) -> None:
        machine = self.vehicle.state
        if self.sent is None or machine.order_id != self.sent["orderId"]:
            return
        node, sequence = machine.decision_point
        self.order(machine.order_id, max(machine.update, self.sent["orderUpdateId"]) + 1, node, sequence)

    def instant(self, kind: str, blocking: str = "NONE") -> None:
        if self.random.random() < 0.8:
            self.vehicle.instant(action(self.name(), kind, blocking))

    def maps(self) -> None:
        """enableMap of the map that orders are for is refused beside an order, of another one it is done."""
        machine, name = self.vehicle.state, self.name()
        wanted, executing = self.random.choice(("hall", "up")), machine.executing
        self.vehicle.instant(action(name, "enableMap", mapId=wanted, mapVersion="2"))
        if executing and wanted == "hall":
            assert self.vehicle.status(name) == "FAILED"
            assert name not in self.vehicle.ever

    def drive(self) -> None:
        vehicle = self.vehicle
        if vehicle.drive is None:
            return
        fate = self.random.random()
        position = vehicle.drive.node.position
        assert position is not None
        if vehicle.halting or fate < 0.1:
            vehicle.stop(known=self.random.random() < 0.7)
        elif fate < 0.3 and vehicle.state.position is not None:
            vehicle.place((vehicle.state.position.x + position.x) / 2.0)
        elif fate < 0.45:
            vehicle.place(position.x + 0.4)
        else:
            vehicle.arrive()

    def act(self) -> None:
        vehicle = self.vehicle
        ended = sorted(vehicle.to_end)
        names = ended or sorted(vehicle.running)
        if names:
            vehicle.finish(self.random.choice(names), not ended and self.random.random() < 0.8)

    def die(self) -> None:
        """kill -9, and another process with what was on disk; what it ran is gone with it."""
        old = self.vehicle
        place, mode = old.state.position, old.state.mode
        new = Watched.__new__(Watched)
        new.running, new.to_end, new.ever, new.done = {}, set(), old.ever, old.done
        new.messages = StateMessages("2.1.0")
        PureVehicle.__init__(new, kept=old.disk.kept, x=0.0 if place is None else place.x, obeys=False)
        if not old.disk.full:  # or else it is back where it was when there was room
            last = (old.visited or [None])[-1]
            new.visited = old.visited + [each for each in new.visited if each != last]
        self.vehicle = new
        if mode != "AUTOMATIC":
            new.apply(ModeChanged(mode))

    def end(self) -> None:
        """SIGTERM, and another process."""
        self.vehicle.apply(ShutDown("it was ended"))
        assert not self.vehicle.state.executing
        full = self.vehicle.disk.full
        self.die()
        assert full or not self.vehicle.state.held

    def step(self) -> None:
        vehicle = self.vehicle
        kind = self.random.choices(
            ("drive", "act", "new", "update", "again", "cancel", "pause", "resume", "beep", "lost", "mode", "die", "retry", "end", "maps", "stand", "moves", "back",
             "full", "room", "stopped"),
            (30, 20, 10, 12, 5, 4, 3, 6, 4, 2, 1, 2, 6, 1, 2, 25, 3, 4, 2, 5, 2),
        )[0]  # fmt: skip
        if kind == "drive":
            self.drive()
        elif kind == "act":
            self.act()
        elif kind == "new":
            if not vehicle.state.executing:
                self.new_order()
            else:
                before = vehicle.state.order_id
                self.send(order_json("intruder", 0, "ab"))
                assert vehicle.state.order_id == before
        elif kind == "update":
            self.update()
        elif kind == "again" and self.sent is not None:
            self.send(self.sent)
        elif kind == "cancel":
            self.instant("cancelOrder")
        elif kind == "pause":
            self.instant("startPause")
        elif kind == "resume":
            self.instant("stopPause")
        elif kind == "beep":
            self.instant("beep", self.random.choice(BLOCKING))
        elif kind == "lost":
            vehicle.measured = False
            vehicle.apply(ContactChanged(False))
            vehicle.apply(PositionMeasured(None))
        elif kind == "back":
            vehicle.measured = False
            vehicle.apply(ContactChanged(True))
        elif kind == "stand" and vehicle.state.heard:
            vehicle.stand()
        elif kind == "moves":  # somebody pushes it
            vehicle.measured = False
            vehicle.apply(StandingMeasured(False))
            if vehicle.state.motion is Motion.STOPPING:
                vehicle.apply(StopEnded(False))
        elif kind == "mode":
            vehicle.apply(ModeChanged(self.random.choice(("MANUAL", "AUTOMATIC"))))
        elif kind == "die":
            self.die()
        elif kind == "maps":
            self.maps()
        elif kind == "end":
            self.end()
        elif kind == "full":
            vehicle.disk.full = True
        elif kind == "room":
            vehicle.disk.full = False
            vehicle.write()
        elif kind == "retry":
            vehicle.apply(RetryDue())
        elif kind == "stopped":
            vehicle.apply(StoppedByOthers())
            assert vehicle.state.held or vehicle.state.ending or not vehicle.state.executing

    def settle(self) -> None:
        """All goes well from here on."""
        vehicle = self.vehicle
        vehicle.disk.full = False
        vehicle.write()
        vehicle.apply(ModeChanged("AUTOMATIC"))
        for _ in range(300):
            if vehicle.state.paused or vehicle.state.held:
                vehicle.instant(action(self.name(), "stopPause"))
            if vehicle.state.position is None:
                vehicle.place(0.0)
            vehicle.apply(RetryDue())
            if not vehicle.state.heard:
                vehicle.apply(ContactChanged(True))
            vehicle.stand()
            if vehicle.running:
                name = sorted(vehicle.to_end or vehicle.running)[0]
                vehicle.finish(name, name not in vehicle.to_end)
            elif vehicle.drive is not None:
                if vehicle.halting:
                    vehicle.stop()
                else:
                    vehicle.arrive()
            else:
                return
        raise AssertionError(f"it never comes to rest: {vehicle.state.to_json()}")


def check_way(vehicle: PureVehicle, machine: OrderState) -> None:
    """No node was skipped: within an order, sequence ids of traversed nodes go up by two."""
    before = None
    for _, sequence in vehicle.visited:
        assert sequence == 0 or before is None or sequence in (before, before + 2), vehicle.visited
        before = sequence


@pytest.mark.whole
@settings(max_examples=500, deadline=None)
@given(st.integers(0, 2**32), st.integers(5, 60))
def test_master_and_vehicle_agree_in_the_end(seed: int, steps: int) -> None:
    """No action runs twice, no node is skipped, nothing of the horizon is driven, a HARD action is alone; in the end
    the vehicle stands at its decision point with all that began at an end."""
    world = World(seed)
    for _ in range(steps):
        world.step()
    world.settle()
    vehicle, machine = world.vehicle, world.vehicle.state
    assert not machine.driving
    assert not any(node.released for node in machine.nodes), "the base was not finished"
    assert (machine.last_node, machine.last_sequence) == machine.decision_point
    unfinished = [r for r in machine.action_states if not r.status.final]
    ahead = {each.sequence for each in (*machine.nodes, *machine.edges)}
    assert all(r.status.value == "WAITING" and r.sequence in ahead for r in unfinished), unfinished
    check_way(vehicle, machine)
    assert next_order_is_taken(world), [problem.description for problem in machine.problems]


def next_order_is_taken(world: World) -> bool:
    """Whether master and vehicle understand each other still: the order is finished, or cancelled, and another taken."""
    vehicle = world.vehicle
    if vehicle.state.executing:
        vehicle.instant(action(world.name(), "cancelOrder"))
        world.settle()
    place = vehicle.state.position
    assert place is not None
    nearest = chr(ord("a") + round(place.x / 2.0))
    vehicle.order("last", 0, nearest, deviation=1.5)
    return vehicle.state.order_id == "last"
