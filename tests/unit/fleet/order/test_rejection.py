"""Rejections: 6.6.4 and figure 8."""

from __future__ import annotations

from typing import Any

import pytest

from tests.support.fleet import PureVehicle, action, order_json
from tests.support.fleet_orders import kinds
from woosh_pure.fleet.messages.parsing import Invalid, read_order
from woosh_pure.fleet.order.events import MalformedMessage, ModeChanged, PositionMeasured


@pytest.mark.promise("is answered with `validationError` and changes nothing")
def test_a_malformed_order_is_a_validation_error(vehicle: PureVehicle) -> None:
    """6.6.4.1: it is rejected, and reported with its readable fields until an order is accepted."""
    data = order_json("bad")
    del data["nodes"][1]["released"]
    with pytest.raises(Invalid) as caught:
        read_order(data)
    vehicle.apply(MalformedMessage(data, caught.value))
    (problem,) = vehicle.state.problems
    assert (problem.kind, problem.level) == ("validationError", "WARNING")
    assert problem.references == {
        "topic": "order", "headerId": "7", "orderId": "bad", "orderUpdateId": "0",
        "field": "nodes[1].released",
    }  # fmt: skip
    assert vehicle.state.order_id == ""
    vehicle.order()
    assert kinds(vehicle) == []


def test_a_new_order_is_rejected_while_one_is_carried_out(vehicle: PureVehicle) -> None:
    """Figure 8, 3; the running one goes on."""
    vehicle.order()
    vehicle.order("p", nodes="ab")
    assert kinds(vehicle) == ["orderError"]
    assert vehicle.state.order_id == "o"
    assert vehicle.drives == ["b"]
    assert next(iter(vehicle.state.problems)).references.get("orderId") == "p"


def test_a_new_order_is_rejected_while_one_waits_for_its_base(vehicle: PureVehicle) -> None:
    """A horizon is an order that is not over."""
    vehicle.order(nodes="abc", released=1)
    assert vehicle.drive is None
    vehicle.order("p", nodes="ab")
    assert kinds(vehicle) == ["orderError"]


def test_a_new_order_is_rejected_while_an_action_of_the_last_runs(vehicle: PureVehicle) -> None:
    """All nodes are reached, and an action is not at its end."""
    vehicle.order(nodes="a", node_actions={"a": [action("long")]})
    assert vehicle.state.nodes == ()
    vehicle.order("p", nodes="ab")
    assert kinds(vehicle) == ["orderError"]
    vehicle.finish("long")
    vehicle.order("p", nodes="ab")
    assert vehicle.state.order_id == "p"
    assert kinds(vehicle) == []
    assert vehicle.status("long") == "", "states of the previous order are gone"


def test_a_first_node_out_of_reach_is_rejected(vehicle: PureVehicle) -> None:
    """Figure 8, 4."""
    vehicle.order(nodes="bc")
    assert kinds(vehicle) == ["noRouteError"]
    assert vehicle.state.order_id == ""
    assert vehicle.drives == []


def test_a_wide_range_makes_the_first_node_reached(vehicle: PureVehicle) -> None:
    """6.6.3.1: after a cancel an order may begin at the last node with a range that covers the vehicle."""
    vehicle.order(nodes="bc", deviation=2.5)
    assert vehicle.state.last_node == "b"
    assert vehicle.drives == ["c"]


def test_an_order_is_rejected_without_localisation(vehicle: PureVehicle) -> None:
    """Nobody knows whether the first node is near."""
    vehicle.apply(PositionMeasured(None))
    vehicle.order()
    assert kinds(vehicle) == ["noRouteError"]


@pytest.mark.parametrize("mode", ["MANUAL", "SERVICE", "TEACHIN"])
def test_an_order_is_rejected_in_the_modes_of_others(vehicle: PureVehicle, mode: str) -> None:
    """The fleet manager is not in control there."""
    vehicle.apply(ModeChanged(mode))
    vehicle.order()
    assert kinds(vehicle) == ["orderError"]
    assert vehicle.drives == []


def test_a_lower_update_is_rejected_and_the_order_goes_on(vehicle: PureVehicle) -> None:
    """6.6.4.3."""
    vehicle.order(update=3, nodes="abc", released=2)
    vehicle.order(update=2, nodes="bc", first=2)
    (problem,) = vehicle.state.problems
    assert (problem.kind, problem.level) == ("orderUpdateError", "WARNING")
    assert problem.references.get("orderUpdateId") == "2"
    assert vehicle.state.update == 3
    assert vehicle.ahead == "bc"
    vehicle.arrive()
    assert vehicle.state.last_node == "b"


def test_the_same_update_twice_is_ignored(vehicle: PureVehicle) -> None:
    """Nothing but a state comes of it, whatever is in it."""
    vehicle.order()
    before, drives = vehicle.told, list(vehicle.drives)
    vehicle.order(nodes="aq")
    assert vehicle.drives == drives
    assert vehicle.ahead == "bc"
    assert kinds(vehicle) == []
    assert vehicle.told == before + 1


@pytest.mark.parametrize(("nodes", "first"), [("bc", 2), ("cd", 2), ("cd", 6)])
def test_an_update_elsewhere_than_at_the_decision_point_is_rejected(
    vehicle: PureVehicle, nodes: str, first: int
) -> None:
    """Figure 8, 7: node id and sequence id of the last base node, both."""
    vehicle.order(nodes="abcd", released=3)
    vehicle.order(update=1, nodes=nodes, first=first)
    assert kinds(vehicle) == ["orderUpdateError"]
    assert vehicle.state.update == 0
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
    vehicle.apply(read_order(data))
    (problem,) = vehicle.state.problems
    assert problem.kind == "orderError"
    assert problem.references.get("edgeId") == "bc"
    assert problem.references.get("field") == f"edges[1].{named}"
    assert vehicle.drives == []


def test_fields_of_an_edge_that_are_obeyed_are_given_on(vehicle: PureVehicle) -> None:
    """Speed and direction of travel."""
    data = order_json()
    data["edges"][0].update(maxSpeed=0.3, orientation=3.14159, rotationAllowed=True, length=2.0)
    vehicle.apply(read_order(data))
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
    (problem,) = vehicle.state.problems
    assert problem.kind == "orderError"
    assert (problem.references.get("actionId"), problem.references.get("field")) == ("x", field)
    assert vehicle.state.order_id == ""


def test_other_things_a_vehicle_cannot_do_are_rejected(vehicle: PureVehicle) -> None:
    """A node without a place, one on a map that is not here, and zones."""
    nowhere, elsewhere, zones = order_json("n"), order_json("e"), order_json("z")
    del nowhere["nodes"][1]["nodePosition"]
    elsewhere["nodes"][2]["nodePosition"]["mapId"] = "cellar"
    zones["zoneSetId"] = "zones"
    for data in (nowhere, elsewhere, zones):
        vehicle.apply(read_order(data))
    assert kinds(vehicle) == ["orderError"] * 3
    fields = [problem.references.get("field") for problem in vehicle.state.problems]
    assert fields == ["nodes[1].nodePosition", "nodes[2].nodePosition.mapId", "zoneSetId"]


def test_an_update_with_an_action_that_has_run_is_rejected(vehicle: PureVehicle) -> None:
    """No action runs twice."""
    vehicle.order(nodes="ab", released=1, node_actions={"a": [action("once")]})
    vehicle.finish("once")
    vehicle.order(update=1, nodes="ab", node_actions={"b": [action("once")]})
    assert kinds(vehicle) == ["orderError"]
    assert vehicle.state.update == 0


def test_problems_of_orders_are_bounded(vehicle: PureVehicle) -> None:
    """Endless invalid messages do not fill the memory; the newest errors are reported."""
    for n in range(200):
        vehicle.order(f"far{n}", nodes="bc")
    found = list(vehicle.state.problems)
    assert len(found) == 24
    assert found[-1].references.get("orderId") == "far199"
