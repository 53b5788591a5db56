"""The order machine: what comes in, and what a vehicle does about it. Pure: no clock, no network.

It is told what happens, and answers with effects: drive there, halt, begin this action. Whoever carries them
out tells how they ended. Every input ends in the table of `execution.py`, which decides what comes next;
`rejection.py` decides which orders are taken, `instant_actions.py` what is obeyed at once.

Nothing moves because a program was started. An orderly end ends the order (`shut_down`). After any other end
the order is here again (`persistence.py`) and `held` (`pause.py`): paused, in the words of the standard, with
its actions held, too, until the fleet manager says stopPause, or gives it up with cancelOrder.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from woosh_pure.fleet.messages.elements import InstantActions, Order
from woosh_pure.fleet.messages.schema import Invalid
from woosh_pure.fleet.order.actions import ActionStatus
from woosh_pure.fleet.order.cancelling import close_order, forget_order
from woosh_pure.fleet.order.deviation import AgvPosition, within_deviation
from woosh_pure.fleet.order.effects import Drive, Effect, Retry
from woosh_pure.fleet.order.errors import ErrorType, Level, Problem
from woosh_pure.fleet.order.execution import next_effects, reached, traverse
from woosh_pure.fleet.order.instant_actions import refuse_reused_id, take_instant_action
from woosh_pure.fleet.order.limits import Limits
from woosh_pure.fleet.order.order_state import OrderState, without
from woosh_pure.fleet.order.pause import release
from woosh_pure.fleet.order.persistence import order_from_json, order_to_json
from woosh_pure.fleet.order.rejection import order_problem, rejection_of_new_order, rejection_of_update

__all__ = ["OrderMachine"]

RETRIES = (2.0, 5.0, 10.0)
"""Seconds until a drive that failed is tried again; after these it waits for a person or the fleet
manager."""


class OrderMachine(OrderState):
    """One vehicle's order, with the inputs that change it. Not for several threads at a time."""

    # -- inputs ----------------------------------------------------------------------------------------------

    def receive(self, order: Order) -> list[Effect]:
        """An order or an update, well formed."""
        same = order.id == self.order_id and bool(self.order_id)
        if same and order.update == self.update:
            self.changed = True  # 6.6.4.3: ignored; the state tells the manager that it is here
            return next_effects(self)
        problem = rejection_of_update(order, self) if same else rejection_of_new_order(order, self)
        if problem is not None:
            self.add_problem(problem)
            return next_effects(self)
        self.problems.order_accepted()
        self.changed = True
        if same:
            self._extend(order)
        else:
            self._take(order)
        return next_effects(self)

    def receive_malformed(
        self, data: Mapping[str, Any], error: Invalid, topic: str = "order"
    ) -> list[Effect]:
        """A message that does not fit (6.6.4.1), with whatever of it can be read."""
        about = [("topic", topic)]
        for key in ("headerId", "orderId", "orderUpdateId"):
            if isinstance(data.get(key), (str, int)) and (topic == "order" or key == "headerId"):
                about.append((key, str(data[key])[:256]))
        if error.path:
            about.append(("field", error.path))
        self.add_problem(Problem(ErrorType.VALIDATION, str(error), tuple(about)))
        return next_effects(self)

    def receive_instant(self, message: InstantActions) -> list[Effect]:
        """Instant actions. One that is under way already came twice, and is done once; another one with an id
        that was used is refused."""
        for action in message.actions:
            self.changed = True
            known = self.action_state(action.id)
            if known is None:
                take_instant_action(self, action, message.header)
            elif known.action != action or known.status.final:
                refuse_reused_id(self, action, known, message.header)
        return next_effects(self)

    def set_position(self, position: AgvPosition | None) -> list[Effect]:
        """The measured position; None while the vehicle does not know where it is."""
        self.changed |= (position is None) != (self.position is None)
        self.position = position
        return next_effects(self)

    def set_standing(self, standing: bool) -> list[Effect]:
        """Whether the vehicle is measured standing; True only by what was measured after the last end of a
        drive, of a moving action or of a stop."""
        self.standing = standing and self.drive is None
        return next_effects(self)

    def set_heard(self, heard: bool) -> list[Effect]:
        """Whether the robot is heard. While it is not, nobody knows whether it stands."""
        self.heard, self.standing, self.stops = heard, False, 0
        return next_effects(self)

    def stop_ended(self, standing: bool) -> list[Effect]:
        """A `StopAll` is over; whether the robot stands."""
        self.stopping = self.standing = False
        if standing:
            self.unknown, self.stops = False, 0
        return next_effects(self)

    def drive_too_fast(self, text: str) -> list[Effect]:
        """The drive under way is faster than its edge allows: it is ended, told, and tried again later."""
        if self.drive is not None and not (self.halting or self.too_fast):
            self.too_fast = text
            about = (*self._about_order(), ("nodeId", self.drive.node.id))
            self.add_problem(Problem(ErrorType.SPEED, text, about))
        return next_effects(self)

    def drive_ended(self, token: int, arrived: bool, text: str = "", *, known: bool = True) -> list[Effect]:
        """A drive is over, which does not say that the vehicle stands.

        Args:
            token: Of the drive; the end of one that was replaced changes nothing.
            arrived: Whether the chassis says that it arrived.
            text: Why it did not.
            known: False where the chassis may go on with it: the link was lost, or it has confirmed no end.
        """
        drive = self.drive
        if drive is None or drive.token != token:
            return next_effects(self)  # one that was replaced
        halted, self.drive, self.halting = self.halting, None, False
        halted, text, self.too_fast = halted and not self.too_fast, self.too_fast or text, ""
        self.changed, self.standing = True, False
        self.unknown |= not known
        if arrived and reached(self, drive.node):
            traverse(self)
        elif not halted:
            self._drive_failed(drive, text or "it ended beside the node, out of the node's deviation range")
        return next_effects(self)

    def action_ended(self, action_id: str, ok: bool, text: str = "", *, known: bool = True) -> list[Effect]:
        """An action is over; `known` as with `drive_ended`."""
        ended = self.action_state(action_id)
        if ended is None or ended.status.final:
            return next_effects(self)
        self.changed = True
        if self.moves(ended):
            self.standing = False
            self.unknown |= not known
        ended.status, ended.result = (ActionStatus.FINISHED if ok else ActionStatus.FAILED), text
        if ok and ended.action.type == "initPosition" and not ended.of_order:
            self.last_node, self.last_sequence = str(ended.action.parameters.get("lastNodeId", "")), 0
        if not ok and not ended.ending:
            self.tell_failed_action(ended, text)
        return next_effects(self)

    def action_running(self, action_id: str, status: ActionStatus = ActionStatus.RUNNING) -> list[Effect]:
        """An action has come from its preparation to its work, pauses, or goes on."""
        known = self.action_state(action_id)
        if known is not None and known.status.begun and not status.final and known.status is not status:
            known.status, self.changed = status, True
        return next_effects(self)

    def set_mode(self, mode: str) -> list[Effect]:
        """The operating mode. Where the fleet manager is not in control, its order is cleared (6.10.6)."""
        if mode != self.mode:
            self.mode, self.changed = mode, True
            if not self.in_control and self.executing:
                close_order(self)
                text = (
                    f"the order was cleared, because the operating mode is {mode}; send a new one afterwards"
                )
                self.add_problem(Problem(ErrorType.ORDER, text, self._about_order()))
        return next_effects(self)

    def shut_down(self, text: str) -> list[Effect]:
        """The end of this program, in order: the vehicle was halted, and its order is over."""
        if self.executing:
            if not self.cancelling:
                close_order(self)
            for each in self.action_states:
                if each.of_order and not each.status.final:
                    each.status, each.result = ActionStatus.FAILED, text
            self.drive, self.halting = None, False
            forget_order(self, ActionStatus.FINISHED if self.at_rest else ActionStatus.FAILED)
            told = f"{text}; the order is over, send a new one"
            self.add_problem(Problem(ErrorType.ORDER, told, self._about_order()))
        for each in self.instant_actions():
            if not each.status.final:
                each.status, each.result, self.changed = ActionStatus.FAILED, text, True
        return next_effects(self)

    def retry(self) -> list[Effect]:
        """The time of a `Retry` is over, or what stood in the way is."""
        if self.blocked:
            self.blocked = False
            self.changed |= self.problems.set("drive", None)
        return next_effects(self)

    def set_storage_problem(self, problem: Problem | None) -> list[Effect]:
        """Whether it can be put on disk: with a problem nothing new begins until it is taken back."""
        self.unsaved = problem is not None
        return self.set_problem("disk", problem)

    def reject(self, order: Order, text: str) -> list[Effect]:
        """Reject an order for a reason that is not the machine's."""
        self.add_problem(order_problem(order, ErrorType.ORDER, text))
        return next_effects(self)

    def set_problem(self, key: str, problem: Problem | None) -> list[Effect]:
        """Tell a problem of the vehicle itself, or take it back."""
        self.changed |= self.problems.set(key, problem)
        return next_effects(self)

    # -- orders ----------------------------------------------------------------------------------------------

    def _take(self, order: Order) -> None:
        self.action_states = [a for a in self.action_states if not a.of_order and not a.status.final]
        self.order_id, self.update, self.closed = order.id, order.update, False
        self.nodes, self.edges = list(order.nodes), list(order.edges)
        self.on_edge = self.blocked = False
        self.failures = 0
        self.problems.set("drive", None)
        release(self)
        self.add_actions(order.nodes, order.edges)
        first = order.nodes[0]
        if first.position is None or within_deviation(self.position, first, self.limits):
            traverse(self)

    def _extend(self, order: Order) -> None:
        self.action_states = without(self.action_states, self.actions_of_horizon())
        self.nodes = [node for node in self.nodes if node.released]
        self.edges = [edge for edge in self.edges if edge.released]
        self.update = order.update
        self.nodes += order.nodes[1:]
        self.edges += order.edges
        self.add_actions(order.nodes[1:], order.edges)

    def _drive_failed(self, drive: Drive, text: str) -> None:
        self.blocked = True
        tries = self.failures
        self.failures += 1
        last = tries >= len(RETRIES)
        problem = Problem(
            ErrorType.DRIVE,
            f"node {drive.node.id} was not reached: {text}",
            (("orderId", self.order_id), ("nodeId", drive.node.id), ("sequenceId", str(drive.node.sequence))),
            Level.FATAL if last else Level.WARNING,
            "see to the way and to the vehicle; stopPause tries again, cancelOrder gives up",
        )
        self.problems.set("drive", problem)
        if not last:
            self.effects.append(Retry(RETRIES[tries]))

    def _about_order(self) -> tuple[tuple[str, str], ...]:
        return (("orderId", self.order_id), ("orderUpdateId", str(self.update)))

    # -- the disk --------------------------------------------------------------------------------------------

    def to_json(self) -> dict[str, Any]:
        """Everything that must outlive this process, as a JSON object."""
        return order_to_json(self)

    @classmethod
    def from_json(cls, data: Mapping[str, Any], limits: Limits) -> OrderMachine:
        """After an end that was not in order. What ran has failed; the order waits for the fleet manager.

        Raises:
            Invalid, KeyError, TypeError, ValueError: This is not what `to_json` gave.
        """
        machine = cls(limits)
        order_from_json(machine, data)
        return machine
