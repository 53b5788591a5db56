"""Every row of the table is served by the simulator, with the right type and md5sum; every feed gives a value."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import rosproto
from tests.support.waiting import until
from woosh_pure import Chassis, Footprint, OutcomeKind, Pose2D, SimulatedChassis, interface
from woosh_pure.enums import LedState, NavDirection, NavigationMode, RobotState
from woosh_pure.errors import ChassisError, GoalFailed
from woosh_pure.geometry import Velocity
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.values.messages import message_type

DEFINED = [row for row in interface.ROWS if row.definition_known]


@pytest.fixture(scope="module")
def full():
    """The whole graph, shared by the tests of this file that only look."""
    with SimulatedChassis(speed=4, assumed_types=True) as sim:
        yield sim


@pytest.fixture(scope="module")
def system(full):
    """(publishers, subscribers, services) by name, and the topic types, as the master tells them."""
    client = rosproto.MasterClient(full.master_uri, "/test")
    state = [{name: sorted(nodes) for name, nodes in group.items()} for group in client.get_system_state()]
    return (*state, client.get_topic_types())


def test_every_topic_has_its_nodes_and_its_type(system):
    publishers, subscribers, _, types = system
    for row in interface.topics():
        assert types[row.name] == row.type, row.name
        if row.flow == "read":
            assert publishers[row.name] == sorted(row.providers), row.name
            assert set(row.listeners) <= set(subscribers.get(row.name, [])), row.name
        else:
            assert set(row.providers) <= set(subscribers[row.name]), row.name


@pytest.mark.parametrize("row", interface.services(), ids=lambda r: r.name)
def test_every_service_is_provided_by_its_node_with_its_md5sum(full, system, row):
    assert system[2][row.name] == sorted(row.providers)
    with rosproto.Node("/probe", master_uri=full.master_uri, anonymous=True) as node:
        client = node.service_client(row.name, row.type)
        client.wait(5.0)


@pytest.mark.parametrize("row", interface.actions(), ids=lambda r: r.name)
def test_every_action_has_a_server_and_the_robots_own_client(system, row):
    publishers, subscribers, _, types = system
    for part in ("status", "feedback", "result"):
        assert publishers[f"{row.name}/{part}"] == sorted(row.providers)
    for part in ("goal", "cancel"):
        assert set(row.providers) <= set(subscribers[f"{row.name}/{part}"])
        assert publishers[f"{row.name}/{part}"] == ["/ros_interface"]
    assert types[f"{row.name}/goal"] == f"{row.type}ActionGoal"


SEEN = json.loads(Path(__file__).with_name("chassis_graph_seen.json").read_text(encoding="utf-8"))


def test_the_graph_is_that_of_a_real_one(system):
    """Every topic of the listing of a real chassis, with its type, its publishers and its subscribers.

    The node /rosout belongs to roscore, not to the chassis.
    """
    publishers, subscribers, _, types = system
    for topic in SEEN.keys() - {"/rosout"}:
        seen = SEEN[topic]
        assert set(seen["publishers"]) <= set(publishers.get(topic, [])), topic
        assert set(seen["subscribers"]) <= set(subscribers.get(topic, [])), topic
        assert types[topic] == seen["type"], topic


@pytest.mark.parametrize("row", interface.feeds(), ids=lambda r: r.feed)
def test_every_feed_gives_a_value_with_its_age(full, row):
    with Chassis(full.master_uri) as chassis:
        feed = chassis.feed(row.name).open()
        wait_connected(feed, len(row.providers))
        if row.name == "/robot_status":
            full.press_emergency_stop()
            feed.wait(5.0, new=False)
            full.release_emergency_stop()
        elif row.name == "/status_code":
            full.report(130104000011)
        elif row.name == "/move_base/global_plan":
            chassis.go_to(1.0, 0.5)
        value = feed.wait(10.0, new=False)
        assert value is not None
        assert 0.0 <= feed.age < 10.0
        assert feed.reading.message is not None
        assert feed.history[-1].value is not None


def wait_connected(feed, count):
    until(
        lambda: feed.publishers >= count,
        what=lambda: f"{feed.topic}: {feed.publishers} of {count} publishers;",
    )


def test_the_digital_inputs_show_the_red_button(sim, chassis):
    inputs = chassis.feed("inputs")
    assert [line.status for line in inputs.wait(5.0).IOs] == [0, 0]
    sim.press_emergency_stop()
    assert inputs.wait_for(lambda m: m.IOs[0].status == 1, 5.0)


def test_a_feed_iterates_and_calls_back(chassis):
    seen: list[Velocity] = []
    off = chassis.measured_velocity.on(seen.append)
    for number, value in enumerate(chassis.measured_velocity):
        assert isinstance(value, Velocity)
        if number == 3:
            break
    off()
    chassis.measured_velocity.wait(5.0)  # what was on its way to the callback then has arrived
    count = len(seen)
    chassis.measured_velocity.wait(5.0)
    assert len(seen) == count >= 3


def test_a_failing_callback_harms_nobody(chassis, caplog):
    chassis.odometer.on(lambda value: 1 / 0)
    chassis.odometer.wait(5.0)
    chassis.odometer.wait(5.0)
    assert "a callback failed" in caplog.text


def test_the_snapshot_has_everything_with_its_age(chassis):
    readings = chassis.snapshot(5.0)
    assert readings["battery"].value.percent == 87
    assert readings["battery"].age < 5.0
    assert readings["status"] is None
    assert "camera" not in readings


def test_images_depth_and_clouds_are_arrays(chassis):
    assert chassis.camera.wait(5.0).pixels.shape == (120, 160, 3)
    metres = chassis.depth.wait(5.0).depth_metres()
    assert metres.shape == (120, 160)
    assert metres[60, 79] == pytest.approx(3.5, abs=0.2)
    points, obstacles = chassis.points.wait(5.0).points, chassis.obstacle_points.wait(5.0).points
    assert points.shape[0] > obstacles.shape[0] > 100
    assert points[:, 1].max() == pytest.approx(0.5, abs=0.05)


def test_the_scan_sees_the_wall_behind(chassis):
    scan = chassis.scan.wait(5.0)
    assert scan.nearest == pytest.approx(1.5, abs=0.1)
    assert scan.points().shape[1] == 2


def test_faults_are_kept_until_their_submodule_recovers(sim, chassis, until):
    assert chassis.faults == ()
    until(lambda: chassis.status_code.publishers)
    sim.press_emergency_stop()
    until(lambda: chassis.faults)
    assert "emergency stop" in chassis.faults[0].english
    assert not chassis.readiness()
    with pytest.raises(rosproto.RosTimeout, match="emergency stop"):
        chassis.wait_until_ready(0.2)
    sim.release_emergency_stop()
    assert chassis.wait_until_ready(5.0)
    assert not chassis.faults


# -- writing ---------------------------------------------------------------------------------------------------


def test_the_vendors_footprint_example_in_three_lines(sim, chassis, until):
    corners = [(-0.4, 0.253), (-0.353, 0.3), (0.353, 0.3), (0.4, 0.253), (0.4, -0.253), (0.353, -0.3), (-0.353, -0.3), (-0.4, -0.253)]  # fmt: skip
    chassis.set_footprint(corners, padding=0.1)
    heard = sim.graph.heard
    for which in ("local", "global"):
        topic = f"/move_base/{which}_costmap/set_footprint"
        until(lambda topic=topic: topic in heard)
        assert len(heard[topic].points) == 8
        assert heard[topic].points[0].x == pytest.approx(-0.5)
    chassis.set_footprint(Footprint.circle(0.4))
    with pytest.raises(ValueError, match="3 corners"):
        chassis.set_footprint([(0, 0)])


def test_the_light_strips(sim, chassis, until):
    chassis.light(LedState.TASK_RUNNING, module=3)
    until(lambda: "/rgbled" in sim.graph.heard)
    assert (sim.graph.heard["/rgbled"].normal, sim.graph.heard["/rgbled"].submodule) == (0xA1, 3)
    chassis.light(color=(255, 128, 0), strip="shelf")
    until(lambda: "/rgbled_shelf" in sim.graph.heard)
    assert sim.graph.heard["/rgbled_shelf"].color == 0xFF8000
    chassis.light("red", strip="shelf")
    chassis.light("task-paused", color="blue")
    until(
        lambda: (
            sim.graph.heard["/rgbled_shelf"].color == 0xFF0000 and sim.graph.heard["/rgbled"].color == 0xFF
        )
    )
    assert sim.graph.heard["/rgbled"].normal == 0xA2
    for bad in ({"module": 9}, {"color": 0x1000000}, {"strip": "roof"}):
        with pytest.raises(ValueError, match=r"expected|module"):
            chassis.light(**bad)


def test_the_other_spelling_of_the_shelf_strip_is_used_where_only_it_listens(sim, until):
    for part in [s for s in sim.graph._keep if getattr(s, "topic", "") == "/rgbled_shelf"]:
        part.close()
    node = sim.graph.nodes["/mobile_base_nodelet_manager"]
    heard: list[int] = []
    node.subscriber("/kShelfLedColorPubName", "woosh_msgs/LED", callback=lambda m: heard.append(m.color))
    with Chassis(sim.master_uri) as chassis:
        chassis.light(color=0x00FF00, strip="shelf")
        until(lambda: heard == [0x00FF00])


def test_the_chassis_speaks(sim, chassis, until):
    chassis.say("你好")
    until(lambda: "/voice_synthesis" in sim.graph.heard)
    assert sim.graph.heard["/voice_synthesis"].data == "你好"


def test_localisation_is_lost_and_given_again(sim, chassis, until):
    sim.lose_localization()
    with pytest.raises(GoalFailed):
        chassis.go_to(1.0, 0.0).wait(5.0)
    chassis.set_pose(sim.pose)
    until(lambda: sim.world.located)
    assert chassis.go_to(1.0, 0.0).wait(10.0)
    chassis.start_localization(False)
    assert not sim.world.located
    chassis.start_localization(True)
    until(lambda: sim.world.located)


def test_maps_are_read_saved_and_set(sim, chassis, tmp_path):
    grid = chassis.get_map()
    assert (grid.cells == sim.world.site.grid.cells).all()
    yaml_path, _ = grid.save(tmp_path / "hall.yaml")
    chassis.set_map(GridMap.load(yaml_path), initial_pose=Pose2D(0.0, 0.0))
    assert (chassis.get_map().cells == grid.cells).all()


def test_a_plan_is_made_without_driving(sim, chassis):
    path = chassis.plan(Pose2D(6.0, 0.0))
    assert path[0].distance_to(sim.pose) < 0.2
    assert path[-1].distance_to(Pose2D(6.0, 0.0)) < 0.2
    assert len(path) > 2
    assert chassis.plan(Pose2D(60.0, 0.0)) == []
    with pytest.raises(ValueError, match="tolerance"):
        chassis.plan(Pose2D(1.0, 0.0), tolerance=-1.0)


def test_costmaps_are_switched_and_cleared(sim, chassis):
    chassis.enable_costmaps(False)
    assert not sim.world.costmaps_enabled
    chassis.enable_costmaps(True)
    chassis.clear_costmaps()
    assert sim.world.collisions.seen_obstacles == []


def test_a_refusing_service_is_an_error(sim, chassis, monkeypatch):
    for server in [s for s in sim.graph._keep if getattr(s, "name", "") == "/start_localization"]:
        server.close()
    node = sim.graph.nodes["/woosh_localization"]
    node.service_server(
        "/start_localization", "std_srvs/SetBool", lambda r: {"success": False, "message": "busy"}
    )
    with pytest.raises(ChassisError, match="busy"):
        chassis.start_localization()


def test_the_navigation_mode_reaches_the_chassis(sim, chassis):
    chassis.set_navigation_mode(
        NavigationMode.WAIT_THEN_AVOID, waiting_timeout=5.0, max_speed=0.4, direction=NavDirection.FORWARD
    )
    assert sim.world.navigation.mode is NavigationMode.WAIT_THEN_AVOID
    assert sim.world.navigation.max_speed == pytest.approx(0.4)
    with pytest.raises(ValueError, match="waiting_timeout"):
        chassis.set_navigation_mode(NavigationMode.WAIT_THEN_AVOID)
    chassis.set_navigation_mode(
        NavigationMode.WAIT_THEN_AVOID, waiting_timeout=0.0
    )  # as the vendor's page allows
    assert sim.world.navigation.mode is NavigationMode.PRECISE_AVOIDANCE  # as the definition says


def test_any_action_of_the_chassis_can_be_used(chassis):
    goal = message_type("woosh_msgs/LiftControlGoal")(mode=1, executeMode=1)
    handle = chassis.action("/lift_control", goal)
    assert handle.wait(10.0)
    assert handle.result.result == 1
    with pytest.raises(ValueError, match="not an action"):
        chassis.action("/battery", goal)


def test_the_robot_state_is_waited_for(sim, chassis, until):
    until(lambda: chassis.status.publishers)
    sim.press_emergency_stop()
    assert chassis.wait_until(lambda s: s.robot_state is RobotState.FAULT, 20.0)


def test_md5sums_of_all_rows_are_those_of_the_vendors_package(full):
    facts = Path(__file__).with_name("chassis_md5sums.json")
    known = json.loads(facts.read_text(encoding="utf-8"))
    for row in DEFINED:
        if row.kind == "topic":
            assert rosproto.message_class(row.type)._md5sum == known[row.type], row.type
        elif row.kind == "service":
            assert rosproto.service_class(row.type)._md5sum == known[row.type], row.type
        else:
            assert rosproto.message_class(f"{row.type}ActionGoal")._md5sum == known[f"{row.type}ActionGoal"]


@pytest.mark.parametrize("row", [r for r in interface.actions() if r.source == "seen"], ids=lambda r: r.name)
def test_every_other_action_is_carried_out_and_can_be_cancelled(full, row):
    with Chassis(full.master_uri) as chassis:
        goal = message_type(f"{row.type}Goal")
        full.speed = 50.0
        assert chassis.action(row.name, goal()).wait(10.0)
        full.speed = 0.1  # it lasts
        assert chassis.action(row.name, goal()).cancel().kind is OutcomeKind.CANCELLED
        full.speed = 4.0
