"""Orders over several maps (6.6.6, 6.7.1, "Elevator" in 6.8.1): initPosition leads from one to the next."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from tests.support.fleet import LIMITS, PureVehicle, action, order_json
from tests.support.fleet_orders import kinds, restart
from woosh_pure.fleet.action_handlers.predefined_actions import PARAMETERS, SCOPES
from woosh_pure.fleet.messages.parsing import read_order
from woosh_pure.fleet.order.action_states import SupportedAction
from woosh_pure.fleet.order.events import DriveEnded, PositionMeasured
from woosh_pure.fleet.order.vehicle_limits import AgvPosition

TO_ANOTHER = SupportedAction("initPosition", SCOPES["initPosition"], PARAMETERS["initPosition"], still=True)
BOTH = replace(LIMITS, maps=("hall", "up"), actions={**LIMITS.actions, "initPosition": TO_ANOTHER})


@pytest.fixture
def vehicle() -> PureVehicle:
    """On a, with two maps enabled."""
    found = PureVehicle(BOTH)
    found.apply(PositionMeasured(AgvPosition(0.0, 0.0, 0.0, "hall")))
    return found


def lift(name: str = "lift", map_id: str = "up") -> dict[str, Any]:
    return action(name, "initPosition", x=2.0, y=0.0, theta=0.0, mapId=map_id)


def over_two(*, lifts: list[Any] | None = None, **given: Any) -> dict[str, Any]:
    """a and b in the hall, c and d upstairs."""
    data = order_json(nodes="abcd", node_actions={"b": [lift()] if lifts is None else lifts}, **given)
    for node in data["nodes"][2:]:
        node["nodePosition"]["mapId"] = "up"
    return data


def take(vehicle: PureVehicle, data: dict[str, Any]) -> None:
    vehicle.apply(read_order(data))


def stand(vehicle: PureVehicle, x: float, map_id: str) -> None:
    vehicle.apply(PositionMeasured(AgvPosition(x, 0.0, 0.0, map_id)))


def to_the_lift(vehicle: PureVehicle) -> None:
    assert vehicle.drive is not None
    token, vehicle.drive = vehicle.drive.token, None
    stand(vehicle, 2.0, "hall")
    vehicle.apply(DriveEnded(token, True))
    vehicle.rest()


def test_the_map_changes_at_the_node_whose_action_changes_it(vehicle: PureVehicle) -> None:
    """It stops there, waits for the end of initPosition, and drives on in the other map."""
    take(vehicle, over_two())
    stand(vehicle, 1.9, "hall")
    assert (vehicle.drives, vehicle.begun) == (["b"], []), "a map is not changed under a robot that drives"
    to_the_lift(vehicle)
    assert (vehicle.drives, vehicle.begun) == (["b"], ["lift"])
    stand(vehicle, 2.0, "up")
    assert vehicle.drives == ["b"]
    vehicle.finish("lift")
    assert vehicle.drives == ["b", "c"]
    assert kinds(vehicle) == []


def test_a_node_of_another_map_is_never_driven_to(vehicle: PureVehicle) -> None:
    """All maps have one origin, so its numbers mean a place here, too; and the action that failed changed none."""
    take(vehicle, over_two())
    to_the_lift(vehicle)
    vehicle.finish("lift", False, "the map was refused")
    assert vehicle.drives == ["b"]
    assert kinds(vehicle) == ["driveError", "orderActionError"]
    problem = next(iter(vehicle.state.problems))
    assert (problem.references.get("nodeId"), problem.references.get("mapId"), problem.level) == (
        "c",
        "up",
        "FATAL",
    )
    stand(vehicle, 4.0, "hall")
    assert vehicle.visited[-1] == ("b", 2), "x and y are those of c, and the map is not"
    vehicle.instant(action("x", "cancelOrder"))
    assert (vehicle.status("x"), vehicle.ahead, kinds(vehicle)) == ("FINISHED", "", ["orderActionError"])


def test_a_map_that_is_not_on_the_vehicle_is_rejected(vehicle: PureVehicle) -> None:
    """6.7.1: for each mapId of an order a map must be there, of the horizon, too."""
    data = over_two(released=1)
    data["nodes"][3]["nodePosition"]["mapId"] = "cellar"
    take(vehicle, data)
    (problem,) = vehicle.state.problems
    assert problem.kind == "orderError"
    assert problem.references.get("field") == "nodes[3].nodePosition.mapId"
    assert (problem.references.get("nodeId"), problem.references.get("mapId")) == ("d", "cellar")


@pytest.mark.parametrize(
    "lifts", [[], [lift(map_id="hall")], [action("beep")], [lift("x"), lift("y", "hall")]]
)
def test_an_order_that_does_not_say_how_the_map_is_changed_is_rejected(
    vehicle: PureVehicle, lifts: list[Any]
) -> None:
    """Nobody but the manager knows when the lift is upstairs."""
    take(vehicle, over_two(lifts=lifts))
    (problem,) = vehicle.state.problems
    assert (problem.kind, problem.references.get("nodeId")) == ("orderError", "c")
    assert problem.references.get("field") == "nodes[2].nodePosition.mapId"
    assert "initPosition" in problem.description
    assert vehicle.drives == []


def test_an_order_that_changes_the_map_and_goes_on_in_the_old_one_is_rejected(vehicle: PureVehicle) -> None:
    """The node after the change is on the wrong map."""
    take(vehicle, order_json(nodes="abc", node_actions={"b": [lift()]}))
    (problem,) = vehicle.state.problems
    assert (problem.kind, problem.references.get("nodeId")) == ("orderError", "c")


def test_an_order_that_begins_on_another_map_is_out_of_reach(vehicle: PureVehicle) -> None:
    """Its x and y are near, its floor is not."""
    data = order_json(nodes="ab")
    for node in data["nodes"]:
        node["nodePosition"]["mapId"] = "up"
    take(vehicle, data)
    (problem,) = vehicle.state.problems
    assert (problem.kind, problem.references.get("nodeId"), problem.references.get("mapId")) == (
        "noRouteError",
        "a",
        "up",
    )


def test_an_update_goes_on_from_the_map_that_its_first_node_ends_on(vehicle: PureVehicle) -> None:
    """What stands at the decision point is what was sent before, whatever the update says there."""
    take(vehicle, order_json(nodes="ab", node_actions={"b": [lift()]}))
    more = over_two(update=1, lifts=[])
    more["nodes"], more["edges"] = more["nodes"][1:], more["edges"][1:]
    take(vehicle, more)
    assert kinds(vehicle) == []
    assert vehicle.ahead == "bcd"


def test_an_update_onto_another_map_without_the_change_is_rejected(vehicle: PureVehicle) -> None:
    """Actions that the update names at its first node are not taken, so they change nothing."""
    take(vehicle, order_json(nodes="ab"))
    more = over_two(update=1)
    more["nodes"], more["edges"] = more["nodes"][1:], more["edges"][1:]
    take(vehicle, more)
    assert kinds(vehicle) == ["orderError"]
    assert vehicle.ahead == "b"


def test_a_map_of_the_order_is_not_replaced_beside_it(vehicle: PureVehicle) -> None:
    """Neither the one in use nor one of a node to come."""
    take(vehicle, over_two())
    for name in ("hall", "up"):
        vehicle.instant(action(name, "enableMap", mapId=name, mapVersion="2"))
    assert (vehicle.status("hall"), vehicle.status("up")) == ("FAILED", "FAILED")


def test_after_a_restart_the_map_is_looked_at_again(vehicle: PureVehicle) -> None:
    """Killed while the map was changed: whichever the chassis has now decides."""
    take(vehicle, over_two())
    to_the_lift(vehicle)
    again = restart(vehicle, BOTH)
    again.apply(PositionMeasured(AgvPosition(2.0, 0.0, 0.0, "hall")))
    again.instant(action("go", "stopPause"))
    assert (again.drives, again.status("lift")) == ([], "FAILED")
    assert "driveError" in kinds(again)
    again.apply(PositionMeasured(AgvPosition(2.0, 0.0, 0.0, "up")))
    assert again.drives == ["c"]
    assert "driveError" not in kinds(again)
