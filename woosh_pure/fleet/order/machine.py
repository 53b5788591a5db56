"""The order machine: `step` takes a state and an event, and gives the state after it and the effects. Pure:
no clock, no threads, no network.

An event is told to the function of its class, in the table at the end of this file; then `rules.py` decides
what follows. `rejection.py` decides which orders are taken. `transition.py` changes the state, by the tables
of `tables.py`.

Nothing moves because a program was started. An orderly end ends the order (`ShutDown`). After any other end
the order is here again (`Restarted`) and held: paused, in the words of the standard, with its actions held,
too, until the fleet manager says stopPause, or gives it up with cancelOrder. What moved the robot is stopped,
and what ran is FAILED then, because nobody knows how it ended; it does not begin again.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from woosh_pure.fleet.messages.elements import Action, InstantActions, Order
from woosh_pure.fleet.order import events
from woosh_pure.fleet.order.action_states import BUILT_IN, ActionState
from woosh_pure.fleet.order.errors import ErrorType, Level, Problem
from woosh_pure.fleet.order.events import Effect, Event, Factsheet
from woosh_pure.fleet.order.rejection import (
    instant_action_problem,
    rejection_of_new_order,
    rejection_of_update,
)
from woosh_pure.fleet.order.rules import end_pauses, follow, reached
from woosh_pure.fleet.order.state import OrderState
from woosh_pure.fleet.order.tables import ActionStatus, Hold, Motion, MotionEvent
from woosh_pure.fleet.order.transition import Transition


def step(state: OrderState, event: Event) -> tuple[OrderState, list[Effect]]:
    """What an event leads to: the state after it, and what is to be done, in this order (see `events.py`)."""
    now = Transition(state)
    _EVENTS[type(event)](now, event)
    follow(now)
    return now.result()


# -- messages ------------------------------------------------------------------------------------------------


def _order(now: Transition, order: Order) -> None:
    state = now.state
    same = order.id == state.order_id and bool(state.order_id)
    if same and order.update == state.update:
        now.tell()  # 6.6.4.3: ignored; the state tells the manager that it is here
        return
    problem = rejection_of_update(order, state) if same else rejection_of_new_order(order, state)
    if problem is not None:
        now.report(problem)
    elif same:
        now.extend(order)
    else:
        now.take(order)


def _malformed(now: Transition, event: events.MalformedMessage) -> None:
    about = [("topic", event.topic)]
    for key in ("headerId", "orderId", "orderUpdateId"):
        if isinstance(event.data.get(key), (str, int)) and (event.topic == "order" or key == "headerId"):
            about.append((key, str(event.data[key])[:256]))
    if event.error.path:
        about.append(("field", event.error.path))
    now.report(Problem(ErrorType.VALIDATION, str(event.error), tuple(about)))


def _instant(now: Transition, message: InstantActions) -> None:
    """One that is under way already came twice, and is done once; another one with an id that was used is
    refused."""
    for action in message.actions:
        now.tell()
        known = now.state.action_state(action.id)
        if known is None:
            _take_instant(now, action, message.header)
        elif known.action != action or known.status.final:
            _refuse_reused_id(now, action, known, message.header)


def _take_instant(now: Transition, action: Action, header: int) -> None:
    """One that is not known yet: obey it, let it wait for its turn, or fail it with a problem."""
    taken = now.add_instant_action(action)
    problem = instant_action_problem(action, now.state, header)
    if problem is not None:
        now.set_action(action.id, ActionStatus.FAILED, problem.description)
        now.report(problem)
    elif action.type in BUILT_IN:
        now.obey(taken)
        _BUILT_IN[action.type](now, action)


def _refuse_reused_id(now: Transition, action: Action, known: ActionState, header: int) -> None:
    """An action with the id of another one is told as an error. What stops is obeyed all the same, because a
    fleet manager that sends it wants the vehicle to stand."""
    text = (
        f"the actionId {action.id} was used before, by {known.action.type}, which is {known.status.value}; "
        "give each action an id of its own"
    )
    if action.type == "startPause":
        now.hold(Hold.PAUSED)
        text += "; the vehicle pauses all the same"
    elif action.type == "cancelOrder" and now.state.executing:
        now.give_up()
        text += "; the order is cancelled all the same"
    about = (("topic", "instantActions"), ("headerId", str(header)))
    more = (("actionId", action.id), ("actionType", action.type), ("field", "actionId"))
    now.report(Problem(ErrorType.INSTANT_ACTION, text, (*about, *more)))


# -- the actions that the machine does itself ----------------------------------------------------------------


def _cancel_order(now: Transition, action: Action) -> None:
    """A second one joins the first; an order that the operating mode has cleared is over already."""
    state = now.state
    if not state.executing or (state.ending and not state.cancels):
        text = "there is no order to cancel"
        now.set_action(action.id, ActionStatus.FAILED, text)
        about = (("topic", "instantActions"), ("actionId", action.id))
        now.report(Problem(ErrorType.NO_ORDER_TO_CANCEL, text, about))
        return
    now.give_up(action.id)


def _stop_pause(now: Transition, action: Action) -> None:
    now.set_action(action.id, ActionStatus.FINISHED)
    now.release(Hold.PAUSED, Hold.RESTARTED)
    end_pauses(now, ActionStatus.FAILED)
    now.forget_failures()


def _factsheet_request(now: Transition, action: Action) -> None:
    now.set_action(action.id, ActionStatus.FINISHED)
    now.ask(Factsheet())


_BUILT_IN: Mapping[str, Callable[[Transition, Action], None]] = {
    "cancelOrder": _cancel_order,
    "startPause": lambda now, action: now.hold(Hold.PAUSED),  # FINISHED when it stands: rules.py
    "stopPause": _stop_pause,
    "stateRequest": lambda now, action: now.set_action(action.id, ActionStatus.FINISHED),
    "factsheetRequest": _factsheet_request,
}


# -- what was measured, and what has ended -------------------------------------------------------------------


def _drive_ended(now: Transition, event: events.DriveEnded) -> None:
    drive = now.state.drive
    if drive is None or drive.token != event.token:
        return  # one that was replaced
    too_fast, halted = now.state.too_fast, now.state.motion is Motion.HALTING
    now.moved(MotionEvent.ENDED if event.known else MotionEvent.NOT_KNOWN)
    if too_fast:
        now.too_fast("")
    if event.arrived and reached(now.state, drive.node):
        now.traverse()
    elif too_fast or not halted:
        text = too_fast or event.text or "it ended beside the node, out of the node's deviation range"
        now.drive_failed(drive, text)


def _drive_too_fast(now: Transition, event: events.DriveTooFast) -> None:
    """It is ended, told, and tried again later."""
    state = now.state
    if state.drive is not None and state.motion is Motion.DRIVING and not state.too_fast:
        now.too_fast(event.text)
        about = (*now.about_order(), ("nodeId", state.drive.node.id))
        now.report(Problem(ErrorType.SPEED, event.text, about))


def _stop_ended(now: Transition, event: events.StopEnded) -> None:
    if now.state.motion is not Motion.STOPPING:
        now.moved(MotionEvent.MOVED)
        return
    now.moved(MotionEvent.STOPPED if event.standing else MotionEvent.NOT_STOPPED)


def _action_progress(now: Transition, event: events.ActionProgress) -> None:
    known = now.state.action_state(event.action_id)
    if known is not None and known.status.begun and event.status.begun:
        now.set_action(event.action_id, event.status)


def _action_ended(now: Transition, event: events.ActionEnded) -> None:
    ended = now.state.action_state(event.action_id)
    if ended is None or not ended.status.begun:
        return
    if now.state.moves(ended):
        now.moved(MotionEvent.MOVED if event.known else MotionEvent.NOT_KNOWN)
    now.set_action(event.action_id, ActionStatus.FINISHED if event.ok else ActionStatus.FAILED, event.text)
    if event.ok and ended.action.type == "initPosition" and not ended.of_order:
        now.set_last_node(str(ended.action.parameters.get("lastNodeId", "")))
    if not event.ok and not ended.ending:
        now.report_failed_action(ended, event.text)


# -- the vehicle itself --------------------------------------------------------------------------------------


def _mode(now: Transition, event: events.ModeChanged) -> None:
    """Where the fleet manager is not in control, its order is cleared (6.10.6)."""
    if event.mode == now.state.mode:
        return
    now.set_mode(event.mode)
    if not now.state.in_control and now.state.executing:
        now.give_up()
        text = f"the order was cleared, because the operating mode is {event.mode}; send a new one afterwards"
        now.report(Problem(ErrorType.ORDER, text, now.about_order()))


def _disk_failed(now: Transition, event: events.DiskFailed) -> None:
    now.hold(Hold.DISK)
    now.set_problem("disk", event.problem)


def _restarted(now: Transition, event: events.Restarted) -> None:
    for each in now.state.action_states:
        if each.status.begun and each.action.type not in BUILT_IN:
            text = "the vehicle's software was restarted while it ran"
            now.set_action(each.action.id, ActionStatus.FAILED, text)
            now.report_failed_action(each, text)
    state = now.state
    pending = any(not each.status.final for each in state.actions_here())
    if (pending or any(node.released for node in state.nodes)) and not state.ending:
        now.hold(Hold.RESTARTED)
        text = "the vehicle's software was restarted while it carried out this order, which waits now"
        hint = "stopPause goes on, cancelOrder gives it up"
        now.set_problem("held", Problem(ErrorType.HELD, text, now.about_order(), Level.WARNING, hint))


def _shut_down(now: Transition, event: events.ShutDown) -> None:
    """What has not ended has failed."""
    if now.state.executing:
        if not now.state.ending:
            now.give_up()
        _fail_open_actions(now, event.text, of_order=True)
        if now.state.drive is not None:
            now.moved(MotionEvent.ENDED)
        now.forget(ActionStatus.FINISHED if now.state.at_rest else ActionStatus.FAILED)
        told = f"{event.text}; the order is over, send a new one"
        now.report(Problem(ErrorType.ORDER, told, now.about_order()))
    _fail_open_actions(now, event.text, of_order=False)


def _fail_open_actions(now: Transition, text: str, *, of_order: bool) -> None:
    for each in now.state.action_states:
        ours = each.action.type in BUILT_IN
        if each.of_order is of_order and not each.status.final and not ours:
            now.set_action(each.action.id, ActionStatus.FAILED, text)


_EVENTS: Mapping[type, Callable[[Transition, Any], None]] = {
    Order: _order,
    InstantActions: _instant,
    events.MalformedMessage: _malformed,
    events.PositionMeasured: lambda now, event: now.set_position(event.position),
    events.StandingMeasured: lambda now, event: now.moved(
        MotionEvent.STOOD if event.standing else MotionEvent.MOVED
    ),
    events.Heard: lambda now, event: now.set_heard(event.heard),
    events.DriveEnded: _drive_ended,
    events.DriveTooFast: _drive_too_fast,
    events.StopEnded: _stop_ended,
    events.ActionProgress: _action_progress,
    events.ActionEnded: _action_ended,
    events.RetryDue: lambda now, event: now.release(Hold.FAILED),
    events.ModeChanged: _mode,
    events.MapsChanged: lambda now, event: now.set_maps(event.maps),
    events.DiskFailed: _disk_failed,
    events.DiskRecovered: lambda now, event: now.release(Hold.DISK),
    events.ProblemChanged: lambda now, event: now.set_problem(event.key, event.problem),
    events.Restarted: _restarted,
    events.ShutDown: _shut_down,
}
