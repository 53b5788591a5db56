"""The published messages: state, visualization and factsheet, in both versions of the standard."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any, cast

import pytest

from rosproto.codec import message_class
from tests.support.fleet import LIMITS, PureVehicle, action, order_json
from tests.support.light_chassis import LightChassis
from woosh_pure.fleet.chassis_facts import ChassisFacts, Load, MapEntry
from woosh_pure.fleet.config import VehicleConfig
from woosh_pure.fleet.messages.parsing import read_order
from woosh_pure.fleet.monitor import ChassisMonitor, operating_mode
from woosh_pure.fleet.order.errors import Problem
from woosh_pure.fleet.order.events import ProblemChanged
from woosh_pure.fleet.order.state import OrderState
from woosh_pure.fleet.order.vehicle_limits import AgvPosition
from woosh_pure.fleet.published_messages import (
    MessageHeaders,
    StateMessages,
    factsheet_message,
    visualization_message,
)
from woosh_pure.values import Parameters

CONFIG = VehicleConfig(manufacturer="W", serial="1")
HEADER = MessageHeaders("2.1.0", "Woosh", "1").header("state")


def state_message(
    order: OrderState, known: ChassisFacts, header: dict[str, object], version: str
) -> dict[str, Any]:
    return dict(json.loads(StateMessages(version).text(order, known, header)))


def facts() -> ChassisFacts:
    return ChassisFacts(
        position=AgvPosition(1.0, 2.0, 0.5), located=True, velocity=(0.3, 0.0, 0.0), percent=80.0, voltage=25.0,
        map_id="hall", maps=(MapEntry("hall"),), loads=(Load("l1"),), faults=(("a fault", True),),
        emergency_stop=True,
    )  # fmt: skip


def test_a_state_tells_order_actions_and_chassis() -> None:
    """Nodes and edges that are ahead, how actions stand, pose, battery, faults, safety."""
    vehicle = PureVehicle()
    vehicle.order(nodes="abc", released=2, node_actions={"b": [action("x")]})
    found = state_message(vehicle.state, facts(), HEADER, "2.1.0")
    assert (found["orderId"], found["lastNodeId"], found["lastNodeSequenceId"]) == ("o", "a", 0)
    assert [(n["nodeId"], n["released"]) for n in found["nodeStates"]] == [("b", True), ("c", False)]
    assert [(e["edgeId"], e["released"]) for e in found["edgeStates"]] == [("ab", True), ("bc", False)]
    assert found["actionStates"] == [{"actionId": "x", "actionType": "beep", "actionStatus": "WAITING"}]
    assert found["driving"]
    assert found["newBaseRequest"]
    assert found["agvPosition"] == {
        "x": 1.0,
        "y": 2.0,
        "theta": 0.5,
        "mapId": "hall",
        "positionInitialized": True,
    }
    assert found["batteryState"] == {"batteryCharge": 80.0, "charging": False, "batteryVoltage": 25.0}
    assert found["safetyState"] == {"eStop": "MANUAL", "fieldViolation": False}
    assert found["loads"] == [{"loadId": "l1"}]
    assert [(e["errorType"], e["errorLevel"]) for e in found["errors"]] == [("chassisError", "FATAL")]
    json.dumps(found, allow_nan=False)


def test_texts_of_earlier_messages_are_used_again_and_change_nothing() -> None:
    """Nodes go, actions change, come behind and come beside each other: each message is as a first one."""
    vehicle, messages = PureVehicle(), StateMessages("2.1.0")

    def same() -> bool:
        given = vehicle.state, facts(), HEADER
        return messages.text(*given) == StateMessages("2.1.0").text(*given)

    vehicle.order(nodes="abc", released=2, node_actions={"b": [action("x")]})
    assert same()
    vehicle.instant(action("i"))
    assert same()
    vehicle.instant(action("j"), action("k"))
    assert same()
    vehicle.finish("j")
    vehicle.arrive()
    assert same()
    vehicle.order(update=1, nodes="bcd", first=2, node_actions={"c": [action("y")]})
    assert same()


@pytest.mark.parametrize("version", ["2.0.0", "2.1.0"])
def test_the_planned_path_is_the_trajectory_of_the_edge_that_is_driven(version: str) -> None:
    """A NURBS of degree 1 through its corners; not the path of the drive before, nor one while nothing drives."""
    vehicle = PureVehicle()
    way = ((0.0, 0.0), (1.0, 0.25), (2.1, 0.0))
    known = replace(facts(), path=way)

    def edges() -> list[dict[str, Any]]:
        return list(state_message(vehicle.state, known, HEADER, version)["edgeStates"])

    assert edges() == []
    vehicle.order(nodes="abc")
    first, second = edges()
    assert first.pop("trajectory") == {
        "degree": 1,
        "knotVector": [0.0, 0.0, 0.5, 1.0, 1.0],
        "controlPoints": [{"x": x, "y": y} for x, y in way],
    }
    assert "trajectory" not in second
    vehicle.arrive()
    assert vehicle.ahead == "c"
    assert edges() == [{"edgeId": "bc", "sequenceId": 3, "released": True}]
    known = replace(known, path=((2.0, 0.0), (4.0, 0.0)))
    assert "trajectory" in edges()[0]
    vehicle.instant(action("p", "startPause"))
    vehicle.stop()
    assert "trajectory" not in edges()[0]


def test_a_long_path_is_thinned_and_one_of_another_frame_left_out() -> None:
    """Its first and last points stay."""
    chassis, known = LightChassis(), ChassisFacts()
    told: list[Any] = []
    ChassisMonitor(
        cast(Any, chassis), known, lambda: None, lambda: told.append(known.path), lambda flag: None
    ).open()
    for count, frame in ((1001, "map"), (100, "/map"), (2, "map"), (0, "map"), (5, "odom")):
        path = message_class("nav_msgs/Path")()
        path.header.frame_id = frame
        for n in range(count):
            path.poses.append(message_class("geometry_msgs/PoseStamped")())
            path.poses[-1].pose.position.x = float(n)
        chassis.plan.tell(path)
    assert [len(path) for path in told] == [92, 100, 2, 0, 0]
    assert [(path[0][0], path[-1][0]) for path in told[:3]] == [(0.0, 1000.0), (0.0, 99.0), (0.0, 1.0)]


def test_what_version_two_nought_does_not_know_is_left_out() -> None:
    """Maps and hints."""
    vehicle = PureVehicle()
    vehicle.apply(ProblemChanged("x", Problem("t", "d", hint="h")))
    old = state_message(vehicle.state, facts(), HEADER, "2.0.0")
    new = state_message(vehicle.state, facts(), HEADER, "2.1.0")
    assert "maps" not in old
    assert new["maps"] == [{"mapId": "hall", "mapVersion": "1", "mapStatus": "ENABLED"}]
    assert ["errorHint" in error for error in (old["errors"][-1], new["errors"][-1])] == [False, True]


@pytest.mark.parametrize("may_move", [False, True])
def test_a_lost_robot_is_not_said_to_stand_where_it_was(may_move: bool) -> None:
    """Its position is not initialised, it may be driving if it was, and its velocity is left out."""
    known = replace(facts(), lost=True, may_move=may_move, velocity=None)
    found = state_message(PureVehicle().state, known, HEADER, "2.1.0")
    assert found["driving"] is may_move
    assert found["agvPosition"]["positionInitialized"] is False
    assert "velocity" not in found
    told = visualization_message(known, HEADER)
    assert told["agvPosition"]["positionInitialized"] is False


def test_what_is_not_known_is_left_out() -> None:
    """An unknown pose is omitted, and not sent as zeros."""
    vehicle = PureVehicle()
    found = state_message(vehicle.state, ChassisFacts(), HEADER, "2.1.0")
    assert not {"agvPosition", "velocity", "loads"} & set(found)
    assert visualization_message(ChassisFacts(), HEADER) == HEADER


@pytest.mark.parametrize(
    ("mode", "owner", "told"),
    [
        (0, "", "AUTOMATIC"),
        (1, "", "AUTOMATIC"),
        (2, "", "MANUAL"),
        (3, "", "SERVICE"),
        (1, "viewer 1", "MANUAL"),
    ],
)
def test_the_operating_mode_tells_who_drives(mode: int, owner: str, told: str) -> None:
    """The robot's key, or a local driver who has the lease."""
    assert operating_mode(mode, owner=owner) == told


@pytest.mark.parametrize("version", ["2.0.0", "2.1.0"])
def test_the_factsheet_tells_what_is_obeyed(version: str) -> None:
    """Actions with their scopes and parameters, fields of orders, size and speed."""
    config = VehicleConfig(manufacturer="W", serial="1", version=version, visualization=0.5)
    known = Parameters(0.5, 0.4, 25.0, 25.0, 10000, 3000.0, 0.01, 1.5, 1.2, 1.0, 0.5, 0.8)
    outline = ((0.4, 0.3), (-0.4, 0.3), (-0.4, -0.3), (0.4, -0.3))
    found = factsheet_message(config, LIMITS, HEADER, known, outline)
    actions = {each["actionType"]: each for each in found["protocolFeatures"]["agvActions"]}
    assert {"cancelOrder", "startPause", "beep", "initPosition"} <= set(actions)
    assert actions["cancelOrder"]["actionScopes"] == ["INSTANT"]
    assert actions["beep"]["actionParameters"][0]["key"] == "times"
    parameters = {
        each["parameter"]: each["support"] for each in found["protocolFeatures"]["optionalParameters"]
    }
    assert parameters["order.nodes.nodePosition"] == "REQUIRED"
    assert not any("trajectory" in name or "corridor" in name for name in parameters)
    assert found["physicalParameters"]["length"] == pytest.approx(0.8)
    assert found["physicalParameters"]["speedMax"] == 1.2
    assert ("vehicleConfig" in found) == (version == "2.1.0")
    assert found["protocolLimits"]["timing"]["visualizationInterval"] == 0.5
    assert found["agvGeometry"]["envelopes2d"][0]["polygonPoints"][0] == {"x": 0.4, "y": 0.3}


def test_an_outline_that_nobody_tells_is_not_guessed() -> None:
    """Zero, which means "not known" in the standard, and no envelope."""
    found = factsheet_message(CONFIG, LIMITS, HEADER, None, ())
    assert (found["physicalParameters"]["length"], found["physicalParameters"]["width"]) == (0.0, 0.0)
    assert found["agvGeometry"] == {}
    assert "order.zoneSetId" not in str(found)


def test_a_zone_set_is_told_where_there_is_one() -> None:
    """An order of it is taken, one of another is rejected with the field."""
    limits = replace(LIMITS, zone_set="zones-1")
    for name, kinds in (("zones-1", []), ("zones-2", ["orderError"]), ("", [])):
        vehicle = PureVehicle(limits)
        order = {**order_json(), "zoneSetId": name}
        vehicle.apply(read_order(order))
        assert vehicle.problems == kinds
    known = ChassisFacts(zone_set="zones-1")
    assert state_message(PureVehicle().state, known, HEADER, "2.1.0")["zoneSetId"] == "zones-1"
    assert "order.zoneSetId" in str(factsheet_message(CONFIG, limits, HEADER, None, ()))
