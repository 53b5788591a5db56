"""What is drawn of a chassis: its state over it, faults in red, marks with names; and what is gone is taken away."""

from __future__ import annotations

import json
import threading
from pathlib import Path
from typing import Any

import pytest

from msgdefs.visualization_msgs.msg import Marker, MarkerArray
from rosproto.codec import decode, encode
from rosproto.time import Time
from woosh_pure import Chassis, SimulatedChassis
from woosh_pure.enums import RobotState
from woosh_pure.faults import decode_status_code
from woosh_pure.foxglove import ChassisTopics, Overlay, OverlayState, chassis_layout, write_layout
from woosh_pure.foxglove.overlay import GREEN, GREY, RED
from woosh_pure.geometry import Pose2D
from woosh_pure.interface.table import driving_patterns, row
from woosh_pure.maps.marks import UserMark
from woosh_pure.values.convert import to_value

HERE = Pose2D(1.0, 2.0, 0.5)
NOW = Time(100, 5)
FAULT, UNKNOWN = decode_status_code(110201000013), decode_status_code(140201000103)
MARKS = (UserMark("A1", Pose2D(3.0, 1.0, 1.57)), UserMark("nowhere"), UserMark("充电", Pose2D(0.0, 0.0, 0.0)))


def status(state: RobotState, to: str = "") -> Any:
    from msgdefs.woosh_msgs.msg import RobotStatus

    return to_value("woosh_msgs/RobotStatus", RobotStatus(robot_state=int(state), dest=to))


def drawn(message: Any) -> dict[tuple[str, int], Any]:
    again = decode(MarkerArray, encode(message))
    return {(one.ns, one.id): one for one in again.markers if one.action == Marker.ADD}


def texts(message: Any) -> list[str]:
    return [one.text for one in drawn(message).values() if one.type == Marker.TEXT_VIEW_FACING]


def colour(one: Any) -> tuple[float, ...]:
    return tuple(round(float(value), 2) for value in (one.color.r, one.color.g, one.color.b))


def test_the_state_stands_over_the_robot() -> None:
    """With where it goes; green while all is well, grey while nothing is known."""
    well = Overlay().markers(OverlayState(HERE, status(RobotState.IN_TASK, "A1")), NOW)
    assert any("to A1" in text for text in texts(well))
    assert colour(drawn(well)["robot", 0]) == GREEN
    assert all(one.header.frame_id == "map" and one.header.stamp == NOW for one in well.markers)
    unknown = Overlay().markers(OverlayState(HERE), NOW)
    assert any("not known" in text for text in texts(unknown))
    assert colour(drawn(unknown)["robot", 0]) == GREY
    old = Overlay().markers(OverlayState(HERE, old=12.3), NOW)
    assert any("12 s old" in text for text in texts(old))


def test_faults_are_read_in_red() -> None:
    """Each one a line with its words and its code, in the language that was asked for."""
    state = OverlayState(HERE, status(RobotState.FAULT), faults=(FAULT,))
    english, chinese = Overlay().markers(state, NOW), Overlay("zh").markers(state, NOW)
    assert f"{FAULT.english} ({FAULT.code:012d})" in texts(english)
    assert f"{FAULT.chinese} ({FAULT.code:012d})" in texts(chinese)
    assert colour(drawn(english)["fault", 0]) == RED
    assert colour(drawn(english)["robot", 0]) == RED
    nameless = Overlay().markers(OverlayState(HERE, faults=(UNKNOWN,)), NOW)
    assert texts(nameless)[-1].count(f"{UNKNOWN.code}") == 1


def test_marks_are_where_they_are() -> None:
    """Those with a pose: an arrow and the name."""
    made = drawn(Overlay().markers(OverlayState(marks=MARKS), NOW))
    assert sorted(one.text for one in made.values() if one.text) == ["A1", "充电"]
    assert (made["mark", 0].pose.position.x, made["mark", 0].pose.position.y) == (3.0, 1.0)
    assert len(made) == 4


def test_what_is_gone_is_taken_away() -> None:
    """By its name, once."""
    overlay = Overlay()
    overlay.markers(OverlayState(HERE, faults=(FAULT,), marks=MARKS), NOW)
    second = overlay.markers(OverlayState(HERE), NOW)
    gone = {(one.ns, one.id) for one in second.markers if one.action == Marker.DELETE}
    assert gone == {("fault", 0), ("mark", 0), ("mark", 1), ("mark", 2), ("mark", 3)}
    assert not any(one.action == Marker.DELETE for one in overlay.markers(OverlayState(HERE), NOW).markers)


def test_a_layout_of_the_table(tmp_path: Path) -> None:
    """Every panel that is placed is described, and every topic is one of the chassis or made here."""
    path = write_layout(tmp_path / "woosh.json")
    made = json.loads(path.read_text("utf-8"))
    assert made == chassis_layout()
    assert list(tmp_path.iterdir()) == [path]

    def places(node: Any) -> list[str]:
        return [node] if isinstance(node, str) else places(node["first"]) + places(node["second"])

    assert sorted(places(made["layout"])) == sorted(made["configById"])
    shown = {
        *made["configById"]["3D!woosh"]["topics"],
        made["configById"]["Image!camera"]["imageMode"]["imageTopic"],
    }
    shown -= {"/woosh/overlay", "/woosh/map"}
    for topic in shown:
        assert row(topic).flow == "read"
    paths = [made["configById"]["Gauge!battery"]["path"]]
    paths += [
        line["value"]
        for name in ("Plot!velocity", "Plot!battery")
        for line in made["configById"][name]["paths"]
    ]
    from rosproto import message_class

    for path_ in paths:
        topic, _, fields = path_.partition(".")
        value: Any = message_class(row(topic).type)()
        for field in fields.split("."):
            value = getattr(value, field)
        assert isinstance(value, (int, float))


def test_driving_is_what_moves_the_robot() -> None:
    """Velocities and the actions that move it, by the table; nothing else."""
    patterns = driving_patterns()
    assert {
        "topic:/base_cmd_vel",
        "topic:/smooth_cmd_vel",
        "action:/move_base",
        "action:/cmd_vel_control",
    } <= set(patterns)
    assert "topic:/rgbled" not in patterns
    assert not any(pattern.startswith("service:") for pattern in patterns)


class StopExecutor:
    """A receiver that keeps what comes."""

    def __init__(self) -> None:
        self.came = threading.Event()
        self.samples: list[Any] = []

    def offer(self, sample: Any) -> None:
        self.samples.append(sample)
        self.came.set()


@pytest.mark.slow
def test_topics_of_the_simulated_chassis() -> None:
    """Drawn while somebody looks: nothing is asked of the chassis before, and no thread stays after."""
    with SimulatedChassis() as sim, Chassis(sim.master_uri) as chassis, ChassisTopics(chassis) as topics:

        def followed() -> list[str]:
            state = chassis.node.master.get_system_state().subscribers
            return [topic for topic, nodes in state.items() if chassis.node.name in nodes]

        before = followed()
        assert row("/movebase_pose2d").name not in before
        overlay, grid = StopExecutor(), StopExecutor()
        taps = [topics.overlay.open(overlay), topics.map.open(grid)]
        assert overlay.came.wait(20)
        assert grid.came.wait(20)
        assert (
            len(grid.samples[0].message.data)
            == grid.samples[0].message.info.width * grid.samples[0].message.info.height
        )
        chassis.pose.wait(10)
        overlay.came.clear()
        assert overlay.came.wait(10)
        overlay.came.clear()
        assert overlay.came.wait(10)
        assert ("robot", 0) in drawn(overlay.samples[-1].message)
        for tap in taps:
            tap.close()
        topics.close()
        assert not [
            t for t in threading.enumerate() if t.name.startswith("woosh:overlay") or t.name == "woosh:map"
        ]
