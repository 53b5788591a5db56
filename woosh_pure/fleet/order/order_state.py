"""Everything that the order machine knows, and the questions that its parts ask of it. Pure.

What changes it stands in `machine.py` (what comes in), `execution.py` (what follows from it) and
`instant_actions.py`; what of it outlives the process, in `persistence.py`.
"""

from __future__ import annotations

import copy
from collections.abc import Iterable
from dataclasses import replace
from typing import TypeVar

from woosh_pure.fleet.messages.elements import Edge, Node
from woosh_pure.fleet.order.actions import BUILT_IN, ActionState, Scope, effective_blocking, holds_driving
from woosh_pure.fleet.order.deviation import AgvPosition, on_other_map
from woosh_pure.fleet.order.effects import Drive, Effect
from woosh_pure.fleet.order.errors import ErrorType, Problem, Problems
from woosh_pure.fleet.order.limits import Limits
from woosh_pure.fleet.order.operating_mode import DRIVING_MODES

__all__ = ["OrderState", "without"]

MOST_ACTION_STATES = 1000
"""Ended actions that are remembered; one that runs is never forgotten."""
MOST_REQUESTS = 32
"""Ended requests for a state or the factsheet that are remembered."""
REQUESTS = ("stateRequest", "factsheetRequest")

State = TypeVar("State", bound="OrderState")


class OrderState:
    """One vehicle's order, its actions, and what keeps it from driving.

    Args:
        limits: What the vehicle is able to obey; its abilities need not include the built-in actions.

    Attributes:
        order_id, update, last_node, last_sequence: As the state message has them.
        nodes, edges: Those that are still to be traversed.
        action_states: Of the order and of instant actions, in the order in which they came.
        problems: What the state message tells under `errors`.
        paused: startPause was obeyed, and stopPause has not come.
        held: The order was restored after a restart, and waits for stopPause or cancelOrder.
        mode: The operating mode; SERVICE until the vehicle has told it, so that nothing moves before.
        position: The measured one; None while the vehicle does not know where it is.
        closed: The order was cancelled or cleared: no update of it is taken.
        cancelling: It was, and not everything has ended yet.
        cancels: Ids of the cancelOrder actions that wait for that.
        on_edge: The edge to the next node was entered: its actions may begin.
        failures: How often the drive to the next node has failed.
        blocked: A drive has failed, and is not tried again yet.
        standing: It was measured standing after the last end of what moves it.
        unknown: How a drive or a moving action ended is not known: all is stopped as soon as the robot is
            heard, and nothing begins before.
        heard: Whether the robot is heard.
        stopping: It is being stopped because of that.
        stops: How often that was tried.
        too_fast: How the drive under way was faster than its edge allows, so that it is being ended; or "".
        unsaved: Nothing can be put on disk: what began now might begin again after a restart.
        drive: The one that was given out and has not ended.
        halting: It was asked to end.
        drive_is_new: It was given out by the input that is being handled: each node is told by itself.
        effects, changed: What the input that is being handled asks for, and whether the state message
            changes.
    """

    def __init__(self, limits: Limits) -> None:
        self.limits = replace(limits, abilities={**limits.abilities, **BUILT_IN})
        self.order_id, self.update = "", 0
        self.last_node, self.last_sequence = "", 0
        self.nodes: list[Node] = []
        self.edges: list[Edge] = []
        self.action_states: list[ActionState] = []
        self.problems = Problems()
        self.paused = False
        self.held = False
        self.mode = "SERVICE"
        self.position: AgvPosition | None = None
        self.closed = False
        self.cancelling = False
        self.cancels: list[str] = []
        self.on_edge = False
        self.failures = 0
        self.blocked = False
        self.standing = self.unknown = self.stopping = False
        self.heard = True
        self.stops = 0
        self.too_fast = ""
        self.unsaved = False
        self.last_token = 0
        self.drive: Drive | None = None
        self.halting = False
        self.drive_is_new = False
        self.effects: list[Effect] = []
        self.changed = False

    # -- what the state message tells ------------------------------------------------------------------------

    @property
    def executing(self) -> bool:
        """Whether an order is carried out, waits for an update, or is being cancelled (figure 8, 3)."""
        if self.nodes or self.cancelling:
            return True
        return any(a.of_order and not a.status.final for a in self.action_states)

    @property
    def driving(self) -> bool:
        """Whether a drive was given out that has not ended."""
        return self.drive is not None

    @property
    def wants_base(self) -> bool:
        """`newBaseRequest`: there is a horizon, and the last node of the base is the next, or reached."""
        released = sum(node.released for node in self.nodes)
        return len(self.nodes) > released and released <= 1 and not self.cancelling

    @property
    def decision_point(self) -> tuple[str, int]:
        """Id and sequence of the last node of the base."""
        base = [node for node in self.nodes if node.released]
        return (base[-1].id, base[-1].sequence) if base else (self.last_node, self.last_sequence)

    @property
    def in_control(self) -> bool:
        """Whether the operating mode lets the fleet manager command the vehicle."""
        return self.mode in DRIVING_MODES

    # -- its actions -----------------------------------------------------------------------------------------

    def action_state(self, action_id: str) -> ActionState | None:
        """How an action stands; None when it is not known."""
        return next((each for each in self.action_states if each.action.id == action_id), None)

    def actions_of_horizon(self) -> list[ActionState]:
        """The actions of what is not released."""
        elements: list[Node | Edge] = [*self.nodes, *self.edges]
        ahead = {each.sequence for each in elements if not each.released}
        return [each for each in self.action_states if each.of_order and each.sequence in ahead]

    def actions_here(self) -> list[ActionState]:
        """The actions of the node it is on, and of the edge that it has entered."""
        places = {(Scope.NODE, self.last_sequence)}
        if self.on_edge and self.nodes and self.has_edge_to(self.nodes[0]):
            places.add((Scope.EDGE, self.edges[0].sequence))
        # The first node of an order has a sequence that `last_sequence` may have by chance.
        ahead = {node.sequence for node in self.nodes}
        return [a for a in self.action_states if (a.scope, a.sequence) in places and a.sequence not in ahead]

    def instant_actions(self) -> list[ActionState]:
        """Those that are not built in."""
        return [a for a in self.action_states if not a.of_order and a.action.type not in BUILT_IN]

    def add_actions(self, nodes: Iterable[Node], edges: Iterable[Edge]) -> None:
        """States for the actions of new nodes and edges, in the order in which they come."""
        elements: list[Node | Edge] = [*nodes, *edges]
        for element in sorted(elements, key=lambda each: each.sequence):
            scope = Scope.NODE if isinstance(element, Node) else Scope.EDGE
            for action in element.actions:
                blocking = effective_blocking(action, self.limits.abilities.get(action.type))
                self.action_states.append(ActionState(action, scope, element.sequence, blocking))
        self.forget_old_actions()

    def forget_old_actions(self) -> None:
        """Keep as many action states as there may be. Each state message has them all, so that those of mere
        requests are soon forgotten."""
        requests = [a for a in self.action_states if a.action.type in REQUESTS and a.status.final]
        if len(requests) > MOST_REQUESTS:
            self.action_states = without(self.action_states, requests[:-MOST_REQUESTS])
        over = len(self.action_states) - MOST_ACTION_STATES
        if over > 0:
            old = [each for each in self.action_states if each.status.final][:over]
            self.action_states = without(self.action_states, old)

    def moves(self, state: ActionState) -> bool:
        """Whether an action moves the robot by itself."""
        ability = self.limits.abilities.get(state.action.type)
        return ability is not None and ability.moves

    # -- whether it may drive --------------------------------------------------------------------------------

    def has_edge_to(self, node: Node) -> bool:
        """Whether an edge leads to the next node: then it is driven to, even when the vehicle is there."""
        return bool(self.edges) and self.edges[0].sequence < node.sequence

    def is_held_back(self) -> bool:
        """Whether something that is no action keeps it from driving."""
        if self.unknown or self.too_fast:
            return True
        return self.paused or self.held or self.blocked or not self.in_control or (
            self.position is None and bool(self.nodes) and self.nodes[0].position is not None
        ) or self.is_on_other_map()  # fmt: skip

    def is_on_other_map(self) -> bool:
        """Whether the next node is on a map that the vehicle does not use now."""
        return bool(self.nodes) and self.position is not None and on_other_map(self.position, self.nodes[0])

    @property
    def maps(self) -> set[str]:
        """Ids of the maps that the order needs: the one in use (any, if nobody knows which), and those of the
        nodes to come."""
        used = self.position.map_id if self.position is not None else ""
        found = {node.position.map_id for node in self.nodes if node.position is not None}
        return found | ({used} if used else set(self.limits.maps))

    def may_drive(self) -> bool:
        """Whether neither an action nor anything else keeps it from driving."""
        return not self.is_held_back() and not holds_driving((*self.actions_here(), *self.instant_actions()))

    @property
    def at_rest(self) -> bool:
        """Whether the vehicle was measured standing, and nothing of ours moves it."""
        return self.standing and not (self.unknown or self.drive is not None or self.is_moved_by_action())

    def is_moved_by_action(self) -> bool:
        """Whether an action runs that moves the robot by itself."""
        return any(each.status.begun and self.moves(each) for each in self.action_states)

    @property
    def waits_for_rest(self) -> bool:
        """Whether a cancel or a pause is not FINISHED only because the vehicle is not measured standing."""
        waits = self.cancelling or any(
            a.action.type == "startPause" and a.status.begun for a in self.action_states
        )
        return waits and self.drive is None and not self.standing

    # -- for its parts ---------------------------------------------------------------------------------------

    def add_problem(self, problem: Problem) -> None:
        """Tell a problem until an order is accepted."""
        self.problems.add(problem)
        self.changed = True

    def tell_failed_action(self, failed: ActionState, text: str) -> None:
        """Tell that an action has failed."""
        about = (
            ("topic", "order" if failed.of_order else "instantActions"),
            ("actionId", failed.action.id),
            ("actionType", failed.action.type),
        )
        kind = ErrorType.ORDER_ACTION if failed.of_order else ErrorType.INSTANT_ACTION
        text = f"{failed.action.type} has failed: {text or 'no reason was given'}"
        self.add_problem(Problem(kind, text, about))

    def trial_copy(self: State) -> State:
        """A copy to try an order with; nothing of it is carried out."""
        found = copy.copy(self)
        found.nodes, found.edges, found.cancels = list(self.nodes), list(self.edges), list(self.cancels)
        found.action_states = [copy.copy(each) for each in self.action_states]
        found.problems, found.effects = copy.deepcopy(self.problems), []
        return found


def without(states: list[ActionState], gone: list[ActionState]) -> list[ActionState]:
    """A list of action states without some of them."""
    left_out = {id(each) for each in gone}
    return [each for each in states if id(each) not in left_out]
