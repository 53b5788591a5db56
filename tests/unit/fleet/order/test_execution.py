"""Driving: nodes, base and horizon, updates on the way, drives that fail."""

from __future__ import annotations

from tests.support.fleet import PureVehicle, action, order_json
from tests.support.fleet_orders import finish_order, kinds
from woosh_pure.fleet.messages.parsing import read_order
from woosh_pure.fleet.order.events import DriveEnded, RetryDue
from woosh_pure.fleet.order.transition import RETRIES


def test_an_order_is_driven_node_by_node(vehicle: PureVehicle) -> None:
    """The first node counts as reached where the vehicle stands, the others one after the other."""
    vehicle.order()
    assert vehicle.drives == ["b"]
    assert vehicle.ahead == "bc"
    vehicle.arrive()
    vehicle.arrive()
    assert vehicle.drives == ["b", "c"]
    assert vehicle.visited == [("a", 0), ("b", 2), ("c", 4)]
    assert not vehicle.state.executing
    assert vehicle.state.edges == ()


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
    assert vehicle.state.wants_base
    vehicle.arrive()
    assert vehicle.drive is None
    assert vehicle.ahead == "cd"
    assert vehicle.state.executing
    vehicle.order(update=1, nodes="bc", first=2)
    assert vehicle.drives == ["b", "c"]
    assert vehicle.ahead == "c"
    assert not vehicle.state.wants_base


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
    assert not vehicle.state.executing


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
    vehicle.apply(read_order(data))
    assert vehicle.drives == ["a"]
    assert vehicle.begun == []
    vehicle.arrive()
    assert vehicle.begun == ["on_a"]
    assert vehicle.drives == ["a", "b"]


def test_a_drive_that_ends_beside_its_node_is_tried_again(vehicle: PureVehicle) -> None:
    """No node is skipped: the failure is reported, tried again with longer waits, and then left to a person."""
    vehicle.order(nodes="abc")
    for n, seconds in enumerate(RETRIES):
        assert vehicle.drive is not None
        vehicle.apply(DriveEnded(vehicle.drive.token, True))
        assert vehicle.retries[n] == seconds
        assert kinds(vehicle) == ["driveError"]
        vehicle.apply(RetryDue())
        assert kinds(vehicle) == []
    assert vehicle.drive is not None
    vehicle.apply(DriveEnded(vehicle.drive.token, False, "blocked"))
    (problem,) = vehicle.state.problems
    assert problem.level == "FATAL"
    assert "blocked" in problem.description
    assert problem.references.get("nodeId") == "b"
    assert vehicle.ahead == "bc"
    vehicle.instant(action("go", "stopPause"))
    assert vehicle.drives == ["b"] * 5


def test_the_end_of_a_drive_that_was_replaced_means_nothing(vehicle: PureVehicle) -> None:
    """Passing b, the drive to b ends as replaced: the one to c goes on."""
    vehicle.order()
    assert vehicle.drive is not None
    first = vehicle.drive.token
    vehicle.place(1.9)
    vehicle.apply(DriveEnded(first, False, "replaced"))
    assert vehicle.drives == ["b", "c"]
    assert kinds(vehicle) == []
