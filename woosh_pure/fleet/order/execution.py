"""What the vehicle does next: the table that every input of the order machine ends in. Pure.

    when                                           then
    ----------------------------------------------------------------------------------------------------
    how a drive ended is not known                 stop everything as soon as the robot is heard
    an order is cancelled or cleared               halt; end its actions; when all has ended and the vehicle
                                                   stands, forget it
    actions here or instant ones may begin         begin them (`actions.may_begin` has their order)
    something holds: pause, mode, no position,     halt
      another map, a failed drive, a SOFT or
      HARD action
    nothing can be kept on disk                    drive on to the node under way; begin nothing else
    the next node is released, none holds          enter its edge, begin the edge's actions, drive to it
    the next node is not released, or none is      stand

A node is traversed when the measured position is in its deviation range. Where the vehicle goes on without a
stop that is enough, and the next drive replaces the one under way; where it stops (the end of the base, an
action that wants it to stand), the drive must have ended, too. Only the next node is ever looked at, so none
is skipped. With a node the edge before it is left: what runs on the edge is ended.

That a drive has ended does not say that the vehicle stands: `standing` does, which is measured after the end.
SOFT and HARD actions, cancels and pauses wait for it.

Every action begins once: it is RUNNING before the effect is given out, `Changed` comes first, and whoever
carries effects out puts the machine on disk at `Changed`.
"""

from __future__ import annotations

from woosh_pure.fleet.messages.elements import Node
from woosh_pure.fleet.order.actions import BUILT_IN, ActionStatus, Scope, may_begin
from woosh_pure.fleet.order.cancelling import finish_cancelling, request_end
from woosh_pure.fleet.order.deviation import within_deviation
from woosh_pure.fleet.order.effects import Begin, Changed, Drive, Effect, Halt, StopAll
from woosh_pure.fleet.order.errors import ErrorType, Level, Problem
from woosh_pure.fleet.order.order_state import OrderState, without
from woosh_pure.fleet.order.pause import finish_pauses

__all__ = ["next_effects", "reached", "traverse"]

STOP_AGAIN = 2.0
"""Seconds until a robot that did not come to a stand is stopped once more."""


def next_effects(state: OrderState) -> list[Effect]:
    """Go through the table until nothing follows any more; the effects of this input."""
    state.drive_is_new = False
    while _step(state):
        pass
    _tell_map(state)
    effects: list[Effect] = [Changed(), *state.effects] if state.changed else list(state.effects)
    state.effects, state.changed = [], False
    return effects


def _step(state: OrderState) -> bool:
    """One row of the table; True when something was done that lets another follow."""
    finish_pauses(state)
    _stop_what_is_not_known(state)
    if state.cancelling:
        return _step_to_the_end(state)
    if state.drive is not None and not state.halting and _passes_by(state, state.drive):
        return True
    if _begin_actions(state):
        return True
    if state.drive is not None:
        if not state.may_drive() and not state.halting:
            _halt(state)
            return True
        return False
    if state.unsaved or not (state.nodes and state.nodes[0].released and state.may_drive()):
        return False
    if not state.on_edge:
        state.on_edge = True  # its actions begin before the vehicle does
        return True
    node = state.nodes[0]
    if within_deviation(state.position, node, state.limits) and not state.has_edge_to(node):
        traverse(state)  # the first node of an order, or one that another drive came by
        return True
    _drive_to(state, node)
    return False


def _stop_what_is_not_known(state: OrderState) -> None:
    if state.unknown and state.heard and not state.stopping and state.drive is None:
        state.stopping = True
        state.effects.append(StopAll(STOP_AGAIN if state.stops else 0.0))
        state.stops += 1


def _step_to_the_end(state: OrderState) -> bool:
    if state.drive is not None:
        if not state.halting:
            _halt(state)
        return False
    return finish_cancelling(state)


# -- driving -------------------------------------------------------------------------------------------------


def reached(state: OrderState, node: Node) -> bool:
    """Whether a drive that arrived did so at its node; where a mark is, only the chassis knows."""
    return bool(state.nodes) and state.nodes[0] is node and (
        node.position is None or within_deviation(state.position, node, state.limits)
    )  # fmt: skip


def traverse(state: OrderState) -> None:
    """The next node is reached: its edge is left, its actions are here now."""
    node = state.nodes.pop(0)
    if state.edges and state.edges[0].sequence < node.sequence:
        state.edges.pop(0)
    for each in state.action_states:
        if each.scope is Scope.EDGE and each.sequence < node.sequence and not each.status.final:
            request_end(state, each, failed=False)
    state.last_node, state.last_sequence = node.id, node.sequence
    state.on_edge = False
    state.failures = 0
    state.changed = True


def _passes_by(state: OrderState, drive: Drive) -> bool:
    """Traverse the node under way where the vehicle is near enough and goes on; whether it did."""
    node = drive.node
    if state.drive_is_new or state.unsaved or state.is_held_back():
        return False
    if not (_goes_on_from(state, node) and reached(state, node)):
        return False
    traverse(state)
    while _begin_actions(state):
        pass
    state.on_edge = True
    while _begin_actions(state):
        pass
    if state.may_drive():
        _drive_to(state, state.nodes[0])
    else:
        _halt(state)
    return True


def _goes_on_from(state: OrderState, node: Node) -> bool:
    """Whether the vehicle goes on from the node under way without a stop."""
    if state.cancelling or len(state.nodes) < 2 or not state.nodes[1].released:
        return False
    if node.position is None or not node.position.deviation_xy > 0:
        return False
    sequences = (node.sequence, node.sequence + 1)
    here = [a for a in state.action_states if a.of_order and a.sequence in sequences]
    return not any(each.stands_still for each in here)


def _drive_to(state: OrderState, node: Node) -> None:
    state.last_token += 1
    edge = state.edges[0] if state.has_edge_to(node) else None
    state.drive, state.halting, state.changed = Drive(state.last_token, node, edge), False, True
    state.drive_is_new, state.standing = True, False
    state.effects.append(state.drive)


def _halt(state: OrderState) -> None:
    assert state.drive is not None
    state.halting = True
    state.effects.append(Halt(state.drive.token))


def _tell_map(state: OrderState) -> None:
    """Say that the vehicle cannot go on, because no action has taken it to the map of the next node."""
    problem = None
    pending = any(not each.status.final for each in state.actions_here())
    if (
        state.is_on_other_map()
        and state.nodes[0].released
        and not (pending or state.held or state.cancelling)
    ):
        node, used = state.nodes[0], state.position.map_id if state.position is not None else ""
        map_id = node.position.map_id if node.position is not None else ""
        problem = Problem(
            ErrorType.DRIVE,
            f"node {node.id} is on the map {map_id}, the vehicle on {used}; no initPosition has changed it",
            (("orderId", state.order_id), ("nodeId", node.id), ("mapId", map_id)),
            Level.FATAL,
            "cancelOrder gives the order up; then initPosition takes the vehicle to the other map",
        )
    state.changed |= state.problems.set("map", problem)


# -- actions -------------------------------------------------------------------------------------------------


def _begin_actions(state: OrderState) -> bool:
    if state.unsaved:
        return False
    for group in (state.instant_actions(), state.actions_here()):
        others = [a for a in without(state.action_states, group) if a.action.type not in BUILT_IN]
        for each in may_begin(group, others, standing=state.at_rest):
            if state.paused and state.moves(each):
                break
            if each.of_order and (state.held or not state.in_control):
                break
            each.status, state.changed = ActionStatus.RUNNING, True
            if state.moves(each):
                state.standing = False
            state.effects.append(Begin(each.action, each.scope))
            return True
    return False
