"""What the vehicle does next: these rules are applied after every event of the order machine. Pure.

    when                                           then
    ----------------------------------------------------------------------------------------------------
    the end of a motion is not known               stop everything as soon as there is contact with the robot
    the order is cancelled or cleared              halt; forget the order when its actions have ended and
                                                   the vehicle stands
    local or instant actions may begin             begin them (in the order of `action_states.may_begin`)
    a hold, or a SOFT or HARD action, prevents     halt
    driving
    the next node is released, nothing prevents    enter its edge, begin the edge's actions, drive to the node
    driving
    no released node is ahead                      stand

A node is traversed when the measured position is within its deviation range. If the vehicle passes it without
a stop, this is sufficient, and the next drive replaces the current one. If the vehicle stops there (end of
the base, or an action that requires it to stand), the drive must have ended, too. Only the next node is
checked, so that none is skipped. Traversing a node leaves the edge before it: the edge's actions are ended.

SOFT and HARD actions, cancels and pauses wait until the vehicle is measured standing. Every action begins
once: it is RUNNING and saved before it is started.
"""

from __future__ import annotations

from collections.abc import Sequence

from woosh_pure.fleet.messages.elements import Node
from woosh_pure.fleet.order.action_states import BUILT_IN, ActionState, Scope, may_begin
from woosh_pure.fleet.order.errors import ErrorType, Level, Problem
from woosh_pure.fleet.order.events import Drive
from woosh_pure.fleet.order.state import OrderState
from woosh_pure.fleet.order.tables import ActionStatus, Activity, Motion
from woosh_pure.fleet.order.transition import Transition
from woosh_pure.fleet.order.vehicle_limits import on_other_map, within_deviation


def follow(change: Transition) -> None:
    """Apply the rules until none applies any more."""
    while _one_row(change):
        pass
    change.set_problem("map", _wrong_map(change.state))


def _one_row(change: Transition) -> bool:
    """Apply one rule; True if another one may apply afterwards."""
    if change.state.at_rest:
        end_pauses(change, ActionStatus.FINISHED)
    if change.state.motion is Motion.UNKNOWN and change.state.heard:
        change.stop_all()
    if change.state.ending:
        return _end_order(change)
    state = change.state
    if state.drive is not None and state.motion is Motion.DRIVING and _passes_by(change, state.drive):
        return True
    if _begin_actions(change):
        return True
    state = change.state
    if state.drive is not None:
        if state.motion is Motion.DRIVING and (
            state.prevents(Activity.CONTINUE_DRIVE) or state.waits_for_actions
        ):
            change.halt()
            return True
        return False
    if not (state.nodes and state.nodes[0].released and _may_drive(state)):
        return False
    if not state.on_edge:
        change.update(on_edge=True)
        return True
    node = state.nodes[0]
    if within_deviation(state.position, node, state.limits) and not state.has_edge_to(node):
        change.traverse()  # the first node of an order, or one that another drive passed
        return True
    change.drive_to(node)
    return False


def _end_order(change: Transition) -> bool:
    """End an order that was given up; True if it is forgotten. An order cleared by the operating mode does
    not wait until the vehicle stands, because a person may be driving it."""
    state = change.state
    if state.drive is not None:
        if state.motion is Motion.DRIVING:
            change.halt()
        return False
    known = state.motion not in (Motion.UNKNOWN, Motion.STOPPING)
    if not (state.at_rest or (known and not state.cancels and not state.in_control)):
        return False
    if state.action_states.open_of_order:
        return False
    change.forget(ActionStatus.FINISHED)
    return True


def end_pauses(change: Transition, status: ActionStatus) -> None:
    """End the running startPause actions: FINISHED when the vehicle stands, FAILED after stopPause."""
    for each in change.state.action_states.running:
        if each.action.type == "startPause":
            change.set_action(each.action.id, status)


# -- driving -------------------------------------------------------------------------------------------------


def reached(state: OrderState, node: Node) -> bool:
    """Whether a drive that arrived is at its node. The position of a mark is known to the chassis only."""
    return bool(state.nodes) and state.nodes[0] is node and (
        node.position is None or within_deviation(state.position, node, state.limits)
    )  # fmt: skip


def _may_drive(state: OrderState) -> bool:
    return not (state.prevents(Activity.START_DRIVE) or state.waits_for_actions)


def _passes_by(change: Transition, drive: Drive) -> bool:
    """Traverse the next node if the vehicle is within range and goes on without a stop; whether it did."""
    state, node = change.state, drive.node
    if change.drive_is_new or state.prevents(Activity.START_DRIVE):
        return False
    if not (goes_on_from(state, node) and reached(state, node)):
        return False
    change.traverse()
    while _begin_actions(change):
        pass
    change.update(on_edge=True)
    while _begin_actions(change):
        pass
    if _may_drive(change.state):
        change.drive_to(change.state.nodes[0])
    else:
        change.halt()
    return True


def goes_on_from(state: OrderState, node: Node) -> bool:
    """Whether the vehicle goes on from a node without a stop."""
    if len(state.nodes) < 2 or not state.nodes[1].released:
        return False
    if node.position is None or not node.position.deviation_xy > 0:
        return False
    if state.position is not None and on_other_map(state.position, state.nodes[1]):
        return False
    known = state.action_states
    here = (*known.at(Scope.NODE, node.sequence), *known.at(Scope.EDGE, node.sequence + 1))
    return not any(each.stands_still for each in here)


def _wrong_map(state: OrderState) -> Problem | None:
    """The problem if no action has changed to the map of the next node."""
    if not (state.is_on_other_map and state.nodes[0].released) or state.held or state.ending:
        return None
    if any(not each.status.final for each in state.actions_here()):
        return None
    node, used = state.nodes[0], state.position.map_id if state.position is not None else ""
    map_id = node.position.map_id if node.position is not None else ""
    return Problem(
        ErrorType.DRIVE,
        f"node {node.id} is on the map {map_id}, the vehicle on {used}; no initPosition has changed it",
        {"orderId": state.order_id, "nodeId": node.id, "mapId": map_id},
        Level.FATAL,
        "cancelOrder gives the order up; then initPosition takes the vehicle to the other map",
    )


# -- actions -------------------------------------------------------------------------------------------------


def _begin_actions(change: Transition) -> bool:
    """Begin the first action that may begin; whether there was one."""
    state = change.state
    return _begin_one(change, state.instant_actions()) or _begin_one(change, state.actions_here())


def _begin_one(change: Transition, group: Sequence[ActionState]) -> bool:
    if not any(each.status is ActionStatus.WAITING for each in group):
        return False
    state, own = change.state, {id(each) for each in group}
    others = [a for a in state.action_states.running if id(a) not in own and a.action.type not in BUILT_IN]
    ready = may_begin(group, others, standing=state.at_rest)
    if not ready:
        return False
    each = ready[0]
    needed = [
        Activity.START_ORDER_ACTION if each.of_order else Activity.START_INSTANT_ACTION,
        *[Activity.START_MOVING_ACTION] * state.moves(each),
    ]
    if any(state.prevents(what) for what in needed):
        return False
    change.begin(each)
    return True
