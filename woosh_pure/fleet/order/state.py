"""Everything that the order machine knows, as a frozen value, and the questions that its parts ask of it.
Pure.

`transition.py` makes changed ones; nobody else does. What of it outlives the process is `kept`, and `to_json`
on disk.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from woosh_pure.fleet.messages.elements import Edge, Node
from woosh_pure.fleet.messages.parsing import read_edge, read_node
from woosh_pure.fleet.order.action_states import BUILT_IN, ActionState, Scope, holds_driving
from woosh_pure.fleet.order.errors import Problem, Problems
from woosh_pure.fleet.order.events import Drive
from woosh_pure.fleet.order.tables import PREVENTED_ACTIVITIES, Activity, Hold, Motion, OrderPhase
from woosh_pure.fleet.order.vehicle_limits import AgvPosition, Capabilities, on_other_map

DRIVING_MODES = ("AUTOMATIC", "SEMIAUTOMATIC")
"""Operating modes (6.10.6) in which the fleet manager is in control."""


class OrderState(NamedTuple):
    """One vehicle's order, its actions, and what keeps it from driving.

    Attributes:
        limits: What the vehicle is able to obey, the built-in actions among it.
        order_id, update, last_node, last_sequence: As the state message has them.
        nodes, edges: Those that are still to be traversed.
        action_states: Of the order and of instant actions, in the order in which they came.
        problems: What the state message tells under `errors`.
        phase: What becomes of the order.
        cancels: Ids of the cancelOrder actions that wait for its end.
        motion: Whether the vehicle moves because of us.
        drive: The one that was given out and has not ended.
        last_token: Of the newest drive.
        set_holds: Those that stay until an event takes them away; see `holds`.
        too_fast: How the drive under way was faster than its edge allows, so that it is being ended; or "".
        failures: How often the drive to the next node has failed.
        on_edge: The edge to the next node was entered: its actions may begin.
        heard: Whether the robot is heard.
        stops: How often it was told to stop because an end is not known.
        mode: The operating mode; SERVICE until the vehicle has told it, so that nothing moves before.
        position: The measured one; None while the vehicle does not know where it is.
    """

    limits: Capabilities
    order_id: str = ""
    update: int = 0
    last_node: str = ""
    last_sequence: int = 0
    nodes: tuple[Node, ...] = ()
    edges: tuple[Edge, ...] = ()
    action_states: tuple[ActionState, ...] = ()
    problems: Problems = Problems()
    phase: OrderPhase = OrderPhase.OPEN
    cancels: tuple[str, ...] = ()
    motion: Motion = Motion.SETTLING
    drive: Drive | None = None
    last_token: int = 0
    set_holds: frozenset[Hold] = frozenset()
    too_fast: str = ""
    failures: int = 0
    on_edge: bool = False
    heard: bool = True
    stops: int = 0
    mode: str = "SERVICE"
    position: AgvPosition | None = None

    # -- what the state message tells ------------------------------------------------------------------------

    @property
    def executing(self) -> bool:
        """Whether an order is carried out, waits for an update, or is being cancelled (figure 8, 3)."""
        if self.nodes or self.ending:
            return True
        return any(each.of_order and not each.status.final for each in self.action_states)

    @property
    def ending(self) -> bool:
        """Whether it was cancelled or cleared, and not everything has ended yet."""
        return self.phase is OrderPhase.ENDING

    @property
    def paused(self) -> bool:
        """Whether startPause was obeyed, and stopPause has not come."""
        return Hold.PAUSED in self.set_holds

    @property
    def held(self) -> bool:
        """Whether the order was restored after a restart, and waits for stopPause or cancelOrder."""
        return Hold.RESTARTED in self.set_holds

    @property
    def driving(self) -> bool:
        """Whether a drive was given out that has not ended."""
        return self.drive is not None

    @property
    def wants_base(self) -> bool:
        """`newBaseRequest`: there is a horizon, and the last node of the base is the next, or reached."""
        released = sum(node.released for node in self.nodes)
        return len(self.nodes) > released and released <= 1 and not self.ending

    @property
    def decision_point(self) -> tuple[str, int]:
        """Id and sequence of the last node of the base."""
        base = [node for node in self.nodes if node.released]
        return (base[-1].id, base[-1].sequence) if base else (self.last_node, self.last_sequence)

    @property
    def in_control(self) -> bool:
        """Whether the operating mode lets the fleet manager command the vehicle."""
        return self.mode in DRIVING_MODES

    @property
    def kept(self) -> tuple[object, ...]:
        """What must outlive the process: when it differs, the state is written."""
        return (
            self.order_id, self.update, self.last_node, self.last_sequence, self.nodes, self.edges,
            self.action_states, self.problems.of_orders, self.phase, self.cancels, self.on_edge, self.paused,
            self.may_be_moved,
        )  # fmt: skip

    @property
    def shown(self) -> tuple[object, ...]:
        """What others are told beside that: when it differs, too, a state is published."""
        return (
            self.problems.standing, self.held, self.mode, self.driving, self.position is None,
        )  # fmt: skip

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
        places = {Scope.NODE: self.last_sequence}
        if self.on_edge and self.nodes and self.has_edge_to(self.nodes[0]):
            places[Scope.EDGE] = self.edges[0].sequence
        found = [a for a in self.action_states if a.sequence == places.get(a.scope)]
        # The first node of an order has a sequence that `last_sequence` may have by chance.
        ahead = {node.sequence for node in self.nodes} if found else ()
        return [a for a in found if a.sequence not in ahead]

    def instant_actions(self) -> list[ActionState]:
        """Those that are not built in."""
        return [a for a in self.action_states if not a.of_order and a.action.type not in BUILT_IN]

    def moves(self, state: ActionState) -> bool:
        """Whether an action moves the robot by itself."""
        supported = self.limits.actions.get(state.action.type)
        return supported is not None and supported.moves

    # -- whether it may drive --------------------------------------------------------------------------------

    @property
    def holds(self) -> set[Hold]:
        """What keeps the vehicle from something now."""
        found = set(self.set_holds)
        if self.too_fast:
            found.add(Hold.TOO_FAST)
        if not self.in_control:
            found.add(Hold.MODE)
        if self.position is None and self.nodes and self.nodes[0].position is not None:
            found.add(Hold.NO_POSITION)
        if self.is_on_other_map:
            found.add(Hold.OTHER_MAP)
        if self.motion in (Motion.UNKNOWN, Motion.STOPPING):
            found.add(Hold.UNKNOWN_MOTION)
        return found

    def prevents(self, what: Activity) -> bool:
        """Whether a hold keeps the vehicle from something."""
        return any(what in PREVENTED_ACTIVITIES[hold] for hold in self.holds)

    def has_edge_to(self, node: Node) -> bool:
        """Whether an edge leads to the next node: then it is driven to, even when the vehicle is there."""
        return bool(self.edges) and self.edges[0].sequence < node.sequence

    @property
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

    @property
    def waits_for_actions(self) -> bool:
        """Whether an action wants the vehicle to stay where it is."""
        return holds_driving((*self.actions_here(), *self.instant_actions()))

    @property
    def standing(self) -> bool:
        """Whether it was measured standing after the last end of what moves it."""
        return self.motion is Motion.STANDING

    @property
    def at_rest(self) -> bool:
        """Whether the vehicle was measured standing, and nothing of ours moves it."""
        return self.standing and not self.is_moved_by_action

    @property
    def is_moved_by_action(self) -> bool:
        """Whether an action runs that moves the robot by itself."""
        return any(each.status.begun and self.moves(each) for each in self.action_states)

    @property
    def may_be_moved(self) -> bool:
        """Whether something of ours moves the robot, or may."""
        return self.motion not in (Motion.STANDING, Motion.SETTLING) or self.is_moved_by_action

    @property
    def waits_for_rest(self) -> bool:
        """Whether a cancel or a pause is not FINISHED only because the vehicle is not measured standing."""
        waits = self.ending or any(
            a.action.type == "startPause" and a.status.begun for a in self.action_states
        )
        return waits and self.drive is None and not self.standing

    # -- the disk --------------------------------------------------------------------------------------------

    def to_json(self) -> dict[str, Any]:
        """Everything that must outlive this process, as a JSON object."""
        return {
            "orderId": self.order_id, "orderUpdateId": self.update, "lastNodeId": self.last_node,
            "lastNodeSequenceId": self.last_sequence, "nodes": [node.to_json() for node in self.nodes],
            "edges": [edge.to_json() for edge in self.edges],
            "records": [each.to_json() for each in self.action_states],
            "problems": [problem.to_json() for problem in self.problems.of_orders], "paused": self.paused,
            "closed": self.phase is not OrderPhase.OPEN, "ending": self.ending, "cancels": list(self.cancels),
            "driving": self.may_be_moved, "onEdge": self.on_edge,
        }  # fmt: skip


def first_state(limits: Capabilities) -> OrderState:
    """The state of a vehicle that had no order yet.

    Args:
        limits: What it is able to obey; its abilities need not include the built-in actions.
    """
    return OrderState(replace(limits, actions={**limits.actions, **BUILT_IN}))


def read_state(data: Mapping[str, Any], limits: Capabilities) -> OrderState:
    """The state that `to_json` gave. `Restarted` is to happen to it next.

    Raises:
        Invalid, KeyError, TypeError, ValueError: This is not what `to_json` gave.
    """
    phase = OrderPhase.CLOSED if data["closed"] else OrderPhase.OPEN
    return first_state(limits)._replace(
        order_id=str(data["orderId"]),
        update=int(data["orderUpdateId"]),
        last_node=str(data["lastNodeId"]),
        last_sequence=int(data["lastNodeSequenceId"]),
        nodes=tuple(read_node(raw, "nodes") for raw in data["nodes"]),
        edges=tuple(read_edge(raw, "edges") for raw in data["edges"]),
        action_states=tuple(ActionState.from_json(raw) for raw in data["records"]),
        problems=Problems(tuple(Problem.from_json(raw) for raw in data["problems"])),
        phase=OrderPhase.ENDING if data["ending"] else phase,
        cancels=tuple(data["cancels"]),
        set_holds=frozenset({Hold.PAUSED} if data["paused"] else ()),
        on_edge=bool(data["onEdge"]),
        # What moved the robot may still be under way.
        motion=Motion.UNKNOWN if data["driving"] else Motion.SETTLING,
    )
