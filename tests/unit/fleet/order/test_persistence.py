"""The order after a restart, with a failing disk, and with endless updates."""

from __future__ import annotations

import json

import pytest

from tests.support.fleet import LIMITS, PureVehicle, action, instant, order_json
from tests.support.fleet_orders import kinds, restart
from woosh_pure.fleet.messages.parsing import read_instant_actions, read_order
from woosh_pure.fleet.order.events import ShutDown
from woosh_pure.fleet.order.state import read_state


def test_an_order_waits_after_a_restart_and_goes_on_when_told(vehicle: PureVehicle) -> None:
    """Base, horizon, actions and ids are as before; a program that was started moves nothing."""
    vehicle.order(nodes="abcd", released=3, node_actions={"c": [action("later", blocking="HARD")]})
    vehicle.arrive()
    again = restart(vehicle)
    assert (again.drives, again.ahead) == ([], "cd")
    assert kinds(again) == ["orderHeld"]
    assert (again.state.order_id, again.state.last_node) == ("o", "b")
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
    assert (again.state.update, again.ahead, again.drives) == (1, "bc", [])
    again.instant(action("go", "stopPause"))
    assert again.drives == ["b"]


def test_actions_wait_with_a_restored_order(vehicle: PureVehicle) -> None:
    """A pause lets actions go on; after a restart no action starts by itself either."""
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
    assert not again.state.held
    again.order(update=1, nodes="bc", first=2)
    assert again.drives == ["c"]


def test_an_orderly_end_ends_the_order(vehicle: PureVehicle) -> None:
    """Running and waiting actions fail, and this is published; the next start has no order."""
    vehicle.order(nodes="ab", node_actions={"a": [action("x")], "b": [action("y")]})
    vehicle.instant(action("i"))
    vehicle.apply(ShutDown("it was ended"))
    assert [vehicle.status(name) for name in "xyi"] == ["FAILED"] * 3
    assert (vehicle.ahead, kinds(vehicle), vehicle.state.driving) == ("", ["orderError"], False)
    assert vehicle.state.order_id == "o"
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
    vehicle.apply(ShutDown("it was ended"))
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
    assert again.state.paused
    assert again.drives == []


def test_what_is_restored_is_what_was_saved(vehicle: PureVehicle) -> None:
    """Every part of it; what was driving then may still be under way."""
    vehicle.order(
        nodes="abc",
        released=2,
        node_actions={"c": [action("w", times=2)]},
        edge_actions={"bc": [action("e")]},
    )
    vehicle.order("late", nodes="cd")
    kept = json.loads(json.dumps(vehicle.state.to_json()))
    assert read_state(kept, LIMITS).to_json() == {**kept, "driving": True}


def test_an_order_that_is_extended_for_ever_fills_no_memory(
    vehicle: PureVehicle, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ended actions of long ago are forgotten; the ids go on."""
    monkeypatch.setattr("woosh_pure.fleet.order.transition.MAX_ACTION_STATES", 40)
    vehicle.order(nodes="a")
    for n in range(1, 150):
        first, last = ("a", "b") if n % 2 else ("b", "a")
        vehicle.order(update=n, nodes=first + last, first=2 * n - 2, node_actions={last: [action(f"x{n}")]})
        vehicle.arrive()
        vehicle.finish(f"x{n}")
    assert len(vehicle.state.action_states) <= 41
    assert vehicle.state.update == 149
    assert kinds(vehicle) == []


def test_a_disk_that_takes_nothing_lets_it_reach_the_next_node_and_begin_nothing() -> None:
    """What began now might begin again after a restart; when the disk is back all goes on."""
    vehicle = PureVehicle()
    vehicle.order(node_actions={"b": [action("x", blocking="NONE")]})
    assert vehicle.drives == ["b"]
    vehicle.disk.full = True
    vehicle.place(1.9)
    assert (vehicle.drives, vehicle.begun, vehicle.ahead) == (["b"], [], "bc"), "passing b was not written"
    assert (vehicle.halts, vehicle.problems) == (0, ["storageError"])
    vehicle.arrive()
    assert (vehicle.state.last_node, vehicle.drives, vehicle.begun) == ("b", ["b"], [])
    vehicle.write()
    assert vehicle.drives == ["b"], "it is full still"
    vehicle.disk.full = False
    vehicle.write()
    assert (vehicle.drives, vehicle.begun, vehicle.problems) == (["b", "c"], ["x"], [])


def test_it_halts_for_a_pause_also_without_a_disk() -> None:
    """To stand still is never refused."""
    vehicle = PureVehicle()
    vehicle.order()
    vehicle.disk.full = True
    vehicle.instant(action("p", "startPause"))
    assert (vehicle.halts, vehicle.state.paused) == (1, True)


def test_no_order_is_taken_that_was_not_written() -> None:
    """It is rejected, the order that is carried out stays as it is, and so does what is on the disk."""
    vehicle = PureVehicle()
    vehicle.order("first", nodes="abc", released=2)
    kept = vehicle.disk.kept
    vehicle.disk.full = True
    vehicle.order("first", 1, nodes="bc", first=2)
    assert (vehicle.state.update, vehicle.ahead, vehicle.drives) == (0, "bc", ["b"])
    assert vehicle.problems == ["storageError", "orderError"]
    assert vehicle.disk.kept == kept
    vehicle.disk.full = False
    vehicle.write()
    vehicle.order("first", 2, nodes="bc", first=2)
    assert (vehicle.state.update, vehicle.ahead, vehicle.problems) == (2, "bc", [])


def test_what_was_put_off_is_written_before_the_next_is_told() -> None:
    """A flood of requests costs one write, and is published after it."""
    vehicle = PureVehicle()
    saves, told = vehicle.disk.saves, vehicle.told
    for n in range(5):
        message = read_instant_actions(instant(action(f"r{n}", "stateRequest")))
        assert [*vehicle.order_machine.apply(message, later=True)] == []
    assert vehicle.order_machine.unsaved
    assert (vehicle.disk.saves, vehicle.told) == (saves, told)
    vehicle.write()
    assert (vehicle.disk.saves, vehicle.told) == (saves + 1, told + 1)
    assert vehicle.disk.kept is not None
    assert len(vehicle.disk.kept["records"]) == 5


def test_nothing_begins_that_is_not_on_disk() -> None:
    """At the moment when a drive or an action is given out, the file says so already."""
    vehicle = PureVehicle()
    order = read_order(order_json(node_actions={"a": [action("x")]}))
    for effect in vehicle.order_machine.apply(order):
        kept = vehicle.disk.kept
        assert kept is not None
        assert (kept["orderId"], kept["records"][0]["status"], kept["driving"]) == ("o", "RUNNING", True), (
            effect
        )
