"""The order machine: what a vehicle does with orders, actions and its own arrivals. Pure: no clock, no
network.

It is told what happens, and answers with effects: drive there, halt, begin this action. Whoever carries
them out tells how they ended. Every input ends in `_settle`, where one table decides, from the top, what
comes next:

    when                                           then
    ----------------------------------------------------------------------------------------------------
    an order is cancelled or cleared               halt; end its actions; when all has ended, forget it
    actions here or instant ones may begin         begin them (`actions.beginning` has their order)
    something holds: pause, mode, no pose,         halt
      a failed drive, a SOFT or HARD action
    nothing can be kept on disk                    drive on to the node under way; begin nothing else
    the next node is released, none holds          enter its edge, begin the edge's actions, drive to it
    the next node is not released, or none is      stand

A node is traversed when the measured pose is in its deviation range. Where the vehicle goes on without a
stop that is enough, and the next drive replaces the one under way; where it stops (the end of the base, an
action that wants it to stand), the drive must have ended, too. Only the next node is ever looked at, so
none is skipped. With a node the edge before it is left: what runs on the edge is ended.

Every action begins once: its record is RUNNING before the effect is given out, `Changed` comes first, and
whoever carries effects out puts the machine on disk at `Changed`. After a restart what was RUNNING is
FAILED, because nobody knows how it ended; it does not begin again.

Nothing moves because a program was started. An orderly end ends the order (`shut_down`). After any other
end the order is here again and `held`: paused, in the words of the standard, with its actions held, too,
until the fleet manager says stopPause, or gives it up with cancelOrder.
"""

from __future__ import annotations

import copy
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from woosh_pure.fleet.messages.elements import Action, Edge, InstantActions, Node, Order
from woosh_pure.fleet.messages.schema import Invalid
from woosh_pure.fleet.order.actions import OWN, Record, Scope, Status, beginning, effective, holds_driving
from woosh_pure.fleet.order.effects import Begin, Changed, Drive, Effect, End, Factsheet, Halt, Retry
from woosh_pure.fleet.order.errors import ErrorType, Level, Problem, Problems
from woosh_pure.fleet.order.rejection import (
    DRIVING_MODES,
    Limits,
    Place,
    action_problems,
    objection_to_new,
    objection_to_update,
    order_problem,
    within,
)

__all__ = ["Begin", "Changed", "Drive", "Effect", "End", "Factsheet", "Halt", "OrderMachine", "Retry"]

MOST_RECORDS = 1000
"""Ended actions that are remembered; one that runs is never forgotten."""
RETRIES = (2.0, 5.0, 10.0)
"""Seconds until a drive that failed is tried again; after these it waits for a person or the fleet
manager."""


class OrderMachine:
    """One vehicle's order. Not for several threads at a time.

    Args:
        limits: What the vehicle is able to obey; its abilities need not name those of the machine itself.
    """

    def __init__(self, limits: Limits) -> None:
        self.limits = replace(limits, abilities={**limits.abilities, **OWN})
        self.order_id, self.update = "", 0
        self.last_node, self.last_sequence = "", 0
        self.nodes: list[Node] = []
        self.edges: list[Edge] = []
        self.records: list[Record] = []
        self.problems = Problems()
        self.paused = False
        self.held = False  # it was restored: it goes on when the fleet manager says so
        self.mode = "SERVICE"  # until the vehicle has told it, nothing moves
        self.place: Place | None = None
        self.closed = False  # the order was cancelled or cleared: no update of it is taken
        self._cancels: list[str] = []  # the cancelOrder actions that wait for the end of the order
        self._ending = False
        self._on_edge = False
        self._failures = 0
        self._blocked = False
        self._unkept = False  # nothing can be put on disk: what began now might begin again after a restart
        self._token = 0
        self._drive: Drive | None = None
        self._halting = False
        self._fresh = False  # the drive was given out by this input: each node is told by itself
        self._effects: list[Effect] = []
        self._changed = False

    # -- what the state tells --------------------------------------------------------------------------------

    @property
    def executing(self) -> bool:
        """Whether an order is carried out, waits for an update, or is being cancelled (figure 8, 3)."""
        return bool(self.nodes) or any(r.of_order and not r.status.final for r in self.records)

    @property
    def driving(self) -> bool:
        """Whether a drive was given out that has not ended."""
        return self._drive is not None

    @property
    def wants_base(self) -> bool:
        """`newBaseRequest`: there is a horizon, and the last node of the base is the next, or reached."""
        released = sum(node.released for node in self.nodes)
        return len(self.nodes) > released and released <= 1 and not self._ending

    @property
    def decision_point(self) -> tuple[str, int]:
        """Id and sequence of the last node of the base."""
        base = [node for node in self.nodes if node.released]
        return (base[-1].id, base[-1].sequence) if base else (self.last_node, self.last_sequence)

    # -- inputs ----------------------------------------------------------------------------------------------

    def receive(self, order: Order) -> list[Effect]:
        """An order or an update, well formed."""
        same = order.id == self.order_id and bool(self.order_id)
        if same and order.update == self.update:
            self._changed = True  # 6.6.4.3: ignored; the state tells the manager that it is here
            return self._settle()
        problem = objection_to_update(order, self) if same else objection_to_new(order, self)
        if problem is not None:
            self._tell(problem)
            return self._settle()
        self.problems.order_accepted()
        self._changed = True
        if same:
            self._extend(order)
        else:
            self._take(order)
        return self._settle()

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
        self._tell(Problem(ErrorType.VALIDATION, str(error), tuple(about)))
        return self._settle()

    def receive_instant(self, message: InstantActions) -> list[Effect]:
        """Instant actions. One whose id is known already came twice, and is done once."""
        for action in message.actions:
            self._changed = True
            if all(record.action.id != action.id for record in self.records):
                self._take_instant(action, message.header)
        return self._settle()

    def at(self, place: Place | None) -> list[Effect]:
        """The measured pose; None while the vehicle does not know where it is."""
        lost = place is None
        self._changed |= lost != (self.place is None)
        self.place = place
        return self._settle()

    def drive_ended(self, token: int, arrived: bool, text: str = "") -> list[Effect]:
        """A drive is over, and the vehicle stands."""
        drive = self._drive
        if drive is None or drive.token != token:
            return self._settle()  # one that was replaced
        halted, self._drive, self._halting = self._halting, None, False
        self._changed = True
        if arrived and self._reached(drive.node):
            self._traverse()
        elif not halted:
            self._drive_failed(drive, text or "it ended beside the node, out of the node's deviation range")
        return self._settle()

    def action_ended(self, action_id: str, ok: bool, text: str = "") -> list[Effect]:
        """An action is over."""
        record = self._record(action_id)
        if record is None or record.status.final:
            return self._settle()
        self._changed = True
        record.status, record.result = (Status.FINISHED if ok else Status.FAILED), text
        if ok and record.action.type == "initPosition" and not record.of_order:
            self.last_node, self.last_sequence = str(record.action.parameters.get("lastNodeId", "")), 0
        if not ok and not record.ending:
            self._action_failed(record, text)
        return self._settle()

    def action_running(self, action_id: str, status: Status = Status.RUNNING) -> list[Effect]:
        """An action has come from its preparation to its work, pauses, or goes on."""
        record = self._record(action_id)
        if record is not None and record.status.begun and not status.final and record.status is not status:
            record.status, self._changed = status, True
        return self._settle()

    def set_mode(self, mode: str) -> list[Effect]:
        """The operating mode. Where the fleet manager is not in control, its order is cleared (6.10.6)."""
        if mode != self.mode:
            self.mode, self._changed = mode, True
            if mode not in DRIVING_MODES and self.executing:
                self._close_order()
                text = (
                    f"the order was cleared, because the operating mode is {mode}; send a new one afterwards"
                )
                about = (("orderId", self.order_id), ("orderUpdateId", str(self.update)))
                self._tell(Problem(ErrorType.ORDER, text, about))
        return self._settle()

    def shut_down(self, text: str) -> list[Effect]:
        """The end of this program, in order: the vehicle was halted, and its order is over."""
        if self.executing:
            if not self._ending:
                self._close_order()
            for record in self.records:
                if record.of_order and not record.status.final:
                    record.status, record.result = Status.FAILED, text
            self._drive, self._halting = None, False
            about = (("orderId", self.order_id), ("orderUpdateId", str(self.update)))
            self._tell(Problem(ErrorType.ORDER, f"{text}; the order is over, send a new one", about))
        for record in self.records:
            if not record.of_order and not record.status.final and record.action.type not in OWN:
                record.status, record.result, self._changed = Status.FAILED, text, True
        return self._settle()

    def retry(self) -> list[Effect]:
        """The time of a `Retry` is over, or what stood in the way is."""
        if self._blocked:
            self._blocked = False
            self._changed |= self.problems.stand("drive", None)
        return self._settle()

    def keep(self, problem: Problem | None) -> list[Effect]:
        """Whether it can be put on disk: with a problem nothing new begins until it is taken back."""
        self._unkept = problem is not None
        return self.stand("disk", problem)

    def refuse(self, order: Order, text: str) -> list[Effect]:
        """Reject an order for a reason that is not the machine's."""
        self._tell(order_problem(order, ErrorType.ORDER, text))
        return self._settle()

    def rehearsal(self) -> OrderMachine:
        """A copy to try an order with; nothing of it is carried out."""
        found = copy.copy(self)
        found.nodes, found.edges, found._cancels = list(self.nodes), list(self.edges), list(self._cancels)
        found.records = [copy.copy(record) for record in self.records]
        found.problems, found._effects = copy.deepcopy(self.problems), []
        return found

    def stand(self, key: str, problem: Problem | None) -> list[Effect]:
        """Tell a problem of the vehicle itself, or take it back."""
        self._changed |= self.problems.stand(key, problem)
        return self._settle()

    # -- orders ----------------------------------------------------------------------------------------------

    def _take(self, order: Order) -> None:
        self.records = [r for r in self.records if not r.of_order and not r.status.final]
        self.order_id, self.update, self.closed = order.id, order.update, False
        self.nodes, self.edges = list(order.nodes), list(order.edges)
        self._on_edge = self._blocked = False
        self._failures = 0
        self.problems.stand("drive", None)
        self._go_on()
        self._note(order.nodes, order.edges)
        first = order.nodes[0]
        if first.position is None or within(self.place, first, self.limits):
            self._traverse()

    def _extend(self, order: Order) -> None:
        dropped = self.horizon()
        self.records = _without(self.records, dropped)
        self.nodes = [node for node in self.nodes if node.released]
        self.edges = [edge for edge in self.edges if edge.released]
        self.update = order.update
        self.nodes += order.nodes[1:]
        self.edges += order.edges
        self._note(order.nodes[1:], order.edges)

    def horizon(self) -> list[Record]:
        """The actions of what is not released."""
        elements: list[Node | Edge] = [*self.nodes, *self.edges]
        ahead = {each.sequence for each in elements if not each.released}
        return [record for record in self.records if record.of_order and record.sequence in ahead]

    def _note(self, nodes: Iterable[Node], edges: Iterable[Edge]) -> None:
        """Records for the actions of new nodes and edges, in the order in which they come."""
        elements: list[Node | Edge] = [*nodes, *edges]
        for element in sorted(elements, key=lambda each: each.sequence):
            scope = Scope.NODE if isinstance(element, Node) else Scope.EDGE
            for action in element.actions:
                blocking = effective(action, self.limits.abilities.get(action.type))
                self.records.append(Record(action, scope, element.sequence, blocking))
        over = len(self.records) - MOST_RECORDS
        if over > 0:
            old = [r for r in self.records if r.status.final][:over]
            self.records = _without(self.records, old)

    def _close_order(self) -> None:
        """Its actions are ended, its nodes are forgotten when all stands."""
        self.closed = self._ending = self._changed = True
        for record in self.records:
            if record.of_order and not record.status.final:
                self._end_action(record, failed=True)

    def _end_action(self, record: Record, *, failed: bool) -> None:
        if record.status is Status.WAITING:
            record.status, record.result = Status.FAILED, "the order was cancelled before it began"
            return
        ability = self.limits.abilities.get(record.action.type)
        if not record.ending and (not failed or ability is None or ability.interruptible):
            record.ending = True
            self._effects.append(End(record.action.id, failed))

    # -- instant actions -------------------------------------------------------------------------------------

    def _take_instant(self, action: Action, header: int) -> None:
        ability = self.limits.abilities.get(action.type)
        record = Record(action, Scope.INSTANT, 0, effective(action, ability))
        self.records.append(record)
        self._note((), ())
        problem = action_problems(action, Scope.INSTANT, self.limits, header) or self._conflict(record)
        if problem is not None:
            record.status, record.result = Status.FAILED, problem.description
            self._tell(problem)
        elif action.type in OWN:
            record.blocking, record.status = "NONE", Status.RUNNING
            getattr(self, _OWN_DOORS[action.type])(record)

    def _conflict(self, record: Record) -> Problem | None:
        """6.9: an instant action must not contradict the order, nor move in a mode that is somebody
        else's."""
        action, ability = record.action, self.limits.abilities[record.action.type]
        of_map = action.type == "enableMap" and action.parameters.get("mapId") in self.limits.maps
        if not (ability.moves or action.type == "initPosition" or of_map):
            return None
        about = (("topic", "instantActions"), ("actionId", action.id), ("actionType", action.type))
        if self.executing:
            text = f"{action.type} contradicts order {self.order_id}, which is carried out; cancel it first"
            return Problem(ErrorType.INSTANT_ACTION, text, about)
        if ability.moves and self.mode not in DRIVING_MODES:
            text = f"{action.type} moves the robot, and the operating mode is {self.mode}"
            return Problem(ErrorType.INSTANT_ACTION, text, about)
        return None

    def _cancel(self, record: Record) -> None:
        if not self.executing or (self._ending and not self._cancels):
            record.status, record.result = Status.FAILED, "there is no order to cancel"
            about = (("topic", "instantActions"), ("actionId", record.action.id))
            self._tell(Problem(ErrorType.NO_ORDER_TO_CANCEL, "there is no order to cancel", about))
            return
        if not self._ending:
            self._close_order()
        self._cancels.append(record.action.id)

    def _pause(self, record: Record) -> None:
        self.paused = True  # it is FINISHED when the vehicle stands: `_settle_pause`

    def _resume(self, record: Record) -> None:
        self.paused, record.status = False, Status.FINISHED
        self._go_on()
        self._settle_pause(give_up=True)
        self._failures = 0
        self._blocked = False
        self.problems.stand("drive", None)

    def _hold(self) -> None:
        """6.8.1, startPause: no movement, and the order is resumable; here, nothing of it begins, either."""
        at_hand = any(node.released for node in self.nodes) or any(not r.status.final for r in self._here())
        if at_hand and not self._ending:
            self.held = True
            text = "the vehicle's software was restarted while it carried out this order, which waits now"
            about = (("orderId", self.order_id), ("orderUpdateId", str(self.update)))
            hint = "stopPause goes on, cancelOrder gives it up"
            self.problems.stand("held", Problem(ErrorType.HELD, text, about, Level.WARNING, hint))

    def _go_on(self) -> None:
        self.held = False
        self.problems.stand("held", None)

    def _state_request(self, record: Record) -> None:
        record.status = Status.FINISHED

    def _factsheet_request(self, record: Record) -> None:
        record.status = Status.FINISHED
        self._effects.append(Factsheet())

    # -- driving ---------------------------------------------------------------------------------------------

    def _reached(self, node: Node) -> bool:
        """Whether a drive that arrived did so at its node; where a mark is, only the chassis knows."""
        return bool(self.nodes) and self.nodes[0] is node and (
            node.position is None or within(self.place, node, self.limits)
        )  # fmt: skip

    def _traverse(self) -> None:
        """The next node is reached: its edge is left, its actions are here now."""
        node = self.nodes.pop(0)
        if self.edges and self.edges[0].sequence < node.sequence:
            self.edges.pop(0)
        for record in self.records:
            if record.scope is Scope.EDGE and record.sequence < node.sequence and not record.status.final:
                self._end_action(record, failed=False)
        self.last_node, self.last_sequence = node.id, node.sequence
        self._on_edge = False
        self._failures = 0
        self._changed = True

    def _passes(self, node: Node) -> bool:
        """Whether the vehicle goes on from a node without a stop."""
        if self._ending or len(self.nodes) < 2 or not self.nodes[1].released:
            return False
        here = [r for r in self.records if r.of_order and r.sequence in (node.sequence, node.sequence + 1)]
        return (
            not any(r.stands_still for r in here)
            and node.position is not None
            and node.position.deviation_xy > 0
        )

    def _drive_failed(self, drive: Drive, text: str) -> None:
        self._blocked = True
        tries = self._failures
        self._failures += 1
        last = tries >= len(RETRIES)
        problem = Problem(
            ErrorType.DRIVE,
            f"node {drive.node.id} was not reached: {text}",
            (("orderId", self.order_id), ("nodeId", drive.node.id), ("sequenceId", str(drive.node.sequence))),
            Level.FATAL if last else Level.WARNING,
            "see to the way and to the vehicle; stopPause tries again, cancelOrder gives up",
        )
        self.problems.stand("drive", problem)
        if not last:
            self._effects.append(Retry(RETRIES[tries]))

    def _action_failed(self, record: Record, text: str) -> None:
        kind = ErrorType.ORDER_ACTION if record.of_order else ErrorType.INSTANT_ACTION
        about = (
            ("topic", "order" if record.of_order else "instantActions"),
            ("actionId", record.action.id),
            ("actionType", record.action.type),
        )
        self._tell(Problem(kind, f"{record.action.type} has failed: {text or 'no reason was given'}", about))

    # -- the table -------------------------------------------------------------------------------------------

    def _settle(self) -> list[Effect]:
        """What comes next; the effects of this input."""
        self._fresh = False
        while self._step():
            pass
        effects: list[Effect] = [Changed(), *self._effects] if self._changed else list(self._effects)
        self._effects, self._changed = [], False
        return effects

    def _step(self) -> bool:
        """One row of the table; True when something was done that lets another follow."""
        self._settle_pause()
        if self._ending:
            return self._step_to_the_end()
        if self._drive is not None and not self._halting and self._arrives(self._drive):
            return True
        if self._begin_actions():
            return True
        if self._drive is not None:
            if not self._may_drive() and not self._halting:
                self._halt()
                return True
            return False
        if self._unkept or not (self.nodes and self.nodes[0].released and self._may_drive()):
            return False
        if not self._on_edge:
            self._on_edge = True  # its actions begin before the vehicle does
            return True
        node = self.nodes[0]
        if within(self.place, node, self.limits) and not self._before(node):
            self._traverse()  # the first node of an order, or one that another drive came by
            return True
        self._give_drive(node)
        return False

    def _before(self, node: Node) -> bool:
        """Whether an edge leads to it: then it is driven, and not only looked at."""
        return bool(self.edges) and self.edges[0].sequence < node.sequence

    def _arrives(self, drive: Drive) -> bool:
        node = drive.node
        if self._fresh or not (self._passes(node) and self._reached(node)) or self._holds() or self._unkept:
            return False
        self._traverse()
        while self._begin_actions():
            pass
        self._on_edge = True
        while self._begin_actions():
            pass
        if self._may_drive():
            self._give_drive(self.nodes[0])
        else:
            self._halt()
        return True

    def _give_drive(self, node: Node) -> None:
        self._token += 1
        edge = self.edges[0] if self._before(node) else None
        self._drive, self._halting, self._changed = Drive(self._token, node, edge), False, True
        self._fresh = True
        self._effects.append(self._drive)

    def _halt(self) -> None:
        assert self._drive is not None
        self._halting = True
        self._effects.append(Halt(self._drive.token))

    def _holds(self) -> bool:
        """Whether something that is no action keeps it from driving."""
        return self.paused or self.held or self._blocked or self.mode not in DRIVING_MODES or (
            self.place is None and bool(self.nodes) and self.nodes[0].position is not None
        )  # fmt: skip

    def _may_drive(self) -> bool:
        return not self._holds() and not holds_driving((*self._here(), *self._instant()))

    def _here(self) -> list[Record]:
        """The actions of the node it is on, and of the edge that it has entered."""
        places = {(Scope.NODE, self.last_sequence)}
        if self._on_edge and self.nodes and self._before(self.nodes[0]):
            places.add((Scope.EDGE, self.edges[0].sequence))
        return [r for r in self.records if (r.scope, r.sequence) in places and self._here_at_all(r)]

    def _here_at_all(self, record: Record) -> bool:
        """The first node of an order has a sequence that `last_sequence` may have by chance."""
        return not any(node.sequence == record.sequence for node in self.nodes)

    def _instant(self) -> list[Record]:
        return [r for r in self.records if not r.of_order and r.action.type not in OWN]

    def _begin_actions(self) -> bool:
        if self._unkept:
            return False
        standing = self._drive is None
        here, instant = self._here(), self._instant()
        for group in (instant, here):
            others = [r for r in _without(self.records, group) if r.action.type not in OWN]
            for record in beginning(group, others, standing=standing):
                if self.paused and self._moves(record):
                    break
                if record.of_order and (self.held or self.mode not in DRIVING_MODES):
                    break
                record.status, self._changed = Status.RUNNING, True
                self._effects.append(Begin(record.action, record.scope))
                return True
        return False

    def _moves(self, record: Record) -> bool:
        ability = self.limits.abilities.get(record.action.type)
        return ability is not None and ability.moves

    def _step_to_the_end(self) -> bool:
        """The order was cancelled: when the vehicle stands and its actions have ended, it is forgotten."""
        if self._drive is not None:
            if not self._halting:
                self._halt()
            return False
        if any(r.of_order and not r.status.final for r in self.records):
            return False
        self.nodes, self.edges, self._ending, self._on_edge, self._blocked = [], [], False, False, False
        self._go_on()
        self.problems.stand("drive", None)
        for record in self.records:
            if record.action.id in self._cancels:
                record.status = Status.FINISHED
        self._cancels, self._changed = [], True
        return True

    def _settle_pause(self, *, give_up: bool = False) -> None:
        """startPause is FINISHED when the vehicle stands; FAILED when it was taken back before."""
        for record in self.records:
            if (
                record.action.type == "startPause"
                and record.status.begun
                and (give_up or self._drive is None)
            ):
                record.status, self._changed = (Status.FAILED if give_up else Status.FINISHED), True

    # -- helpers ---------------------------------------------------------------------------------------------

    def _record(self, action_id: str) -> Record | None:
        return next((record for record in self.records if record.action.id == action_id), None)

    def _tell(self, problem: Problem) -> None:
        self.problems.add(problem)
        self._changed = True

    # -- the disk --------------------------------------------------------------------------------------------

    def to_json(self) -> dict[str, Any]:
        """Everything that must outlive this process, as a JSON object."""
        return {
            "orderId": self.order_id, "orderUpdateId": self.update, "lastNodeId": self.last_node,
            "lastNodeSequenceId": self.last_sequence, "nodes": [node.to_json() for node in self.nodes],
            "edges": [edge.to_json() for edge in self.edges], "records": [r.to_json() for r in self.records],
            "problems": [problem.to_json() for problem in self.problems.of_orders], "paused": self.paused,
            "closed": self.closed, "ending": self._ending, "cancels": list(self._cancels),
            "driving": self.driving, "onEdge": self._on_edge,
        }  # fmt: skip

    @classmethod
    def from_json(cls, data: Mapping[str, Any], limits: Limits) -> OrderMachine:
        """After an end that was not in order. What ran has failed; the order waits for the fleet manager.

        Raises:
            Invalid, KeyError, TypeError, ValueError: This is not what `to_json` gave.
        """
        from woosh_pure.fleet.messages.parsing import read_edge, read_node

        machine = cls(limits)
        machine.order_id, machine.update = str(data["orderId"]), int(data["orderUpdateId"])
        machine.last_node, machine.last_sequence = str(data["lastNodeId"]), int(data["lastNodeSequenceId"])
        machine.nodes = [read_node(raw, "nodes") for raw in data["nodes"]]
        machine.edges = [read_edge(raw, "edges") for raw in data["edges"]]
        machine.records = [Record.from_json(raw) for raw in data["records"]]
        machine.problems = Problems(Problem.from_json(raw) for raw in data["problems"])
        machine.paused, machine.closed = bool(data["paused"]), bool(data["closed"])
        machine._ending, machine._cancels = bool(data["ending"]), list(data["cancels"])
        machine._on_edge = bool(data["onEdge"])
        for record in machine.records:
            own = record.action.type in OWN
            if record.status.begun and not own:
                record.status = Status.FAILED
                record.result = "the vehicle's software was restarted while it ran"
                machine._action_failed(record, record.result)
        machine._hold()
        machine._changed = False
        return machine


def _without(records: list[Record], gone: list[Record]) -> list[Record]:
    left_out = {id(record) for record in gone}
    return [record for record in records if id(record) not in left_out]


_OWN_DOORS = {
    "cancelOrder": "_cancel",
    "startPause": "_pause",
    "stopPause": "_resume",
    "stateRequest": "_state_request",
    "factsheetRequest": "_factsheet_request",
}
