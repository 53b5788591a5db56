"""`Transition`: all changes of an `OrderState`, and the effects that one event collects. Pure.

`machine.py` calls its methods for each event, `rules.py` for what follows. Order, motion and actions change
by the tables of `tables.py`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from woosh_pure.fleet.messages.elements import Action, Edge, Node, Order
from woosh_pure.fleet.order.action_states import ActionState, ActionStates, Scope, effective_blocking
from woosh_pure.fleet.order.errors import ErrorType, Level, Problem
from woosh_pure.fleet.order.events import (
    BeginAction,
    Drive,
    Effect,
    Effects,
    EndAction,
    Halt,
    ScheduleRetry,
    StopAll,
)
from woosh_pure.fleet.order.state import OrderState
from woosh_pure.fleet.order.tables import (
    ActionStatus,
    Hold,
    Motion,
    MotionEvent,
    OrderEvent,
    may_become,
    next_motion,
    next_phase,
)
from woosh_pure.fleet.order.vehicle_limits import within_deviation

MAX_ACTION_STATES = 1000
"""Action states that are kept; running actions are always kept."""
MAX_REQUESTS = 32
"""Ended stateRequest and factsheetRequest actions that are kept."""
_REQUESTS = ("stateRequest", "factsheetRequest")

RETRIES = (2.0, 5.0, 10.0)
"""Seconds until a failed drive is tried again; afterwards it waits for a person or the fleet manager."""
STOP_AGAIN = 2.0
"""Seconds until a robot that did not stop is stopped again."""


class Transition:
    """The handling of one event.

    Attributes:
        state: The state so far.
        drive_is_new: This event has started a drive. Each node is traversed by an event of its own, so that a
            state is published for each.
    """

    def __init__(self, before: OrderState) -> None:
        self._before = self.state = before
        self.drive_is_new = False
        self._stops: list[Effect] = []
        self._begins: list[Effect] = []
        self._publishes = False

    def result(self) -> tuple[OrderState, Effects]:
        """The state after the event, and its effects."""
        before, state = self._before, self.state
        saves = state is not before and state.kept != before.kept
        shows = state is not before and state.shown != before.shown
        return state, Effects(self._stops, saves, saves or shows or self._publishes, self._begins)

    def request(self, effect: Effect) -> None:
        """Add an effect that stops nothing."""
        self._begins.append(effect)

    def publish(self) -> None:
        """Publish a state even if nothing has changed."""
        self._publishes = True

    def update(self, **fields: Any) -> None:
        """Change fields of the state that have no rule of their own."""
        self.state = self.state._replace(**fields)

    def change_motion(self, event: MotionEvent) -> None:
        """Change the motion by its table."""
        motion = next_motion(self.state.motion, event)
        if motion is not self.state.motion:
            open_still = motion in (Motion.DRIVING, Motion.HALTING)
            self.update(motion=motion, drive=self.state.drive if open_still else None)
        if event is MotionEvent.STOPPED:
            self.update(stops=0)

    # -- holds and problems ----------------------------------------------------------------------------------

    def hold(self, hold: Hold) -> None:
        """Set a hold."""
        self.update(set_holds=self.state.set_holds | {hold})

    def hold_order(self, text: str) -> None:
        """Hold the order until stopPause or cancelOrder, and report why."""
        self.hold(Hold.HELD)
        hint = "stopPause goes on, cancelOrder gives it up"
        problem = Problem(ErrorType.HELD, text, self.order_references(), Level.WARNING, hint)
        self.set_problem("held", problem)

    def release(self, *holds: Hold) -> None:
        """Release holds and remove their problems."""
        self.update(set_holds=self.state.set_holds - set(holds))
        for hold, key in ((Hold.HELD, "held"), (Hold.FAILED, "drive"), (Hold.DISK, "disk")):
            if hold in holds:
                self.set_problem(key, None)

    def report(self, problem: Problem) -> None:
        """Report a problem until an order is accepted."""
        self.update(problems=self.state.problems.added(problem))
        self.publish()

    def set_problem(self, key: str, problem: Problem | None) -> None:
        """Report a problem of the vehicle itself, or remove it (None)."""
        problems = self.state.problems.with_key(key, problem)
        if problems is not self.state.problems:
            self.update(problems=problems)

    def report_failed_action(self, failed: ActionState, text: str) -> None:
        """Report that an action has failed."""
        about = {
            "topic": "order" if failed.of_order else "instantActions",
            "actionId": failed.action.id,
            "actionType": failed.action.type,
        }
        kind = ErrorType.ORDER_ACTION if failed.of_order else ErrorType.INSTANT_ACTION
        text = f"{failed.action.type} has failed: {text or 'no reason was given'}"
        self.report(Problem(kind, text, about))

    def order_references(self, **more: str) -> dict[str, str]:
        """References of a problem of the order."""
        return {"orderId": self.state.order_id, "orderUpdateId": str(self.state.update), **more}

    # -- the order -------------------------------------------------------------------------------------------

    def take(self, order: Order) -> None:
        """Accept a new order."""
        self.update(
            phase=next_phase(self.state.phase, OrderEvent.TAKEN),
            problems=replace(self.state.problems, of_orders=()),
            order_id=order.id,
            update=order.update,
            nodes=order.nodes,
            edges=order.edges,
            on_edge=False,
            failures=0,
        )
        self.release(Hold.HELD, Hold.FAILED)
        self._set_actions(self.state.action_states.open_instant)
        self._add_actions(order.nodes, order.edges)
        first = order.nodes[0]
        if first.position is None or within_deviation(self.state.position, first, self.state.limits):
            self.traverse()
        self.publish()

    def extend(self, order: Order) -> None:
        """Accept an update, which replaces the horizon."""
        state, gone = self.state, self.state.ids_of_horizon()
        self.update(
            problems=replace(state.problems, of_orders=()),
            nodes=(*(node for node in state.nodes if node.released), *order.nodes[1:]),
            edges=(*(edge for edge in state.edges if edge.released), *order.edges),
            update=order.update,
        )
        self._set_actions(each for each in state.action_states if each.action.id not in gone)
        self._add_actions(order.nodes[1:], order.edges)
        self.publish()

    def traverse(self) -> None:
        """Reach the next node and leave the edge before it."""
        state = self.state
        node, left = state.nodes[0], state.edges[:1] if state.has_edge_to(state.nodes[0]) else ()
        self.update(
            nodes=state.nodes[1:],
            edges=state.edges[len(left) :],
            last_node=node.id,
            last_sequence=node.sequence,
            on_edge=False,
            failures=0,
        )
        for edge in left:
            for each in state.action_states.at(Scope.EDGE, edge.sequence):
                if not each.status.final:
                    self._request_end(each, failed=False)

    def give_up(self, cancel: str | None = None) -> None:
        """Cancel or clear the order: its actions are ended; `forget` follows when all have ended.

        Args:
            cancel: Id of the cancelOrder action to finish then.
        """
        begins = not self.state.ending
        cancels = self.state.cancels if cancel is None else (*self.state.cancels, cancel)
        self.update(phase=next_phase(self.state.phase, OrderEvent.GIVEN_UP), cancels=cancels)
        for each in self.state.action_states if begins else ():
            if each.of_order and not each.status.final:
                self._request_end(each, failed=True)

    def forget(self, cancels: ActionStatus) -> None:
        """Forget the order that was given up; its cancelOrder actions get the status `cancels`."""
        ended = self.state.cancels
        self.update(
            phase=next_phase(self.state.phase, OrderEvent.OVER), nodes=(), edges=(), cancels=(), on_edge=False
        )
        self.release(Hold.HELD, Hold.FAILED)
        for name in ended:
            self.set_action(name, cancels)

    # -- driving ---------------------------------------------------------------------------------------------

    def drive_to(self, node: Node) -> None:
        """Start a drive; it replaces the current one."""
        self.change_motion(MotionEvent.DRIVE)
        token = self.state.last_token + 1
        drive = Drive(token, node, self.state.edges[0] if self.state.has_edge_to(node) else None)
        self.update(drive=drive, last_token=token)
        self.drive_is_new = True
        self.request(drive)

    def halt(self) -> None:
        """Cancel the current drive."""
        assert self.state.drive is not None
        self._stops.append(Halt(self.state.drive.token))
        self.change_motion(MotionEvent.HALT)

    def stop_all(self) -> None:
        """Stop every motion of the robot, because it is not known whether the last one has ended."""
        self._stops.append(StopAll(STOP_AGAIN if self.state.stops else 0.0))
        self.change_motion(MotionEvent.STOP)
        self.update(stops=self.state.stops + 1)

    def drive_failed(self, drive: Drive, text: str) -> None:
        """Report a drive that did not reach its node, and schedule the next try if any is left."""
        tries = self.state.failures
        last = tries >= len(RETRIES)
        self.update(failures=tries + 1)
        self.hold(Hold.FAILED)
        problem = Problem(
            ErrorType.DRIVE,
            f"node {drive.node.id} was not reached: {text}",
            {
                "orderId": self.state.order_id,
                "nodeId": drive.node.id,
                "sequenceId": str(drive.node.sequence),
            },
            Level.FATAL if last else Level.WARNING,
            "see to the way and to the vehicle; stopPause tries again, cancelOrder gives up",
        )
        self.set_problem("drive", problem)
        if not last:
            self.request(ScheduleRetry(RETRIES[tries]))

    def forget_failures(self) -> None:
        """Reset the count of failures, and allow the drive to be tried again."""
        self.update(failures=0)
        self.release(Hold.FAILED)

    # -- actions ---------------------------------------------------------------------------------------------

    def add_instant_action(self, action: Action) -> ActionState:
        """Add an instant action, WAITING."""
        supported = self.state.limits.actions.get(action.type)
        added = ActionState(action, Scope.INSTANT, 0, effective_blocking(action, supported))
        known = self.state.action_states
        if action.type in _REQUESTS or len(known) >= MAX_ACTION_STATES:  # others may have to go
            self._set_actions((*known, added))
        else:
            self.update(
                action_states=known.with_instant(added),
                actions_to_save=self.state.actions_to_save | {action.id},
            )
        return added

    def start_built_in(self, built_in: ActionState) -> None:
        """Start a built-in action; it blocks nothing."""
        self._replace_action(built_in._replace(blocking="NONE", status=ActionStatus.RUNNING))

    def begin(self, waiting: ActionState) -> None:
        """Start an action."""
        self.set_action(waiting.action.id, ActionStatus.RUNNING)
        if self.state.moves(waiting):
            self.change_motion(MotionEvent.MOVED)
        self.request(BeginAction(waiting.action))

    def set_action(self, action_id: str, status: ActionStatus, result: str = "") -> None:
        """Set the status of an action; its result is kept if none is given."""
        known = self.state.action_state(action_id)
        if known is None:
            return
        assert may_become(known.status, status), f"{action_id} is {known.status}, and became {status}"
        self._replace_action(known._replace(status=status, result=result or known.result))

    def _request_end(self, action: ActionState, *, failed: bool) -> None:
        """End an action; one that waits fails. `failed` is False if the vehicle has left the action's edge,
        which is its regular end."""
        if action.status is ActionStatus.WAITING:
            self.set_action(action.action.id, ActionStatus.FAILED, "the order was cancelled before it began")
            return
        supported = self.state.limits.actions.get(action.action.type)
        if not action.ending and (not failed or supported is None or supported.interruptible):
            self._replace_action(action._replace(ending=True))
            # What is cancelled ends before anything is saved; the regular end of an edge can wait for that.
            (self._stops if failed else self._begins).append(EndAction(action.action.id))

    def _replace_action(self, new: ActionState) -> None:
        states = self.state.action_states.with_state(new)
        self.update(action_states=states, actions_to_save=self.state.actions_to_save | {new.action.id})

    def _add_actions(self, nodes: Iterable[Node], edges: Iterable[Edge]) -> None:
        """Add states for the actions of new nodes and edges, in the order of their sequence ids."""
        elements: list[Node | Edge] = [*nodes, *edges]
        added = []
        for element in sorted(elements, key=lambda each: each.sequence):
            scope = Scope.NODE if isinstance(element, Node) else Scope.EDGE
            for action in element.actions:
                blocking = effective_blocking(action, self.state.limits.actions.get(action.type))
                added.append(ActionState(action, scope, element.sequence, blocking))
        self._set_actions((*self.state.action_states, *added))

    def _set_actions(self, given: Iterable[ActionState]) -> None:
        """Let actions come and go, and forget the oldest if there are too many. Each state message has them
        all, so those of requests are dropped early."""
        states = tuple(given)
        requests = [a for a in states if a.action.type in _REQUESTS and a.status.final]
        gone = {id(each) for each in requests[:-MAX_REQUESTS]}
        over = len(states) - len(gone) - MAX_ACTION_STATES
        if over > 0:
            old = [each for each in states if each.status.final and id(each) not in gone]
            gone |= {id(each) for each in old[:over]}
        known = ActionStates.of(each for each in states if id(each) not in gone)
        moved = self.state.action_states.ids() ^ known.ids()
        self.update(action_states=known, actions_to_save=self.state.actions_to_save | moved)
