"""Actions of nodes, edges and instant ones: when each begins and ends."""

from __future__ import annotations

import pytest

from tests.support.fleet import PureVehicle, action
from tests.support.fleet_orders import kinds
from woosh_pure.fleet.order.action_states import ActionStates


def test_actions_of_a_node_begin_in_their_order_by_blocking_type(vehicle: PureVehicle) -> None:
    """Figure 17: NONE and SOFT together, HARD alone behind them, the rest behind it; then it drives."""
    given = [action("n1"), action("s1", blocking="SOFT"), action("h", blocking="HARD"), action("n2"), action("s2", blocking="SOFT")]  # fmt: skip
    vehicle.order(nodes="ab", node_actions={"a": given})
    assert vehicle.begun == ["n1", "s1"]
    vehicle.finish("s1")
    assert vehicle.begun == ["n1", "s1"]
    vehicle.finish("n1")
    assert vehicle.begun == ["n1", "s1", "h"]
    assert vehicle.status("n2") == "WAITING"
    vehicle.finish("h")
    assert vehicle.begun == ["n1", "s1", "h", "n2", "s2"]
    assert vehicle.drives == []
    vehicle.finish("s2")
    assert vehicle.drives == ["b"], "n2 runs while it drives"


def test_a_hard_action_waits_for_one_of_a_node_before(vehicle: PureVehicle) -> None:
    """It is the only one that runs at its time."""
    vehicle.order(nodes="ab", node_actions={"a": [action("n")], "b": [action("h", blocking="HARD")]})
    vehicle.arrive()
    assert vehicle.begun == ["n"]
    vehicle.finish("n")
    assert vehicle.begun == ["n", "h"]


@pytest.mark.parametrize("blocking", ["SOFT", "HARD"])
def test_a_node_with_an_action_that_blocks_is_no_place_to_pass(vehicle: PureVehicle, blocking: str) -> None:
    """It is arrived at, and left when the action has ended."""
    vehicle.order(node_actions={"b": [action("x", blocking=blocking)]})
    vehicle.place(1.9)
    assert vehicle.begun == []
    vehicle.arrive()
    assert vehicle.begun == ["x"]
    assert vehicle.drives == ["b"]
    vehicle.finish("x")
    assert vehicle.drives == ["b", "c"]


def test_a_node_with_an_action_that_does_not_block_is_passed(vehicle: PureVehicle) -> None:
    """The action begins with the traversal, and the vehicle does not stop."""
    vehicle.order(node_actions={"b": [action("x"), action("y")]})
    vehicle.place(1.9)
    assert vehicle.begun == ["x", "y"]
    assert vehicle.drives == ["b", "c"]
    assert vehicle.halts == 0


def test_actions_of_an_edge_run_while_it_is_driven(vehicle: PureVehicle) -> None:
    """They begin when the edge is entered, and are ended when it is left."""
    vehicle.order(edge_actions={"ab": [action("on_ab")], "bc": [action("on_bc")]})
    assert vehicle.begun == ["on_ab"]
    vehicle.arrive()
    assert vehicle.ended == ["on_ab"]
    assert vehicle.begun == ["on_ab", "on_bc"]
    vehicle.finish("on_ab")
    assert vehicle.status("on_ab") == "FINISHED"
    vehicle.arrive()
    vehicle.finish("on_bc")
    assert not vehicle.state.executing


def test_an_action_of_an_edge_that_blocks_is_done_before_driving(vehicle: PureVehicle) -> None:
    """The edge is entered in standing."""
    vehicle.order(nodes="ab", edge_actions={"ab": [action("s", blocking="SOFT")]})
    assert vehicle.begun == ["s"]
    assert vehicle.drives == []
    vehicle.finish("s")
    assert vehicle.drives == ["b"]


def test_an_action_that_failed_is_told_and_the_order_goes_on(vehicle: PureVehicle) -> None:
    """Whether it is worth going on is the manager's to say."""
    vehicle.order(nodes="ab", node_actions={"a": [action("x", blocking="HARD")]})
    vehicle.finish("x", False, "no load there")
    assert vehicle.status("x") == "FAILED"
    (problem,) = vehicle.state.problems
    assert problem.kind == "orderActionError"
    assert problem.references.get("actionId") == "x"
    assert "no load there" in problem.description
    assert vehicle.drives == ["b"]


def test_an_instant_action_that_blocks_makes_the_vehicle_stand(vehicle: PureVehicle) -> None:
    """It halts, the action runs, and the drive is given anew."""
    vehicle.order(nodes="ab")
    vehicle.instant(action("i", "beep", "HARD"))
    assert vehicle.halting
    assert vehicle.begun == []
    vehicle.stop()
    assert vehicle.begun == ["i"]
    assert vehicle.drives == ["b"]
    vehicle.finish("i")
    assert vehicle.drives == ["b", "b"]


def test_an_instant_action_that_does_not_block_runs_beside(vehicle: PureVehicle) -> None:
    """At once, and once, also when its message comes twice."""
    vehicle.order(nodes="ab")
    vehicle.instant(action("i"))
    vehicle.instant(action("i"))
    assert vehicle.begun == ["i"]
    assert vehicle.halts == 0


def test_instant_actions_that_cannot_be_done_fail(vehicle: PureVehicle) -> None:
    """Each with its error, which refers to it."""
    vehicle.instant(action("x", "fly"))
    assert vehicle.status("x") == "FAILED"
    (problem,) = vehicle.state.problems
    assert problem.kind == "instantActionError"
    assert problem.references.get("actionId") == "x"
    assert problem.references.get("topic") == "instantActions"


@pytest.mark.parametrize("kind", ["dock", "initPosition"])
def test_an_instant_action_must_not_contradict_the_order(vehicle: PureVehicle, kind: str) -> None:
    """One that moves the robot, or its position, fails while an order is carried out."""
    vehicle.order()
    vehicle.instant(action("x", kind))
    assert vehicle.status("x") == "FAILED"
    assert kinds(vehicle) == ["instantActionError"]
    assert vehicle.begun == []


def test_init_position_names_the_last_node(vehicle: PureVehicle) -> None:
    """An order may begin there afterwards."""
    vehicle.instant(action("i", "initPosition", lastNodeId="q"))
    vehicle.finish("i")
    assert (vehicle.state.last_node, vehicle.state.last_sequence) == ("q", 0)


def test_requests_are_finished_at_once(vehicle: PureVehicle) -> None:
    """A state comes with each."""
    before = vehicle.told
    vehicle.instant(action("s", "stateRequest"), action("f", "factsheetRequest"))
    assert vehicle.status("s") == vehicle.status("f") == "FINISHED"
    assert vehicle.told == before + 1


def test_what_moves_nothing_and_wants_the_robot_to_stand_is_hard(vehicle: PureVehicle) -> None:
    """A new map under a robot that drives, for example: NONE was said, and it drives on afterwards."""
    vehicle.order(nodes="ab", node_actions={"a": [action("x", "park", "NONE")]})
    assert (vehicle.begun, vehicle.drives) == (["x"], [])
    vehicle.finish("x")
    assert vehicle.drives == ["b"]


def test_the_map_of_an_order_is_not_changed_beside_it(vehicle: PureVehicle) -> None:
    """6.9: that would contradict it; another map may be made ready, when the vehicle stands."""
    vehicle.order()
    vehicle.instant(action("m", "enableMap", mapId="hall", mapVersion="2"))
    assert (vehicle.status("m"), kinds(vehicle)) == ("FAILED", ["instantActionError"])
    vehicle.instant(action("n", "enableMap", mapId="up", mapVersion="2"))
    assert (vehicle.status("n"), vehicle.halting) == ("WAITING", True)
    vehicle.stop()
    assert vehicle.begun == ["n"]
    vehicle.finish("n")
    assert vehicle.drives == ["b", "b"]


@pytest.mark.parametrize("kind", ["beep", "stateRequest", "stopPause"])
def test_an_action_id_that_was_used_is_refused(vehicle: PureVehicle, kind: str) -> None:
    """With an error that names it; the state of the first action does not change."""
    vehicle.instant(action("p", "startPause"))
    assert vehicle.status("p") == "FINISHED"
    vehicle.instant(action("p", kind))
    (problem,) = vehicle.state.problems
    assert (problem.kind, problem.references.get("actionId"), problem.references.get("actionType")) == (
        "instantActionError",
        "p",
        kind,
    )
    assert vehicle.state.paused
    assert vehicle.begun == []
    assert vehicle.status("p") == "FINISHED"


def test_what_stops_is_obeyed_under_an_id_that_was_used(vehicle: PureVehicle) -> None:
    """A reused id is the manager's mistake; the vehicle pauses, ends its order, and says what was wrong."""
    vehicle.order(nodes="ab")
    vehicle.instant(action("p", "startPause"))
    vehicle.stop()
    vehicle.instant(action("r", "stopPause"))
    assert vehicle.drives == ["b", "b"]
    vehicle.instant(action("p", "startPause"))
    assert vehicle.halting
    assert vehicle.state.paused
    assert kinds(vehicle) == ["instantActionError"]
    vehicle.instant(action("p", "cancelOrder"))
    vehicle.stop()
    assert vehicle.ahead == ""
    assert kinds(vehicle) == ["instantActionError"] * 2


def test_a_message_that_comes_twice_is_no_mistake(vehicle: PureVehicle) -> None:
    """While the action runs, the repetition is ignored without an error."""
    vehicle.order(nodes="ab")
    for _ in range(2):
        vehicle.instant(action("x", "cancelOrder"))
    assert kinds(vehicle) == []
    vehicle.stop()
    assert vehicle.status("x") == "FINISHED"


def test_instant_actions_beside_an_order_are_found_as_if_all_had_come_together(vehicle: PureVehicle) -> None:
    """One more action adds to what is known of the others; it is not made again of all of them."""
    vehicle.order(node_actions={"a": [action("n")], "b": [action("m", blocking="HARD")]})
    for n in range(5):
        vehicle.instant(action(f"i{n}"))
        if n % 2:
            vehicle.finish(f"i{n}")
        states = vehicle.state.action_states
        made = ActionStates.of(states)
        assert [each.action.id for each in states] == ["n", "m", *(f"i{k}" for k in range(n + 1))]
        for each in states:
            assert states.get(each.action.id) is made.get(each.action.id) is each
        assert (states.ids(), states.open_instant) == (made.ids(), made.open_instant)
        assert (set(map(id, states.running)), states.open_of_order) == (set(map(id, made.running)), 2)
        assert states.in_order(["i0", "n"]) == made.in_order(["i0", "n"])


def test_no_more_action_states_are_kept_than_are_allowed(
    vehicle: PureVehicle, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The oldest that have ended are forgotten, also beside an order and without a new one."""
    monkeypatch.setattr("woosh_pure.fleet.order.transition.MAX_ACTION_STATES", 10)
    vehicle.order(nodes="ab", node_actions={"b": [action("n")]})
    for n in range(25):
        vehicle.instant(action(f"i{n}"))
        vehicle.finish(f"i{n}")
    assert [each.action.id for each in vehicle.state.action_states] == [
        "n",
        *(f"i{n}" for n in range(16, 25)),
    ]
