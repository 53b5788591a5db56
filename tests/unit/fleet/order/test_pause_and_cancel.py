"""Pause, cancel, operating mode, a vehicle that does not know where it is."""

from __future__ import annotations

import pytest

from tests.support.fleet import LIMITS, PureVehicle, action
from tests.support.fleet_orders import finish_order, kinds
from woosh_pure.fleet.order.events import (
    ActionEnded,
    ContactChanged,
    DriveEnded,
    DriveTooFast,
    ModeChanged,
    PositionMeasured,
    RetryDue,
    StandingMeasured,
    StoppedByOthers,
)
from woosh_pure.fleet.order.state import first_state


def test_pause_halts_and_resume_drives_on(vehicle: PureVehicle) -> None:
    """startPause is FINISHED when the vehicle stands; the order is as it was."""
    vehicle.order(nodes="ab", edge_actions={"ab": [action("e")]})
    vehicle.instant(action("p", "startPause"))
    assert vehicle.status("p") == "RUNNING"
    assert vehicle.halting
    vehicle.stop()
    assert vehicle.status("p") == "FINISHED"
    assert vehicle.state.paused
    assert vehicle.drives == ["b"]
    vehicle.instant(action("r", "stopPause"))
    assert vehicle.status("r") == "FINISHED"
    assert vehicle.drives == ["b", "b"]
    assert vehicle.begun == ["e"], "the action of the edge does not begin again"
    finish_order(vehicle)
    assert vehicle.state.last_node == "b"


def test_a_pause_taken_back_at_once(vehicle: PureVehicle) -> None:
    """The pause failed, the halt that was asked for ends first, then the drive goes on."""
    vehicle.order(nodes="ab")
    vehicle.instant(action("p", "startPause"), action("r", "stopPause"))
    assert vehicle.status("p") == "FAILED"
    assert vehicle.status("r") == "FINISHED"
    if vehicle.halting:
        vehicle.stop()
    finish_order(vehicle)
    assert vehicle.state.last_node == "b"


def test_an_order_taken_while_paused_waits(vehicle: PureVehicle) -> None:
    """Nothing moves until stopPause."""
    vehicle.instant(action("p", "startPause"))
    assert vehicle.status("p") == "FINISHED"
    vehicle.order()
    assert vehicle.state.order_id == "o"
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
    assert vehicle.state.edges == ()
    assert (vehicle.state.order_id, vehicle.state.last_node) == ("o", "a")
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
    (problem,) = vehicle.state.problems
    assert (problem.kind, problem.level, problem.references.get("actionId")) == (
        "noOrderToCancel",
        "WARNING",
        "x",
    )
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
    assert vehicle.state.last_node == "b"
    assert vehicle.status("x") == "FINISHED"
    assert vehicle.drives == ["b"]


@pytest.mark.parametrize("mode", ["MANUAL", "SERVICE", "TEACHIN"])
def test_a_mode_of_others_clears_the_order(vehicle: PureVehicle, mode: str) -> None:
    """6.10.6: at once, with its actions; AUTOMATIC again does not bring it back."""
    vehicle.order(node_actions={"a": [action("r")], "c": [action("w")]})
    vehicle.apply(ModeChanged(mode))
    assert vehicle.halting
    assert vehicle.ended == ["r"]
    vehicle.stop()
    vehicle.finish("r", False)
    assert vehicle.ahead == ""
    assert kinds(vehicle) == ["orderError"]
    vehicle.apply(ModeChanged("AUTOMATIC"))
    assert vehicle.drives == ["b"]


def test_a_vehicle_that_is_lost_halts_and_goes_on_when_found(vehicle: PureVehicle) -> None:
    """The order is kept."""
    vehicle.order()
    vehicle.apply(PositionMeasured(None))
    assert vehicle.halting
    vehicle.stop()
    assert vehicle.drives == ["b"]
    vehicle.place(0.5)
    assert vehicle.drives == ["b", "b"]


def test_nothing_moves_before_the_mode_is_told() -> None:
    """A machine that was just made, or restored, is in SERVICE."""
    assert first_state(LIMITS).mode == "SERVICE"


@pytest.mark.parametrize("kind", ["cancelOrder", "startPause"])
def test_what_stops_is_finished_when_the_vehicle_was_measured_standing(kind: str) -> None:
    """The end of the drive says nothing of it: 0.79 m/s is not over when a goal is."""
    vehicle = PureVehicle(obeys=False)
    vehicle.order(nodes="abc")
    vehicle.instant(action("x", kind))
    vehicle.stop()
    assert vehicle.status("x") == "RUNNING"
    assert vehicle.state.waits_for_rest
    vehicle.apply(StandingMeasured(True))
    assert vehicle.status("x") == "FINISHED"
    assert not vehicle.state.waits_for_rest


@pytest.mark.parametrize("kind", ["cancelOrder", "startPause"])
def test_what_stops_runs_until_a_lost_robot_was_heard_to_stand(kind: str) -> None:
    """The link is lost under way: nobody knows whether the drive has ended. The stop is sent again when the robot
    is back, until it stands."""
    vehicle = PureVehicle(obeys=False)
    vehicle.order(nodes="abc")
    vehicle.apply(ContactChanged(False))
    vehicle.apply(PositionMeasured(None))
    vehicle.instant(action("x", kind))
    assert vehicle.halting
    vehicle.stop(known=False)
    assert (vehicle.status("x"), vehicle.stops) == ("RUNNING", 0)
    vehicle.apply(ContactChanged(True))
    vehicle.place(0.5)
    assert vehicle.stops == 1
    vehicle.apply(StandingMeasured(True))
    assert vehicle.status("x") == "RUNNING", "it may stand by chance, and go on"
    vehicle.stopped(False)
    assert vehicle.stops == 2, "it was not stopped: once more"
    vehicle.stopped(True)
    assert vehicle.status("x") == "RUNNING"
    vehicle.apply(StandingMeasured(True))
    assert vehicle.status("x") == "FINISHED"
    assert vehicle.drives == ["b"]


def test_a_drive_whose_end_is_not_known_is_stopped_before_it_is_tried_again() -> None:
    """The order goes on when the robot has been stopped."""
    vehicle = PureVehicle(obeys=False)
    vehicle.order(nodes="ab")
    vehicle.stop(known=False)
    assert vehicle.stops == 1
    assert vehicle.problems == ["driveError"]
    vehicle.apply(RetryDue())
    assert vehicle.drives == ["b"]
    vehicle.stopped(True)
    assert vehicle.drives == ["b", "b"]


def test_an_action_that_moves_and_whose_end_is_not_known_is_stopped() -> None:
    """A cancel waits for that, too."""
    vehicle = PureVehicle()
    vehicle.order(nodes="ab", node_actions={"a": [action("d", "dock")]})
    assert vehicle.begun == ["d"]
    vehicle.obeys = False
    vehicle.instant(action("x", "cancelOrder"))
    vehicle.apply(ActionEnded("d", False, "the link was lost", known=False))
    assert (vehicle.stops, vehicle.status("x")) == (1, "RUNNING")
    vehicle.stopped(True)
    vehicle.apply(StandingMeasured(True))
    assert vehicle.status("x") == "FINISHED"


@pytest.mark.parametrize("blocking", ["SOFT", "HARD"])
def test_an_action_that_blocks_begins_when_the_vehicle_was_measured_standing(blocking: str) -> None:
    """4 of 7 began while the robot was still coming to its stand."""
    vehicle = PureVehicle(obeys=False)
    vehicle.apply(StandingMeasured(True))
    vehicle.order(nodes="abc", node_actions={"b": [action("x", blocking=blocking)]})
    vehicle.arrive()
    assert vehicle.state.last_node == "b"
    assert vehicle.begun == []
    assert vehicle.drives == ["b"], "it waits there"
    vehicle.apply(StandingMeasured(True))
    assert vehicle.begun == ["x"]


def test_a_restart_while_it_drove_stops_the_robot_first() -> None:
    """What the process before had sent may still be under way."""
    vehicle = PureVehicle()
    vehicle.order(nodes="ab")
    again = PureVehicle(kept=vehicle.disk.kept, obeys=False)
    assert again.stops == 1
    again.instant(action("r", "stopPause"))
    assert again.drives == []
    again.stopped(True)
    assert again.drives == ["b"]


def test_a_drive_faster_than_its_edge_allows_is_ended_and_told() -> None:
    """At once as speedExceeded, then as a drive that failed, which is tried again."""
    vehicle = PureVehicle()
    vehicle.order(nodes="ab")
    vehicle.apply(DriveTooFast("it drove at 0.79 m/s, and edge ab allows 0.25 m/s"))
    assert vehicle.halting
    assert vehicle.problems == ["speedExceeded"]
    vehicle.stop()
    assert sorted(vehicle.problems) == ["driveError", "speedExceeded"]
    assert vehicle.drives == ["b"]
    vehicle.apply(RetryDue())
    assert vehicle.drives == ["b", "b"]


def test_no_order_is_taken_before_a_cancel_has_ended() -> None:
    """Also where no node is left and the last action is over: the cancel still waits for a measured stand, and would
    drop the new order with the old one. Another cancel joins the first."""
    vehicle = PureVehicle()
    vehicle.order(nodes="a", node_actions={"a": [action("d", "dock")]})
    vehicle.obeys = False
    vehicle.instant(action("x", "cancelOrder"))
    vehicle.finish("d", True)
    assert vehicle.status("x") == "RUNNING"
    vehicle.order("early", nodes="ab")
    assert (vehicle.state.order_id, kinds(vehicle)) == ("o", ["orderError"])
    vehicle.instant(action("y", "cancelOrder"))
    vehicle.apply(StandingMeasured(True))
    assert (vehicle.status("x"), vehicle.status("y")) == ("FINISHED", "FINISHED")
    vehicle.order("late", nodes="ab")
    assert vehicle.drives == ["b"]


# -- a stop by somebody else -----------------------------------------------------------------------------------


def test_a_stop_by_somebody_holds_the_order_until_stop_pause(vehicle: PureVehicle) -> None:
    """The drive is not tried again, and time, measurements and an update do not release it."""
    vehicle.order(nodes="abc", released=2)
    vehicle.apply(StoppedByOthers())
    vehicle.stop()
    assert (kinds(vehicle), vehicle.retries) == (["orderHeld"], [])
    (problem,) = vehicle.state.problems
    assert "somebody stopped the robot" in problem.description
    assert problem.references["orderId"] == "o"
    vehicle.apply(RetryDue())
    vehicle.order(update=1, nodes="bc", first=2)
    vehicle.place(1.0)
    assert vehicle.drives == ["b"]
    vehicle.instant(action("r", "stopPause"))
    assert (vehicle.drives, kinds(vehicle)) == (["b", "b"], [])
    finish_order(vehicle)
    assert vehicle.state.last_node == "c"


def test_an_order_that_a_stop_holds_can_be_cancelled(vehicle: PureVehicle) -> None:
    """And a new one drives: it is asked for after the stop."""
    vehicle.order(nodes="ab")
    vehicle.apply(StoppedByOthers())
    vehicle.stop()
    vehicle.instant(action("x", "cancelOrder"))
    assert (vehicle.status("x"), kinds(vehicle)) == ("FINISHED", [])
    vehicle.order("p", nodes="ab")
    assert vehicle.drives == ["b", "b"]


def test_a_drive_that_another_program_ended_holds_the_order(vehicle: PureVehicle) -> None:
    """`woosh stop` on another computer, or another client: only the outcome of the drive shows it."""
    vehicle.order(nodes="ab")
    assert vehicle.drive is not None
    vehicle.apply(DriveEnded(vehicle.drive.token, False, "preempted", by_others=True))
    vehicle.drive = None
    vehicle.rest()
    vehicle.apply(RetryDue())
    assert (kinds(vehicle), vehicle.drives) == (["orderHeld"], ["b"])
    vehicle.instant(action("r", "stopPause"))
    assert vehicle.drives == ["b", "b"]


def test_an_action_that_another_program_ended_holds_the_order(vehicle: PureVehicle) -> None:
    """It has failed, and what follows waits."""
    vehicle.order(nodes="ab", node_actions={"a": [action("d", "dock", "HARD"), action("later")]})
    vehicle.apply(ActionEnded("d", False, "preempted", by_others=True))
    vehicle.rest()
    assert sorted(kinds(vehicle)) == ["orderActionError", "orderHeld"]
    assert (vehicle.begun, vehicle.drives) == (["d"], [])
    vehicle.instant(action("r", "stopPause"))
    assert vehicle.begun == ["d", "later"]


def test_after_a_stop_an_action_that_was_waiting_to_move_the_robot_does_not(vehicle: PureVehicle) -> None:
    """It fails, also without an order; one that is sent after the stop begins."""
    vehicle.instant(action("w", "weld", "HARD"), action("d", "dock", "HARD"))
    vehicle.apply(StoppedByOthers())
    assert vehicle.status("d") == "FAILED"
    vehicle.finish("w")
    vehicle.instant(action("d2", "dock", "HARD"))
    assert vehicle.begun == ["w", "d2"]


def test_after_a_stop_without_an_order_the_next_one_drives(vehicle: PureVehicle) -> None:
    """What is asked for afterwards drives."""
    vehicle.apply(StoppedByOthers())
    vehicle.order(nodes="ab")
    assert (vehicle.drives, kinds(vehicle)) == (["b"], [])
