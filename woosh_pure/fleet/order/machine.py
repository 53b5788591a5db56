"""The order machine: `step` takes a state and an event, and returns the next state and the effects. Pure: no
clock, threads or network.

The table at the end of this file has a function for each class of event; afterwards `rules.py` decides what
follows. `rejection.py` decides which orders are accepted. `transition.py` changes the state, by `tables.py`.

The start of the program moves nothing. A clean end of the program ends the order (`ShutDown`). After any
other end the order is restored (`Restarted`) and held: it is reported as paused, and its actions wait, until
the fleet manager sends stopPause or cancelOrder. Motions that may be under way are stopped. Actions that ran
are FAILED, because their outcome is not known; they are not started again.

When somebody else stops the robot, the order is held in the same way (`StoppedByOthers`): the drive is
halted, nothing of the order begins, and actions that are waiting to move the robot fail.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from woosh_pure.fleet.messages.elements import Action, InstantActions, Order
from woosh_pure.fleet.order import events
from woosh_pure.fleet.order.action_states import BUILT_IN, ActionState
from woosh_pure.fleet.order.errors import ErrorType, Problem
from woosh_pure.fleet.order.events import Effects, Event, PublishFactsheet
from woosh_pure.fleet.order.rejection import (
    instant_action_problem,
    instant_problem,
    rejection_of_new_order,
    rejection_of_update,
)
from woosh_pure.fleet.order.rules import end_pauses, follow, reached
from woosh_pure.fleet.order.state import OrderState
from woosh_pure.fleet.order.tables import ActionStatus, Hold, Motion, MotionEvent
from woosh_pure.fleet.order.transition import Transition
from woosh_pure.fleet.order.vehicle_limits import AgvPosition, within_deviation


def step(state: OrderState, event: Event) -> tuple[OrderState, Effects]:
    """Return the state after an event, and its effects."""
    if isinstance(event, events.PositionMeasured) and _is_on_the_way(state, event.position):
        return state._replace(position=event.position), Effects([], False, False, [])
    change = Transition(state)
    _EVENTS[type(event)](change, event)
    follow(change)
    return change.result()


def _is_on_the_way(state: OrderState, position: AgvPosition | None) -> bool:
    """Whether a position between two nodes was measured; no rule depends on it."""
    before, drive = state.position, state.drive
    if state.motion is not Motion.DRIVING or drive is None or before is None or position is None:
        return False
    return before.map_id == position.map_id and not within_deviation(position, drive.node, state.limits)


# -- messages ------------------------------------------------------------------------------------------------


def _order(change: Transition, order: Order) -> None:
    state = change.state
    same = order.id == state.order_id and bool(state.order_id)
    if same and order.update == state.update:
        change.publish()  # 6.6.4.3: ignored; the state shows the manager that it has arrived
        return
    problem = rejection_of_update(order, state) if same else rejection_of_new_order(order, state)
    if problem is not None:
        change.report(problem)
    elif same:
        change.extend(order)
    else:
        change.take(order)


def _malformed(change: Transition, event: events.MalformedMessage) -> None:
    about = {"topic": event.topic}
    for key in ("headerId", "orderId", "orderUpdateId"):
        if isinstance(event.data.get(key), (str, int)) and (event.topic == "order" or key == "headerId"):
            about[key] = str(event.data[key])[:256]
    if event.error.path:
        about["field"] = event.error.path
    change.report(Problem(ErrorType.VALIDATION, str(event.error), about))


def _instant(change: Transition, message: InstantActions) -> None:
    """A repeated message of a running action is ignored; another action with a used id is refused."""
    for action in message.actions:
        change.publish()
        known = change.state.action_state(action.id)
        if known is None:
            _take_instant(change, action, message.header)
        elif known.action != action or known.status.final:
            _refuse_reused_id(change, action, known, message.header)


def _take_instant(change: Transition, action: Action, header: int) -> None:
    """Obey a new action, let it wait, or fail it with a problem."""
    taken = change.add_instant_action(action)
    problem = instant_action_problem(action, change.state, header)
    if problem is not None:
        change.set_action(action.id, ActionStatus.FAILED, problem.description)
        change.report(problem)
    elif action.type in BUILT_IN:
        change.start_built_in(taken)
        _BUILT_IN[action.type](change, action)


def _refuse_reused_id(change: Transition, action: Action, known: ActionState, header: int) -> None:
    """Report an action with the id of another one as an error. startPause and cancelOrder are obeyed all the
    same, because the fleet manager wants the vehicle to stand."""
    text = (
        f"the actionId {action.id} was used before, by {known.action.type}, which is {known.status.value}; "
        "give each action an id of its own"
    )
    if action.type == "startPause":
        change.hold(Hold.PAUSED)
        text += "; the vehicle pauses all the same"
    elif action.type == "cancelOrder" and change.state.executing:
        change.give_up()
        text += "; the order is cancelled all the same"
    change.report(instant_problem(text, action, header, field="actionId"))


# -- built-in actions ----------------------------------------------------------------------------------------


def _cancel_order(change: Transition, action: Action) -> None:
    """A second cancelOrder joins the first; an order cleared by the operating mode cannot be cancelled."""
    state = change.state
    if not state.executing or (state.ending and not state.cancels):
        text = "there is no order to cancel"
        change.set_action(action.id, ActionStatus.FAILED, text)
        about = {"topic": "instantActions", "actionId": action.id}
        change.report(Problem(ErrorType.NO_ORDER_TO_CANCEL, text, about))
        return
    change.give_up(action.id)


def _stop_pause(change: Transition, action: Action) -> None:
    change.set_action(action.id, ActionStatus.FINISHED)
    change.release(Hold.PAUSED, Hold.HELD)
    end_pauses(change, ActionStatus.FAILED)
    change.forget_failures()


def _factsheet_request(change: Transition, action: Action) -> None:
    change.set_action(action.id, ActionStatus.FINISHED)
    change.request(PublishFactsheet())


_BUILT_IN: Mapping[str, Callable[[Transition, Action], None]] = {
    "cancelOrder": _cancel_order,
    "startPause": lambda change, action: change.hold(Hold.PAUSED),  # FINISHED when it stands: rules.py
    "stopPause": _stop_pause,
    "stateRequest": lambda change, action: change.set_action(action.id, ActionStatus.FINISHED),
    "factsheetRequest": _factsheet_request,
}


# -- measurements, and ends of drives and actions ------------------------------------------------------------


def _drive_ended(change: Transition, event: events.DriveEnded) -> None:
    drive = change.state.drive
    if drive is None or drive.token != event.token:
        return  # it was replaced
    too_fast, halted = change.state.too_fast, change.state.motion is Motion.HALTING
    change.change_motion(MotionEvent.ENDED if event.known else MotionEvent.NOT_KNOWN)
    if too_fast:
        change.update(too_fast="")
    if event.arrived and reached(change.state, drive.node):
        change.traverse()
    elif event.by_others:
        _hold_stopped(change, event.text)
    elif too_fast or not halted:
        text = too_fast or event.text or "it ended beside the node, out of the node's deviation range"
        change.drive_failed(drive, text)


def _drive_too_fast(change: Transition, event: events.DriveTooFast) -> None:
    """The drive is cancelled, reported, and tried again later."""
    state = change.state
    if state.drive is not None and state.motion is Motion.DRIVING and not state.too_fast:
        change.update(too_fast=event.text)
        about = change.order_references(nodeId=state.drive.node.id)
        change.report(Problem(ErrorType.SPEED, event.text, about))


def _stop_ended(change: Transition, event: events.StopEnded) -> None:
    if change.state.motion is not Motion.STOPPING:
        change.change_motion(MotionEvent.MOVED)
        return
    change.change_motion(MotionEvent.STOPPED if event.standing else MotionEvent.NOT_STOPPED)


def _action_ended(change: Transition, event: events.ActionEnded) -> None:
    ended = change.state.action_state(event.action_id)
    if ended is None or not ended.status.begun:
        return
    if change.state.moves(ended):
        change.change_motion(MotionEvent.MOVED if event.known else MotionEvent.NOT_KNOWN)
    change.set_action(event.action_id, ActionStatus.FINISHED if event.ok else ActionStatus.FAILED, event.text)
    if event.ok and ended.action.type == "initPosition" and not ended.of_order:
        last_node = str(ended.action.parameters.get("lastNodeId", ""))
        change.update(last_node=last_node, last_sequence=0)
    if not event.ok and not ended.ending:
        change.report_failed_action(ended, event.text)
        if event.by_others:
            _hold_stopped(change, event.text)


def _hold_stopped(change: Transition, text: str) -> None:
    """Somebody has stopped the robot: nothing that was asked for before moves it any more."""
    for each in change.state.instant_actions():
        if each.status is ActionStatus.WAITING and change.state.moves(each):
            never = "the robot was stopped before it began; send it again"
            change.set_action(each.action.id, ActionStatus.FAILED, never)
            change.report_failed_action(each, never)
    if change.state.executing and not change.state.ending:
        change.hold_order(f"somebody stopped the robot during this order, which waits now: {text}")


# -- the vehicle itself --------------------------------------------------------------------------------------


def _mode(change: Transition, event: events.ModeChanged) -> None:
    """The order is cleared when the fleet manager loses control (6.10.6)."""
    if event.mode == change.state.mode:
        return
    change.update(mode=event.mode)
    if not change.state.in_control and change.state.executing:
        change.give_up()
        text = f"the order was cleared, because the operating mode is {event.mode}; send a new one afterwards"
        change.report(Problem(ErrorType.ORDER, text, change.order_references()))


def _contact_changed(change: Transition, event: events.ContactChanged) -> None:
    """Whether contact was lost or regained, it is not known whether the robot stands."""
    change.update(heard=event.heard, stops=0)
    change.change_motion(MotionEvent.MOVED)


def _maps_changed(change: Transition, event: events.MapsChanged) -> None:
    change.update(limits=replace(change.state.limits, maps=event.maps))


def _disk_failed(change: Transition, event: events.DiskFailed) -> None:
    change.hold(Hold.DISK)
    change.set_problem("disk", event.problem)


def _restarted(change: Transition, event: events.Restarted) -> None:
    for each in change.state.action_states:
        if each.status.begun and each.action.type not in BUILT_IN:
            text = "the vehicle's software was restarted while it ran"
            change.set_action(each.action.id, ActionStatus.FAILED, text)
            change.report_failed_action(each, text)
    state = change.state
    pending = any(not each.status.final for each in state.actions_here())
    if (pending or any(node.released for node in state.nodes)) and not state.ending:
        change.hold_order(
            "the vehicle's software was restarted while it carried out this order, which waits now"
        )


def _shut_down(change: Transition, event: events.ShutDown) -> None:
    """Actions that have not ended fail."""
    if change.state.executing:
        if not change.state.ending:
            change.give_up()
        _fail_open_actions(change, event.text, of_order=True)
        if change.state.drive is not None:
            change.change_motion(MotionEvent.ENDED)
        change.forget(ActionStatus.FINISHED if change.state.at_rest else ActionStatus.FAILED)
        description = f"{event.text}; the order is over, send a new one"
        change.report(Problem(ErrorType.ORDER, description, change.order_references()))
    _fail_open_actions(change, event.text, of_order=False)


def _fail_open_actions(change: Transition, text: str, *, of_order: bool) -> None:
    for each in change.state.action_states:
        ours = each.action.type in BUILT_IN
        if each.of_order is of_order and not each.status.final and not ours:
            change.set_action(each.action.id, ActionStatus.FAILED, text)


_EVENTS: Mapping[type, Callable[[Transition, Any], None]] = {
    Order: _order,
    InstantActions: _instant,
    events.MalformedMessage: _malformed,
    events.PositionMeasured: lambda change, event: change.update(position=event.position),
    events.StandingMeasured: lambda change, event: change.change_motion(
        MotionEvent.STOOD if event.standing else MotionEvent.MOVED
    ),
    events.ContactChanged: _contact_changed,
    events.DriveEnded: _drive_ended,
    events.DriveTooFast: _drive_too_fast,
    events.StopEnded: _stop_ended,
    events.ActionEnded: _action_ended,
    events.StoppedByOthers: lambda change, event: _hold_stopped(change, "stop() was called"),
    events.RetryDue: lambda change, event: change.release(Hold.FAILED),
    events.ModeChanged: _mode,
    events.MapsChanged: _maps_changed,
    events.DiskFailed: _disk_failed,
    events.DiskRecovered: lambda change, event: change.release(Hold.DISK),
    events.ProblemChanged: lambda change, event: change.set_problem(event.key, event.problem),
    events.Restarted: _restarted,
    events.ShutDown: _shut_down,
}
