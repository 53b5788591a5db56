"""The order machine: what is taken, what is rejected and how, and what is driven and done in which order."""

from __future__ import annotations

import json
from typing import Any

import pytest

from tests.support.fleet import LIMITS, PureVehicle, action, order_json
from woosh_pure.fleet.messages.parsing import read_order
from woosh_pure.fleet.messages.schema import Invalid
from woosh_pure.fleet.order.errors import Level, Problem
from woosh_pure.fleet.order.machine import RETRIES, OrderMachine


@pytest.fixture
def vehicle() -> PureVehicle:
    return PureVehicle()


def finish_order(vehicle: PureVehicle) -> None:
    while vehicle.drive is not None:
        vehicle.arrive()


def kinds(vehicle: PureVehicle) -> list[str]:
    return vehicle.problems


# -- driving ---------------------------------------------------------------------------------------------------


def test_an_order_is_driven_node_by_node(vehicle: PureVehicle) -> None:
    """The first node counts as reached where the vehicle stands, the others one after the other."""
    vehicle.order()
    assert vehicle.drives == ["b"]
    assert vehicle.ahead == "bc"
    vehicle.arrive()
    vehicle.arrive()
    assert vehicle.drives == ["b", "c"]
    assert vehicle.visited == [("a", 0), ("b", 2), ("c", 4)]
    assert not vehicle.machine.executing
    assert vehicle.machine.edges == []


def test_a_node_with_a_range_is_passed_without_a_stop(vehicle: PureVehicle) -> None:
    """In the deviation range the next drive replaces the one under way; outside it does not."""
    vehicle.order(deviation=0.5)
    vehicle.place(1.4)
    assert vehicle.drives == ["b"]
    vehicle.place(1.6)
    assert vehicle.drives == ["b", "c"]
    assert vehicle.halts == 0


def test_a_node_without_a_range_is_arrived_at(vehicle: PureVehicle) -> None:
    """allowedDeviationXY 0: near is not there, only the end of the drive is."""
    vehicle.order(deviation=0.0)
    vehicle.place(1.99)
    assert vehicle.drives == ["b"]
    vehicle.arrive()
    assert vehicle.drives == ["b", "c"]


def test_the_last_node_of_the_base_is_arrived_at(vehicle: PureVehicle) -> None:
    """The vehicle stops at the decision point: the range alone is not enough there."""
    vehicle.order(nodes="ab")
    vehicle.place(1.8)
    assert vehicle.ahead == "b"
    vehicle.arrive()
    assert vehicle.ahead == ""


def test_nothing_of_the_horizon_is_driven(vehicle: PureVehicle) -> None:
    """It stops at the end of the base, asks for more, and goes on when it comes."""
    vehicle.order(nodes="abcd", released=2)
    assert vehicle.machine.wants_base
    vehicle.arrive()
    assert vehicle.drive is None
    assert vehicle.ahead == "cd"
    assert vehicle.machine.executing
    vehicle.order(update=1, nodes="bc", first=2)
    assert vehicle.drives == ["b", "c"]
    assert vehicle.ahead == "c"
    assert not vehicle.machine.wants_base


def test_an_update_under_way_joins_at_the_decision_point(vehicle: PureVehicle) -> None:
    """The base stays as it is, the horizon is replaced, and the drive under way goes on."""
    vehicle.order(
        nodes="abcd", released=3, node_actions={"d": [action("old")], "c": [action("kept", blocking="HARD")]}
    )
    vehicle.order(update=1, nodes="cxy", first=4, node_actions={"c": [action("other")], "y": [action("new")]})
    assert vehicle.drives == ["b"]
    assert vehicle.ahead == "bcxy"
    assert vehicle.status("old") == ""
    assert vehicle.status("other") == "", "the contents of the stitching node are those of before"
    assert vehicle.status("kept") == vehicle.status("new") == "WAITING"


def test_an_update_may_delete_the_horizon(vehicle: PureVehicle) -> None:
    """A single node, the decision point: the order ends there."""
    vehicle.order(nodes="abcd", released=2)
    vehicle.order(update=1, nodes="b", first=2)
    assert vehicle.ahead == "b"
    vehicle.arrive()
    assert not vehicle.machine.executing


def test_a_finished_order_may_be_continued(vehicle: PureVehicle) -> None:
    """Figure 8, 8: an update that begins at the last node and its sequence id."""
    vehicle.order(nodes="ab")
    vehicle.arrive()
    vehicle.order(update=1, nodes="ba", first=2)
    assert vehicle.drives == ["b", "a"]
    finish_order(vehicle)
    assert vehicle.visited == [("a", 0), ("b", 2), ("a", 4)]


def test_a_loop_is_told_apart_by_its_sequence(vehicle: PureVehicle) -> None:
    """From a to b and back: standing near a does not make the second a reached."""
    vehicle.order(nodes="aba")
    vehicle.place(0.1)
    assert vehicle.ahead == "ba"
    finish_order(vehicle)
    assert vehicle.visited == [("a", 0), ("b", 2), ("a", 4)]


def test_the_first_node_is_turned_to(vehicle: PureVehicle) -> None:
    """Near enough but looking elsewhere: the vehicle turns on the node before anything else."""
    data = order_json(nodes="ab", node_actions={"a": [action("on_a")]})
    data["nodes"][0]["nodePosition"].update(theta=1.5, allowedDeviationTheta=0.1)
    vehicle.take(vehicle.machine.receive(read_order(data)))
    assert vehicle.drives == ["a"]
    assert vehicle.begun == []
    vehicle.arrive()
    assert vehicle.begun == ["on_a"]
    assert vehicle.drives == ["a", "b"]


def test_a_drive_that_ends_beside_its_node_is_tried_again(vehicle: PureVehicle) -> None:
    """No node is skipped: it is told, tried again with longer waits, and then left to a person."""
    vehicle.order(nodes="abc")
    for n, seconds in enumerate(RETRIES):
        assert vehicle.drive is not None
        vehicle.take(vehicle.machine.drive_ended(vehicle.drive.token, True))
        assert vehicle.retries[n] == seconds
        assert kinds(vehicle) == ["driveError"]
        vehicle.take(vehicle.machine.retry())
        assert kinds(vehicle) == []
    assert vehicle.drive is not None
    vehicle.take(vehicle.machine.drive_ended(vehicle.drive.token, False, "blocked"))
    (problem,) = vehicle.machine.problems
    assert problem.level == "FATAL"
    assert "blocked" in problem.description
    assert problem.about("nodeId") == "b"
    assert vehicle.ahead == "bc"
    vehicle.instant(action("go", "stopPause"))
    assert vehicle.drives == ["b"] * 5


def test_the_end_of_a_drive_that_was_replaced_means_nothing(vehicle: PureVehicle) -> None:
    """Passing b, the drive to b ends as replaced: the one to c goes on."""
    vehicle.order()
    assert vehicle.drive is not None
    first = vehicle.drive.token
    vehicle.place(1.9)
    vehicle.take(vehicle.machine.drive_ended(first, False, "replaced"))
    assert vehicle.drives == ["b", "c"]
    assert kinds(vehicle) == []


# -- rejections: 6.6.4 and figure 8 ----------------------------------------------------------------------------


def test_a_malformed_order_is_a_validation_error(vehicle: PureVehicle) -> None:
    """6.6.4.1: it is not taken, it is told until an order is taken, with what of it can be read."""
    data = order_json("bad")
    del data["nodes"][1]["released"]
    with pytest.raises(Invalid) as caught:
        read_order(data)
    vehicle.take(vehicle.machine.receive_malformed(data, caught.value))
    (problem,) = vehicle.machine.problems
    assert (problem.kind, problem.level) == ("validationError", "WARNING")
    assert problem.references == (
        ("topic", "order"), ("headerId", "7"), ("orderId", "bad"), ("orderUpdateId", "0"),
        ("field", "nodes[1].released"),
    )  # fmt: skip
    assert vehicle.machine.order_id == ""
    vehicle.order()
    assert kinds(vehicle) == []


def test_a_new_order_is_rejected_while_one_is_carried_out(vehicle: PureVehicle) -> None:
    """Figure 8, 3; the running one goes on."""
    vehicle.order()
    vehicle.order("p", nodes="ab")
    assert kinds(vehicle) == ["orderError"]
    assert vehicle.machine.order_id == "o"
    assert vehicle.drives == ["b"]
    assert next(iter(vehicle.machine.problems)).about("orderId") == "p"


def test_a_new_order_is_rejected_while_one_waits_for_its_base(vehicle: PureVehicle) -> None:
    """A horizon is an order that is not over."""
    vehicle.order(nodes="abc", released=1)
    assert vehicle.drive is None
    vehicle.order("p", nodes="ab")
    assert kinds(vehicle) == ["orderError"]


def test_a_new_order_is_rejected_while_an_action_of_the_last_runs(vehicle: PureVehicle) -> None:
    """All nodes are reached, and an action is not at its end."""
    vehicle.order(nodes="a", node_actions={"a": [action("long")]})
    assert vehicle.machine.nodes == []
    vehicle.order("p", nodes="ab")
    assert kinds(vehicle) == ["orderError"]
    vehicle.finish("long")
    vehicle.order("p", nodes="ab")
    assert vehicle.machine.order_id == "p"
    assert kinds(vehicle) == []
    assert vehicle.status("long") == "", "states of the previous order are gone"


def test_a_first_node_out_of_reach_is_rejected(vehicle: PureVehicle) -> None:
    """Figure 8, 4."""
    vehicle.order(nodes="bc")
    assert kinds(vehicle) == ["noRouteError"]
    assert vehicle.machine.order_id == ""
    assert vehicle.drives == []


def test_a_wide_range_makes_the_first_node_reached(vehicle: PureVehicle) -> None:
    """6.6.3.1: after a cancel an order may begin at the last node with a range that covers the vehicle."""
    vehicle.order(nodes="bc", deviation=2.5)
    assert vehicle.machine.last_node == "b"
    assert vehicle.drives == ["c"]


def test_an_order_is_rejected_without_localisation(vehicle: PureVehicle) -> None:
    """Nobody knows whether the first node is near."""
    vehicle.take(vehicle.machine.set_position(None))
    vehicle.order()
    assert kinds(vehicle) == ["noRouteError"]


@pytest.mark.parametrize("mode", ["MANUAL", "SERVICE", "TEACHIN"])
def test_an_order_is_rejected_in_the_modes_of_others(vehicle: PureVehicle, mode: str) -> None:
    """The fleet manager is not in control there."""
    vehicle.take(vehicle.machine.set_mode(mode))
    vehicle.order()
    assert kinds(vehicle) == ["orderError"]
    assert vehicle.drives == []


def test_a_lower_update_is_rejected_and_the_order_goes_on(vehicle: PureVehicle) -> None:
    """6.6.4.3."""
    vehicle.order(update=3, nodes="abc", released=2)
    vehicle.order(update=2, nodes="bc", first=2)
    (problem,) = vehicle.machine.problems
    assert (problem.kind, problem.level) == ("orderUpdateError", "WARNING")
    assert problem.about("orderUpdateId") == "2"
    assert vehicle.machine.update == 3
    assert vehicle.ahead == "bc"
    vehicle.arrive()
    assert vehicle.machine.last_node == "b"


def test_the_same_update_twice_is_ignored(vehicle: PureVehicle) -> None:
    """Nothing but a state comes of it, whatever is in it."""
    vehicle.order()
    before, drives = vehicle.changes, list(vehicle.drives)
    vehicle.order(nodes="aq")
    assert vehicle.drives == drives
    assert vehicle.ahead == "bc"
    assert kinds(vehicle) == []
    assert vehicle.changes == before + 1


@pytest.mark.parametrize(("nodes", "first"), [("bc", 2), ("cd", 2), ("cd", 6)])
def test_an_update_elsewhere_than_at_the_decision_point_is_rejected(
    vehicle: PureVehicle, nodes: str, first: int
) -> None:
    """Figure 8, 7: node id and sequence id of the last base node, both."""
    vehicle.order(nodes="abcd", released=3)
    vehicle.order(update=1, nodes=nodes, first=first)
    assert kinds(vehicle) == ["orderUpdateError"]
    assert vehicle.machine.update == 0
    assert vehicle.ahead == "bcd"


def test_an_update_elsewhere_than_at_the_end_of_a_finished_order_is_rejected(vehicle: PureVehicle) -> None:
    """Figure 8, 8."""
    vehicle.order(nodes="ab")
    vehicle.arrive()
    vehicle.order(update=1, nodes="ab", first=0)
    assert kinds(vehicle) == ["orderUpdateError"]
    vehicle.order(update=1, nodes="bc", first=4)
    assert kinds(vehicle) == ["orderUpdateError", "orderUpdateError"]
    assert vehicle.drives == ["b"]


EDGE_FIELDS: list[tuple[dict[str, Any], str]] = [
    ({"trajectory": {"degree": 1, "knotVector": [], "controlPoints": []}}, "trajectory"),
    ({"corridor": {"leftWidth": 1.0, "rightWidth": 1.0}}, "corridor"),
    ({"maxHeight": 2.0}, "maxHeight"),
    ({"minHeight": 2.0}, "minHeight"),
    ({"direction": "left"}, "direction"),
    ({"maxRotationSpeed": 1.0}, "maxRotationSpeed"),
    ({"rotationAllowed": False}, "rotationAllowed"),
    ({"orientation": 1.0}, "orientation"),
    ({"orientation": 0.0, "orientationType": "GLOBAL"}, "orientation"),
    ({"maxSpeed": 0.0}, "maxSpeed"),
]


@pytest.mark.parametrize(("fields", "named"), EDGE_FIELDS)
def test_fields_of_an_edge_that_are_not_obeyed_are_rejected(
    vehicle: PureVehicle, fields: dict[str, Any], named: str
) -> None:
    """6.6.4.2: the wrong field is the reference."""
    data = order_json()
    data["edges"][1].update(fields)
    vehicle.take(vehicle.machine.receive(read_order(data)))
    (problem,) = vehicle.machine.problems
    assert problem.kind == "orderError"
    assert problem.about("edgeId") == "bc"
    assert problem.about("field") == f"edges[1].{named}"
    assert vehicle.drives == []


def test_fields_of_an_edge_that_are_obeyed_are_given_on(vehicle: PureVehicle) -> None:
    """Speed and direction of travel."""
    data = order_json()
    data["edges"][0].update(maxSpeed=0.3, orientation=3.14159, rotationAllowed=True, length=2.0)
    vehicle.take(vehicle.machine.receive(read_order(data)))
    assert vehicle.drive is not None
    assert vehicle.drive.edge is not None
    assert vehicle.drive.edge.options["maxSpeed"] == 0.3


@pytest.mark.parametrize(
    ("given", "field"),
    [
        (action("x", "fly"), "actionType"),
        (action("x", "initPosition"), "actionType"),
        (action("x", "cancelOrder"), "actionType"),
        (action("x", "beep", volume=3), "actionParameters.volume"),
        (action("x", "beep", times="three"), "actionParameters.times"),
        (action("x", "beep", times=True), "actionParameters.times"),
    ],
)
def test_actions_that_cannot_be_done_are_rejected(
    vehicle: PureVehicle, given: dict[str, Any], field: str
) -> None:
    """6.6.4.2, in the horizon as in the base."""
    vehicle.order(nodes="abc", released=1, node_actions={"c": [given]})
    (problem,) = vehicle.machine.problems
    assert problem.kind == "orderError"
    assert (problem.about("actionId"), problem.about("field")) == ("x", field)
    assert vehicle.machine.order_id == ""


def test_other_things_a_vehicle_cannot_do_are_rejected(vehicle: PureVehicle) -> None:
    """A node without a place, one on a map that is not here, and zones."""
    nowhere, elsewhere, zones = order_json("n"), order_json("e"), order_json("z")
    del nowhere["nodes"][1]["nodePosition"]
    elsewhere["nodes"][2]["nodePosition"]["mapId"] = "cellar"
    zones["zoneSetId"] = "zones"
    for data in (nowhere, elsewhere, zones):
        vehicle.take(vehicle.machine.receive(read_order(data)))
    assert kinds(vehicle) == ["orderError"] * 3
    fields = [problem.about("field") for problem in vehicle.machine.problems]
    assert fields == ["nodes[1].nodePosition", "nodes[2].nodePosition.mapId", "zoneSetId"]


def test_an_update_with_an_action_that_has_run_is_rejected(vehicle: PureVehicle) -> None:
    """No action runs twice."""
    vehicle.order(nodes="ab", released=1, node_actions={"a": [action("once")]})
    vehicle.finish("once")
    vehicle.order(update=1, nodes="ab", node_actions={"b": [action("once")]})
    assert kinds(vehicle) == ["orderError"]
    assert vehicle.machine.update == 0


def test_problems_of_orders_are_bounded(vehicle: PureVehicle) -> None:
    """Who sends nonsense for ever fills no memory; the newest are told."""
    for n in range(200):
        vehicle.order(f"far{n}", nodes="bc")
    found = list(vehicle.machine.problems)
    assert len(found) == 24
    assert found[-1].about("orderId") == "far199"


# -- actions ---------------------------------------------------------------------------------------------------


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
    assert not vehicle.machine.executing


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
    (problem,) = vehicle.machine.problems
    assert problem.kind == "orderActionError"
    assert problem.about("actionId") == "x"
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
    (problem,) = vehicle.machine.problems
    assert problem.kind == "instantActionError"
    assert problem.about("actionId") == "x"
    assert problem.about("topic") == "instantActions"


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
    assert (vehicle.machine.last_node, vehicle.machine.last_sequence) == ("q", 0)


def test_requests_are_finished_at_once(vehicle: PureVehicle) -> None:
    """A state comes with each."""
    before = vehicle.changes
    vehicle.instant(action("s", "stateRequest"), action("f", "factsheetRequest"))
    assert vehicle.status("s") == vehicle.status("f") == "FINISHED"
    assert vehicle.changes == before + 1


# -- pause, cancel, mode, localisation -------------------------------------------------------------------------


def test_pause_halts_and_resume_drives_on(vehicle: PureVehicle) -> None:
    """startPause is FINISHED when the vehicle stands; the order is as it was."""
    vehicle.order(nodes="ab", edge_actions={"ab": [action("e")]})
    vehicle.instant(action("p", "startPause"))
    assert vehicle.status("p") == "RUNNING"
    assert vehicle.halting
    vehicle.stop()
    assert vehicle.status("p") == "FINISHED"
    assert vehicle.machine.paused
    assert vehicle.drives == ["b"]
    vehicle.instant(action("r", "stopPause"))
    assert vehicle.status("r") == "FINISHED"
    assert vehicle.drives == ["b", "b"]
    assert vehicle.begun == ["e"], "the action of the edge does not begin again"
    finish_order(vehicle)
    assert vehicle.machine.last_node == "b"


def test_a_pause_taken_back_at_once(vehicle: PureVehicle) -> None:
    """The pause failed, the halt that was asked for ends first, then the drive goes on."""
    vehicle.order(nodes="ab")
    vehicle.instant(action("p", "startPause"), action("r", "stopPause"))
    assert vehicle.status("p") == "FAILED"
    assert vehicle.status("r") == "FINISHED"
    if vehicle.halting:
        vehicle.stop()
    finish_order(vehicle)
    assert vehicle.machine.last_node == "b"


def test_an_order_taken_while_paused_waits(vehicle: PureVehicle) -> None:
    """Nothing moves until stopPause."""
    vehicle.instant(action("p", "startPause"))
    assert vehicle.status("p") == "FINISHED"
    vehicle.order()
    assert vehicle.machine.order_id == "o"
    assert vehicle.drives == []


def test_cancel_halts_and_forgets_the_order(vehicle: PureVehicle) -> None:
    """cancelOrder runs until all stands; ids of the order and states of actions are kept."""
    vehicle.order(nodes="abc", node_actions={"a": [action("runs")], "c": [action("waits")]})
    vehicle.instant(action("x", "cancelOrder"))
    assert vehicle.status("waits") == "FAILED"
    assert vehicle.ended == ["runs"]
    assert vehicle.status("x") == "RUNNING"
    vehicle.stop()
    assert vehicle.status("x") == "RUNNING", "an action is not at its end"
    vehicle.finish("runs", False, "interrupted")
    assert vehicle.status("x") == "FINISHED"
    assert vehicle.ahead == ""
    assert vehicle.machine.edges == []
    assert (vehicle.machine.order_id, vehicle.machine.last_node) == ("o", "a")
    assert kinds(vehicle) == []
    vehicle.order("p", nodes="ab")
    assert vehicle.drives == ["b", "b"]


def test_cancel_waits_for_what_cannot_be_interrupted(vehicle: PureVehicle) -> None:
    """It is FINISHED by itself, and nothing behind it begins."""
    vehicle.order(nodes="ab", node_actions={"a": [action("w", "weld", "HARD"), action("later")]})
    vehicle.instant(action("x", "cancelOrder"))
    assert vehicle.ended == []
    vehicle.finish("w", True)
    assert vehicle.status("w") == "FINISHED"
    assert vehicle.status("later") == "FAILED"
    assert vehicle.status("x") == "FINISHED"
    assert vehicle.begun == ["w"]
    assert vehicle.drives == []


def test_cancel_without_an_order_fails(vehicle: PureVehicle) -> None:
    """6.6.3.2, also after a cancel, and when the order is finished."""
    vehicle.instant(action("x", "cancelOrder"))
    assert vehicle.status("x") == "FAILED"
    (problem,) = vehicle.machine.problems
    assert (problem.kind, problem.level, problem.about("actionId")) == ("noOrderToCancel", "WARNING", "x")
    vehicle.order(nodes="ab")
    vehicle.instant(action("y", "cancelOrder"))
    vehicle.stop()
    vehicle.instant(action("z", "cancelOrder"))
    assert (vehicle.status("y"), vehicle.status("z")) == ("FINISHED", "FAILED")


def test_a_second_cancel_joins_the_first(vehicle: PureVehicle) -> None:
    """Both end with the order."""
    vehicle.order(nodes="ab")
    vehicle.instant(action("x", "cancelOrder"))
    vehicle.instant(action("y", "cancelOrder"))
    vehicle.stop()
    assert vehicle.status("x") == vehicle.status("y") == "FINISHED"


def test_orders_and_updates_are_rejected_while_one_is_cancelled(vehicle: PureVehicle) -> None:
    """And an update that comes late does not wake a cancelled order."""
    vehicle.order(nodes="abc", released=2)
    vehicle.instant(action("x", "cancelOrder"))
    vehicle.order("p", nodes="ab")
    vehicle.order(update=1, nodes="bc", first=2)
    assert kinds(vehicle) == ["orderError", "orderUpdateError"]
    vehicle.stop()
    vehicle.order(update=2, nodes="ab", first=0)
    assert kinds(vehicle)[-1] == "orderUpdateError"
    assert vehicle.drives == ["b"]


def test_a_node_reached_while_a_cancel_halts_counts(vehicle: PureVehicle) -> None:
    """lastNodeId is true, and nothing is driven from there."""
    vehicle.order()
    vehicle.instant(action("x", "cancelOrder"))
    vehicle.arrive()
    assert vehicle.machine.last_node == "b"
    assert vehicle.status("x") == "FINISHED"
    assert vehicle.drives == ["b"]


@pytest.mark.parametrize("mode", ["MANUAL", "SERVICE", "TEACHIN"])
def test_a_mode_of_others_clears_the_order(vehicle: PureVehicle, mode: str) -> None:
    """6.10.6: at once, with its actions; AUTOMATIC again does not bring it back."""
    vehicle.order(node_actions={"a": [action("r")], "c": [action("w")]})
    vehicle.take(vehicle.machine.set_mode(mode))
    assert vehicle.halting
    assert vehicle.ended == ["r"]
    vehicle.stop()
    vehicle.finish("r", False)
    assert vehicle.ahead == ""
    assert kinds(vehicle) == ["orderError"]
    vehicle.take(vehicle.machine.set_mode("AUTOMATIC"))
    assert vehicle.drives == ["b"]


def test_a_vehicle_that_is_lost_halts_and_goes_on_when_found(vehicle: PureVehicle) -> None:
    """The order is kept."""
    vehicle.order()
    vehicle.take(vehicle.machine.set_position(None))
    assert vehicle.halting
    vehicle.stop()
    assert vehicle.drives == ["b"]
    vehicle.place(0.5)
    assert vehicle.drives == ["b", "b"]


def test_nothing_moves_before_the_mode_is_told() -> None:
    """A machine that was just made, or restored, is in SERVICE."""
    machine = OrderMachine(LIMITS)
    assert machine.mode == "SERVICE"


# -- restart ---------------------------------------------------------------------------------------------------


def restart(vehicle: PureVehicle) -> PureVehicle:
    """As after kill -9: what was put on disk last is all that is left."""
    kept = json.loads(json.dumps(vehicle.saved))
    place = vehicle.machine.position
    return PureVehicle(machine=OrderMachine.from_json(kept, LIMITS), x=0.0 if place is None else place.x)


def test_an_order_waits_after_a_restart_and_goes_on_when_told(vehicle: PureVehicle) -> None:
    """Base, horizon, actions and ids are as before; a program that was started moves nothing."""
    vehicle.order(nodes="abcd", released=3, node_actions={"c": [action("later", blocking="HARD")]})
    vehicle.arrive()
    again = restart(vehicle)
    assert (again.drives, again.ahead) == ([], "cd")
    assert kinds(again) == ["orderHeld"]
    assert (again.machine.order_id, again.machine.last_node) == ("o", "b")
    again.order(nodes="abcd")
    assert kinds(again) == ["orderHeld"], "the order is known: it came twice"
    again.instant(action("go", "stopPause"))
    assert (again.drives, again.status("go"), kinds(again)) == (["c"], "FINISHED", [])
    again.arrive()
    assert again.begun == ["later"]


def test_an_update_does_not_set_a_restored_order_going(vehicle: PureVehicle) -> None:
    """It may have been under way when the process died. It is taken, and waits with the rest."""
    vehicle.order(nodes="abc", released=2)
    again = restart(vehicle)
    again.order(update=1, nodes="bc", first=2)
    assert (again.machine.update, again.ahead, again.drives) == (1, "bc", [])
    again.instant(action("go", "stopPause"))
    assert again.drives == ["b"]


def test_actions_wait_with_a_restored_order(vehicle: PureVehicle) -> None:
    """A pause lets actions go on; here a lift that begins by itself is no better than a robot that drives."""
    vehicle.order(nodes="ab", node_actions={"a": [action("x", blocking="HARD"), action("y")]})
    again = restart(vehicle)
    assert (again.begun, again.status("x"), again.status("y")) == ([], "FAILED", "WAITING")
    again.instant(action("go", "stopPause"))
    assert again.begun == ["y"]


def test_a_restored_order_is_given_up_by_a_cancel(vehicle: PureVehicle) -> None:
    """And a new one is taken, which goes."""
    vehicle.order()
    again = restart(vehicle)
    again.instant(action("c", "cancelOrder"))
    assert (again.status("c"), again.ahead, kinds(again)) == ("FINISHED", "", [])
    again.order("new", nodes="ab")
    assert again.drives == ["b"]


def test_what_waits_for_its_manager_anyway_is_not_held(vehicle: PureVehicle) -> None:
    """An order at the end of its base moves with the update that releases more, and a finished one is over."""
    vehicle.order(nodes="abc", released=2)
    vehicle.arrive()
    again = restart(vehicle)
    assert not again.machine.held
    again.order(update=1, nodes="bc", first=2)
    assert again.drives == ["c"]


def test_an_orderly_end_ends_the_order(vehicle: PureVehicle) -> None:
    """What ran and what waited has failed, and is told; the next start has no order to go on with."""
    vehicle.order(nodes="ab", node_actions={"a": [action("x")], "b": [action("y")]})
    vehicle.instant(action("i"))
    vehicle.take(vehicle.machine.shut_down("it was ended"))
    assert [vehicle.status(name) for name in "xyi"] == ["FAILED"] * 3
    assert (vehicle.ahead, kinds(vehicle), vehicle.machine.driving) == ("", ["orderError"], False)
    assert vehicle.machine.order_id == "o"
    again = restart(vehicle)
    assert (again.drives, again.begun, kinds(again)) == ([], [], ["orderError"])
    again.order(update=1, nodes="bc", first=2)
    assert again.drives == [], "an update of what is over"
    again.order("new", nodes="ab")
    assert (again.drives, kinds(again)) == (["b"], [])


def test_an_orderly_end_without_an_order_tells_nothing(vehicle: PureVehicle) -> None:
    """A finished order stays finished."""
    vehicle.order(nodes="ab")
    vehicle.arrive()
    vehicle.take(vehicle.machine.shut_down("it was ended"))
    assert kinds(vehicle) == []


def test_an_action_does_not_run_again_after_a_restart(vehicle: PureVehicle) -> None:
    """Nobody knows how it ended, so it FAILED; that it began was on disk before it began."""
    vehicle.order(nodes="ab", node_actions={"a": [action("x", blocking="HARD")]})
    assert vehicle.begun == ["x"]
    again = restart(vehicle)
    assert again.begun == []
    assert again.status("x") == "FAILED"
    assert kinds(again) == ["orderHeld", "orderActionError"]


def test_a_cancel_is_finished_after_a_restart(vehicle: PureVehicle) -> None:
    """And the order does not go on."""
    vehicle.order()
    vehicle.instant(action("x", "cancelOrder"))
    again = restart(vehicle)
    assert again.status("x") == "FINISHED"
    assert again.drives == []
    assert again.ahead == ""


def test_a_pause_outlives_a_restart(vehicle: PureVehicle) -> None:
    """Nothing begins to move by itself."""
    vehicle.order()
    vehicle.instant(action("p", "startPause"))
    again = restart(vehicle)
    assert again.machine.paused
    assert again.drives == []


def test_what_is_restored_is_what_was_saved(vehicle: PureVehicle) -> None:
    """Every part of it."""
    vehicle.order(
        nodes="abc",
        released=2,
        node_actions={"c": [action("w", times=2)]},
        edge_actions={"bc": [action("e")]},
    )
    vehicle.order("late", nodes="cd")
    kept = json.loads(json.dumps(vehicle.machine.to_json()))
    assert OrderMachine.from_json(kept, LIMITS).to_json() == {**kept, "driving": False}


# -- memory ----------------------------------------------------------------------------------------------------


def test_an_order_that_is_extended_for_ever_fills_no_memory(
    vehicle: PureVehicle, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ended actions of long ago are forgotten; the ids go on."""
    monkeypatch.setattr("woosh_pure.fleet.order.order_state.MOST_ACTION_STATES", 40)
    vehicle.order(nodes="a")
    for n in range(1, 150):
        first, last = ("a", "b") if n % 2 else ("b", "a")
        vehicle.order(update=n, nodes=first + last, first=2 * n - 2, node_actions={last: [action(f"x{n}")]})
        vehicle.arrive()
        vehicle.finish(f"x{n}")
    assert len(vehicle.machine.action_states) <= 41
    assert vehicle.machine.update == 149
    assert kinds(vehicle) == []


# -- what wants the vehicle to stand ---------------------------------------------------------------------------


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


# -- a disk that takes nothing ----------------------------------------------------------------------------------


def test_a_disk_that_takes_nothing_lets_it_reach_the_next_node_and_begin_nothing() -> None:
    """What began now might begin again after a restart; when the disk is back all goes on."""
    full = Problem("storageError", "no space", (), Level.FATAL)
    vehicle = PureVehicle()
    vehicle.order(node_actions={"b": [action("x", blocking="NONE")]})
    assert vehicle.drives == ["b"]
    vehicle.take(vehicle.machine.set_storage_problem(full))
    assert (vehicle.halts, vehicle.problems) == (0, ["storageError"])
    vehicle.place(1.9)
    assert (vehicle.drives, vehicle.begun) == (["b"], [])
    vehicle.arrive()
    assert (vehicle.machine.last_node, vehicle.drives, vehicle.begun) == ("b", ["b"], [])
    vehicle.take(vehicle.machine.set_storage_problem(None))
    assert (vehicle.drives, vehicle.begun, vehicle.problems) == (["b", "c"], ["x"], [])


def test_it_halts_for_a_pause_also_without_a_disk() -> None:
    """To stand still is never refused."""
    vehicle = PureVehicle()
    vehicle.order()
    vehicle.take(vehicle.machine.set_storage_problem(Problem("storageError", "no space", (), Level.FATAL)))
    vehicle.instant(action("p", "startPause"))
    assert vehicle.halts == 1


def test_a_rehearsal_leaves_no_trace() -> None:
    """And ends as the order itself does."""
    vehicle = PureVehicle()
    before = vehicle.machine.to_json()
    order = read_order(order_json(node_actions={"a": [action("x")]}))
    rehearsal = vehicle.machine.trial_copy()
    rehearsal.receive(order)
    assert vehicle.machine.to_json() == before
    assert vehicle.machine.receive(order)
    assert vehicle.machine.to_json() == rehearsal.to_json()
