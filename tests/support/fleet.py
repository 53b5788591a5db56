"""Orders of VDA 5050 for tests, and a simulated vehicle that carries out the effects of the order machine."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

from woosh_pure.fleet.action_handlers.predefined_actions import PARAMETERS, SCOPES
from woosh_pure.fleet.messages.parsing import read_instant_actions, read_order
from woosh_pure.fleet.order.action_states import Parameter, Scope, SupportedAction
from woosh_pure.fleet.order.events import (
    ActionEnded,
    BeginAction,
    Drive,
    DriveEnded,
    Effect,
    EndAction,
    Event,
    Halt,
    ModeChanged,
    PositionMeasured,
    PublishState,
    ScheduleRetry,
    StandingMeasured,
    StopAll,
    StopEnded,
)
from woosh_pure.fleet.order.state import OrderState, changed
from woosh_pure.fleet.order.vehicle_limits import AgvPosition, Capabilities
from woosh_pure.fleet.persistent_order import PersistentOrder

__all__ = ["LIMITS", "MemoryFile", "PureVehicle", "action", "instant", "order_json"]

EVERYWHERE = (Scope.NODE, Scope.EDGE, Scope.INSTANT)
LIMITS = Capabilities(
    actions={
        each.type: each
        for each in (
            SupportedAction("beep", EVERYWHERE, (Parameter("times", "INTEGER", optional=True),)),
            SupportedAction("weld", EVERYWHERE, interruptible=False),
            SupportedAction("dock", EVERYWHERE, moves=True),
            SupportedAction("park", EVERYWHERE, still=True),
            SupportedAction("enableMap", SCOPES["enableMap"], PARAMETERS["enableMap"], still=True),
            SupportedAction("initPosition", (Scope.INSTANT,), any_parameters=True),
        )
    },
    maps=("hall",),
)


def action(name: str, type_: str = "beep", blocking: str = "NONE", **parameters: Any) -> dict[str, Any]:
    """An action, as JSON."""
    return {
        "actionId": name, "actionType": type_, "blockingType": blocking,
        "actionParameters": [{"key": key, "value": value} for key, value in parameters.items()],
    }  # fmt: skip


def order_json(
    name: str = "o", update: int = 0, nodes: Iterable[Any] = ("a", "b", "c"), *, released: int | None = None,
    first: int = 0, deviation: float = 0.5, node_actions: dict[str, list[Any]] | None = None,
    edge_actions: dict[str, list[Any]] | None = None, header: int = 7,
) -> dict[str, Any]:  # fmt: skip
    """An order over nodes "a", "b" ..., which stand 2 m apart on the x axis, a at 0.

    Args:
        first: Sequence id of the first node.
        released: How many nodes are the base; None is all.
        node_actions, edge_actions: By node id, and by "ab" for the edge from a to b.
    """
    names = list(nodes)
    base = len(names) if released is None else released
    found: dict[str, Any] = {
        "headerId": header, "timestamp": "2026-01-01T00:00:00.00Z", "version": "2.1.0", "manufacturer": "W",
        "serialNumber": "1", "orderId": name, "orderUpdateId": update, "nodes": [], "edges": [],
    }  # fmt: skip
    for n, each in enumerate(names):
        position = {
            "x": 2.0 * (ord(each) - ord("a")),
            "y": 0.0,
            "mapId": "hall",
            "allowedDeviationXY": deviation,
        }
        found["nodes"].append(
            {
                "nodeId": each,
                "sequenceId": first + 2 * n,
                "released": n < base,
                "nodePosition": position,
                "actions": (node_actions or {}).get(each, []),
            }
        )
        if n:
            edge = names[n - 1] + each
            found["edges"].append(
                {
                    "edgeId": edge,
                    "sequenceId": first + 2 * n - 1,
                    "released": n < base,
                    "startNodeId": names[n - 1],
                    "endNodeId": each,
                    "actions": (edge_actions or {}).get(edge, []),
                }
            )
    return found


def instant(*actions: dict[str, Any]) -> dict[str, Any]:
    """A message of instant actions."""
    return {
        "headerId": 3, "timestamp": "2026-01-01T00:00:00.00Z", "version": "2.1.0", "manufacturer": "W",
        "serialNumber": "1", "actions": list(actions),
    }  # fmt: skip


class MemoryFile:
    """A vehicle's file, in memory.

    Attributes:
        kept: The last saved content.
        full: Whether saving fails.
        saves: Number of saves.
    """

    def __init__(self, kept: dict[str, Any] | None = None) -> None:
        self.kept = kept
        self.full = False
        self.saves = 0

    def load(self) -> list[dict[str, Any]]:
        return [] if self.kept is None else [self.kept]

    def save(self, data: dict[str, Any]) -> None:
        if self.full:
            raise OSError(28, "No space left on device")
        self.kept = json.loads(json.dumps(data))
        self.saves += 1

    def add(self, change: dict[str, Any]) -> bool:
        assert self.kept is not None
        self.save(changed(self.kept, [json.loads(json.dumps(change))]))
        return True

    def put_aside(self, why: str) -> None:
        raise AssertionError(why)


class PureVehicle:
    """An order machine with its disk and a record of its effects; nothing ends by itself.

    Args:
        limits: The vehicle's abilities.
        x: Its position, m.
        kept: The content of its disk.
        obeys: Whether it stands at once after a stop, and is measured standing after each end.

    Attributes:
        drives: Ids of the target nodes of its drives.
        begun: Ids of the begun actions.
        ended: Ids of the ended actions.
        visited: Ids of the nodes it has traversed.
        told: Number of requests to publish its state.
        stops: Number of requests to stop.
        disk: Its disk.
    """

    def __init__(
        self,
        limits: Capabilities = LIMITS,
        *,
        x: float = 0.0,
        kept: dict[str, Any] | None = None,
        obeys: bool = True,
    ) -> None:
        self.obeys, self.stops = obeys, 0
        self.disk = MemoryFile(kept)
        self.order_machine = PersistentOrder(limits, self.disk, "test")
        self.drives: list[str] = []
        self.begun: list[str] = []
        self.ended: list[str] = []
        self.visited: list[tuple[str, int]] = []
        self.retries: list[float] = []
        self.halts = self.told = 0
        self.drive: Drive | None = None
        self.halting = False
        for effect in self.order_machine.restore():
            self.take(effect)
        if self.obeys and self.stops:
            self.stopped(True)
        self.apply(ModeChanged("AUTOMATIC"))
        self.place(x)
        self.rest()

    @property
    def state(self) -> OrderState:
        """The state of its order."""
        return self.order_machine.state

    def apply(self, event: Event) -> None:
        """Apply an event; record all of its effects before carrying them out."""
        effects = []
        for effect in self.order_machine.apply(event):
            self.take(effect)
            effects.append(effect)
        self._visit()
        if self.obeys and any(isinstance(effect, StopAll) for effect in effects):
            self.stopped(True)

    def write(self) -> None:
        """Try the disk again."""
        for effect in self.order_machine.write():
            self.take(effect)
        self._visit()

    def _visit(self) -> None:
        last = (self.state.last_node, self.state.last_sequence)
        if last[0] and (not self.visited or self.visited[-1] != last):
            self.visited.append(last)

    def take(self, effect: Effect) -> None:
        """Record the effects."""
        if isinstance(effect, PublishState):
            self.told += 1
        elif isinstance(effect, Drive):
            self.drive, self.halting = effect, False
            self.drives.append(effect.node.id)
        elif isinstance(effect, Halt):
            assert self.drive is not None
            assert effect.token == self.drive.token
            self.halting, self.halts = True, self.halts + 1
        elif isinstance(effect, BeginAction):
            self.begun.append(effect.action.id)
        elif isinstance(effect, EndAction):
            self.ended.append(effect.action_id)
        elif isinstance(effect, ScheduleRetry):
            self.retries.append(effect.after)
        elif isinstance(effect, StopAll):
            self.stops += 1

    def rest(self) -> None:
        """Report standstill, if nothing moves the vehicle."""
        if self.obeys and self.drive is None:
            self.apply(StandingMeasured(True))

    def stopped(self, standing: bool) -> None:
        """Report the end of a stop."""
        self.apply(StopEnded(standing))
        self.rest()

    def order(self, *args: Any, **options: Any) -> None:
        """Receive an order of `order_json`."""
        self.apply(read_order(order_json(*args, **options)))

    def instant(self, *actions: dict[str, Any]) -> None:
        """Receive instant actions."""
        self.apply(read_instant_actions(instant(*actions)))

    def place(self, x: float, theta: float = 0.0) -> None:
        """Stand at x."""
        self.apply(PositionMeasured(AgvPosition(x, 0.0, theta)))

    def arrive(self) -> None:
        """The drive under way ends at its node."""
        assert self.drive is not None, "nothing was to be driven"
        drive = self.drive
        position = drive.node.position
        assert position is not None
        self.place(position.x, position.theta or 0.0)
        if self.drive is drive:
            self.drive = None
            self.apply(DriveEnded(drive.token, True))
            self.rest()

    def stop(self, *, known: bool = True) -> None:
        """The drive under way ends where it is."""
        assert self.drive is not None
        drive, self.drive = self.drive, None
        self.apply(DriveEnded(drive.token, False, "halted", known=known))
        self.rest()

    def finish(self, action_id: str, ok: bool = True, text: str = "") -> None:
        """An action ends."""
        self.apply(ActionEnded(action_id, ok, text))
        self.rest()

    def status(self, action_id: str) -> str:
        """Return the status of an action; "" if unknown."""
        return next((r.status.value for r in self.state.action_states if r.action.id == action_id), "")

    @property
    def problems(self) -> list[str]:
        """Return the types of the reported errors."""
        return [problem.kind for problem in self.state.problems]

    @property
    def ahead(self) -> str:
        """Ids of the nodes to come."""
        return "".join(node.id for node in self.state.nodes)
