"""The state of the order machine as a frozen value, with the queries on it. Pure.

Only `transition.py` makes changed states. The part that survives the process is `kept`; on disk it is
`to_json`, followed by `change_since` for each later state. So the disk gets an order once, then its progress.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from woosh_pure.fleet.messages.elements import Edge, Node
from woosh_pure.fleet.messages.parsing import read_edge, read_node
from woosh_pure.fleet.order.action_states import BUILT_IN, ActionState, ActionStates, Scope, holds_driving
from woosh_pure.fleet.order.errors import Problem, Problems
from woosh_pure.fleet.order.events import Drive
from woosh_pure.fleet.order.tables import PREVENTED_ACTIVITIES, Activity, Hold, Motion, OrderPhase
from woosh_pure.fleet.order.vehicle_limits import AgvPosition, Capabilities, on_other_map

DRIVING_MODES = ("AUTOMATIC", "SEMIAUTOMATIC")
"""Operating modes (6.10.6) in which the fleet manager is in control."""


class OrderState(NamedTuple):
    """One vehicle's order, its actions, and its holds.

    Attributes:
        limits: The vehicle's capabilities, including the built-in actions.
        order_id, update, last_node, last_sequence: As in the state message.
        nodes, edges: Those still to be traversed.
        action_states: States of order actions and instant actions, in the order of their arrival.
        actions_to_save: Ids of the actions that have changed, come or gone since the state was saved.
        problems: The `errors` of the state message.
        phase: Phase of the order.
        cancels: Ids of the cancelOrder actions that wait for the end of the order.
        motion: Whether this program moves the vehicle.
        drive: The current drive; None after its end.
        last_token: Token of the newest drive.
        set_holds: Holds that stay until an event releases them; see `holds`.
        too_fast: Why the current drive is being cancelled for its speed; else "".
        failures: Failed drives to the next node.
        on_edge: The edge to the next node was entered: its actions may begin.
        heard: Whether there is contact with the robot.
        stops: Stops that were sent because the end of a motion is not known.
        mode: The operating mode; SERVICE until the vehicle has reported one, so that nothing moves before.
        position: The measured position; None if the vehicle is not localised.
    """

    limits: Capabilities
    order_id: str = ""
    update: int = 0
    last_node: str = ""
    last_sequence: int = 0
    nodes: tuple[Node, ...] = ()
    edges: tuple[Edge, ...] = ()
    action_states: ActionStates = ActionStates()
    actions_to_save: frozenset[str] = frozenset()
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

    # -- for the state message -------------------------------------------------------------------------------

    @property
    def executing(self) -> bool:
        """Whether an order runs, waits for an update, or is being cancelled (figure 8, 3)."""
        return bool(self.nodes) or self.ending or self.action_states.open_of_order > 0

    @property
    def ending(self) -> bool:
        """Whether the order was cancelled or cleared, and its drive or actions have not all ended."""
        return self.phase is OrderPhase.ENDING

    @property
    def paused(self) -> bool:
        """Whether the vehicle is paused by startPause."""
        return Hold.PAUSED in self.set_holds

    @property
    def held(self) -> bool:
        """Whether the order waits for stopPause or cancelOrder, after a restart or a stop of somebody."""
        return Hold.HELD in self.set_holds

    @property
    def driving(self) -> bool:
        """Whether a drive is under way."""
        return self.drive is not None

    @property
    def wants_base(self) -> bool:
        """`newBaseRequest`: there is a horizon, and at most one node of the base is ahead."""
        ahead = self.nodes  # nothing behind an unreleased node is released
        return bool(ahead) and not (
            ahead[-1].released or any(each.released for each in ahead[1:2]) or self.ending
        )

    @property
    def decision_point(self) -> tuple[str, int]:
        """Id and sequence id of the last node of the base."""
        last = next((node for node in reversed(self.nodes) if node.released), None)
        return (self.last_node, self.last_sequence) if last is None else (last.id, last.sequence)

    @property
    def in_control(self) -> bool:
        """Whether the fleet manager may command the vehicle in this operating mode."""
        return self.mode in DRIVING_MODES

    @property
    def kept(self) -> tuple[object, ...]:
        """The part that must survive the process: the state is saved when it changes."""
        return (
            self.order_id, self.update, self.last_node, self.last_sequence, self.problems.of_orders,
            self.paused, self.phase is not OrderPhase.OPEN, self.ending, self.cancels, self.may_be_moved,
            self.on_edge, self.nodes, self.edges, self.action_states,
        )  # fmt: skip

    @property
    def shown(self) -> tuple[object, ...]:
        """A state is published when this or `kept` changes."""
        return (
            self.problems.standing, self.held, self.mode, self.driving, self.position is None,
        )  # fmt: skip

    # -- its actions -----------------------------------------------------------------------------------------

    def action_state(self, action_id: str) -> ActionState | None:
        """The state of an action; None if the id is not known."""
        return self.action_states.get(action_id)

    def ids_of_horizon(self) -> set[str]:
        """Ids of the actions of nodes and edges that are not released."""
        elements: list[Node | Edge] = [*self.nodes, *self.edges]
        return {action.id for each in elements if not each.released for action in each.actions}

    def actions_here(self) -> list[ActionState]:
        """The actions of the last node and of the edge that was entered."""
        found, following = [], self.nodes[0] if self.nodes else None
        # Before the first node of an order is reached, the last node is one of the order before.
        if following is None or self.last_sequence < following.sequence:
            found = self.action_states.at(Scope.NODE, self.last_sequence)
        if self.on_edge and following is not None and self.has_edge_to(following):
            found += self.action_states.at(Scope.EDGE, self.edges[0].sequence)
        return found

    def instant_actions(self) -> list[ActionState]:
        """Instant actions that are not built in and have not ended."""
        return [a for a in self.action_states.open_instant if a.action.type not in BUILT_IN]

    def moves(self, state: ActionState) -> bool:
        """Whether an action itself moves the robot."""
        supported = self.limits.actions.get(state.action.type)
        return supported is not None and supported.moves

    # -- whether it may drive --------------------------------------------------------------------------------

    @property
    def holds(self) -> set[Hold]:
        """All holds that are in force."""
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

    def prevents(self, activity: Activity) -> bool:
        """Whether a hold prevents an activity."""
        holds = self.holds
        return bool(holds) and any(activity in PREVENTED_ACTIVITIES[hold] for hold in holds)

    def has_edge_to(self, node: Node) -> bool:
        """Whether an edge leads to a node; then the node is driven to even if the vehicle is there."""
        return bool(self.edges) and self.edges[0].sequence < node.sequence

    @property
    def is_on_other_map(self) -> bool:
        """Whether the next node is on another map than the vehicle."""
        return bool(self.nodes) and self.position is not None and on_other_map(self.position, self.nodes[0])

    @property
    def maps(self) -> set[str]:
        """Ids of the maps that the order needs: the one in use (any, if it is not known), and those of the
        nodes ahead."""
        used = self.position.map_id if self.position is not None else ""
        found = {node.position.map_id for node in self.nodes if node.position is not None}
        return found | ({used} if used else set(self.limits.maps))

    @property
    def waits_for_actions(self) -> bool:
        """Whether an action requires the vehicle to stand."""
        return holds_driving((*self.actions_here(), *self.instant_actions()))

    @property
    def standing(self) -> bool:
        """Whether the vehicle was measured standing since its last motion."""
        return self.motion is Motion.STANDING

    @property
    def at_rest(self) -> bool:
        """Whether the vehicle was measured standing, and no action moves it."""
        return self.motion is Motion.STANDING and not self.is_moved_by_action

    @property
    def is_moved_by_action(self) -> bool:
        """Whether a running action moves the robot."""
        running = self.action_states.running
        return bool(running) and any(self.moves(each) for each in running)

    @property
    def may_be_moved(self) -> bool:
        """Whether a drive or action of this program moves the robot, or may."""
        return self.motion not in (Motion.STANDING, Motion.SETTLING) or self.is_moved_by_action

    @property
    def waits_for_rest(self) -> bool:
        """Whether a cancel or pause only waits for the vehicle to be measured standing."""
        waits = self.ending or any(a.action.type == "startPause" for a in self.action_states.running)
        return waits and self.drive is None and not self.standing

    # -- the disk --------------------------------------------------------------------------------------------

    def to_json(self) -> dict[str, object]:
        """The part that must survive the process, as a JSON object."""
        return {
            **_as_json(dict(zip(_KEPT, self.kept, strict=False))),
            "nodes": [node.to_json() for node in self.nodes],
            "edges": [edge.to_json() for edge in self.edges],
            "records": [each.to_json() for each in self.action_states],
        }

    def change_since(self, saved: OrderState) -> dict[str, object]:
        """What has changed since an earlier state was saved, as a JSON object for `changed`. Its size is that
        of the change, not that of the order."""
        fields = zip(_KEPT, self.kept, saved.kept, strict=False)
        change = _as_json({key: value for key, value, before in fields if value != before})
        if self.nodes is not saved.nodes:
            change["nodes"] = _list_change(saved.nodes, self.nodes)
        if self.edges is not saved.edges:
            change["edges"] = _list_change(saved.edges, self.edges)
        known, now = saved.action_states, self.action_states
        gone = [name for name in sorted(self.actions_to_save) if known.get(name) and not now.get(name)]
        if gone:
            change["gone"] = gone
        if self.actions_to_save:
            change["records"] = [
                (each.action.id, each.change_since(known.get(each.action.id)))
                for each in now.in_order(self.actions_to_save)
            ]
        return change


_KEPT = (
    "orderId", "orderUpdateId", "lastNodeId", "lastNodeSequenceId", "problems", "paused", "closed", "ending",
    "cancels", "driving", "onEdge",
)  # fmt: skip
"""The names of the first values of `OrderState.kept` on disk; nodes, edges and actions follow."""


def _as_json(fields: dict[str, Any]) -> dict[str, object]:
    if "problems" in fields:
        fields["problems"] = [problem.to_json() for problem in fields["problems"]]
    if "cancels" in fields:
        fields["cancels"] = list(fields["cancels"])
    return fields


def _list_change(before: Sequence[Node | Edge], after: Sequence[Node | Edge]) -> list[object]:
    """How many were removed in front, how many follow that were kept, and what was added behind those."""
    gone = next((n for n, each in enumerate(before) if after and each is after[0]), len(before))
    kept = len(after) if before[gone:] == after else 0
    while gone + kept < len(before) and kept < len(after) and before[gone + kept] is after[kept]:
        kept += 1
    return [gone, kept, [each.to_json() for each in after[kept:]]]


def changed(saved: Mapping[str, Any], changes: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    """Apply the output of `change_since`, in its order, to the output of `to_json`.

    Raises:
        AttributeError, KeyError, TypeError, ValueError: One of them was not made by these methods.
    """
    data, records = dict(saved), {each["action"]["actionId"]: each for each in saved["records"]}
    for change in changes:
        fields = dict(change)
        for key in ("nodes", "edges"):
            if key in fields:
                gone, kept, added = fields[key]
                fields[key] = [*data[key][gone : gone + kept], *added]
        for name in fields.pop("gone", ()):
            del records[name]
        for name, record in fields.pop("records", ()):
            if "action" in record:
                records.pop(name, None)  # another action with the id of one that is gone: the newest is last
                records[name] = record
            else:
                records[name] = {**records[name], **record}
        data.update(fields)
    return {**data, "records": list(records.values())}


def first_state(limits: Capabilities) -> OrderState:
    """The state of a vehicle that has had no order yet.

    Args:
        limits: Its capabilities; the built-in actions are added.
    """
    return OrderState(replace(limits, actions={**limits.actions, **BUILT_IN}))


def read_state(data: Mapping[str, Any], limits: Capabilities) -> OrderState:
    """Restore a state from the output of `to_json`. The next event must be `Restarted`.

    Raises:
        Invalid, KeyError, TypeError, ValueError: The data was not made by `to_json`.
    """
    phase = OrderPhase.CLOSED if data["closed"] else OrderPhase.OPEN
    return first_state(limits)._replace(
        order_id=str(data["orderId"]),
        update=int(data["orderUpdateId"]),
        last_node=str(data["lastNodeId"]),
        last_sequence=int(data["lastNodeSequenceId"]),
        nodes=tuple(read_node(raw, "nodes") for raw in data["nodes"]),
        edges=tuple(read_edge(raw, "edges") for raw in data["edges"]),
        action_states=ActionStates.of(ActionState.from_json(raw) for raw in data["records"]),
        problems=Problems(tuple(Problem.from_json(raw) for raw in data["problems"])),
        phase=OrderPhase.ENDING if data["ending"] else phase,
        cancels=tuple(data["cancels"]),
        set_holds=frozenset({Hold.PAUSED} if data["paused"] else ()),
        on_edge=bool(data["onEdge"]),
        # The motion may still be under way.
        motion=Motion.UNKNOWN if data["driving"] else Motion.SETTLING,
    )
