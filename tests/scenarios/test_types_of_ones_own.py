"""Folders of the user's own with types of the chassis's names: by name they are the user's, and the API stays right."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

import rosproto
from rosproto.errors import LocalProtocolError
from rosproto.msg import bundled
from woosh_pure import Chassis, Pose2D, SimulatedChassis
from woosh_pure.cli import main
from woosh_pure.interface import ROWS
from woosh_pure.values.messages import message_type

ALSO = ("actionlib_msgs/GoalID", "actionlib_msgs/GoalStatusArray", "rosgraph_msgs/Log", "tf2_msgs/TFMessage")


@pytest.fixture
def shadows(tmp_path: Path) -> Path:
    """A type of the user's, with other fields, of every name that the interface has."""
    texts = {"topic": "string mine\n", "service": "string mine\n---\nstring mine\n"}
    texts["action"] = "string mine\n---\nstring mine\n---\nstring mine\n"
    kinds = {"topic": "msg", "service": "srv", "action": "action"}
    for kind, name in [*((row.kind, row.type) for row in ROWS), *(("topic", name) for name in ALSO)]:
        package, _, base = name.partition("/")
        place = tmp_path / "own" / package / kinds[kind]
        place.mkdir(parents=True, exist_ok=True)
        (place / f"{base}.{kinds[kind]}").write_text(texts[kind])
    return tmp_path / "own"


def test_the_api_keeps_its_definitions(sim: SimulatedChassis, shadows: Path) -> None:
    """Feeds, services, actions, velocity, stop and peripherals, whatever the user's folders call by these names."""
    with Chassis(sim.master_uri, msg_path=[shadows]) as chassis:
        assert chassis.battery.wait(10.0).percent is not None
        chassis.status.connect()
        chassis.readiness()
        chassis.set_pose(chassis.pose.wait(10.0))
        assert chassis.plan(Pose2D(1.0, 0.5, 0.0))
        chassis.light(color=(255, 0, 0))
        assert chassis.go_to_mark("A1").wait(60.0).arrived
        assert chassis.status.wait(10.0, new=False).task_id is not None
        assert chassis.go_to(1.0, 0.5).wait(60.0).arrived
        with chassis.velocity(bypasses_protection=True) as drive:
            drive.hold(0.1, seconds=0.2)
        report = chassis.stop(timeout=5.0)
        assert report.problems == []


def test_the_doctor_and_a_task_of_the_command(
    sim: SimulatedChassis, shadows: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """--msg-path with such a folder changes nothing of what they find."""
    words = ["--chassis", sim.master_uri, "--msg-path", str(shadows)]
    assert main([*words, "doctor"]) == 0, capsys.readouterr().out
    assert main([*words, "task", "pause", "--id", "1"]) in (0, 3)
    assert "mine" not in capsys.readouterr().err


@pytest.mark.parametrize("first", ["program", "feed"])
def test_a_newer_definition_of_the_users_own(sim: SimulatedChassis, tmp_path: Path, first: str) -> None:
    """`chassis.node` takes it by its name, and the feed beside it reads every field that it knows.

    A node has one definition for a topic: who comes to one that a feed reads already is told so.
    """
    text = bundled().message("woosh_msgs/Battery").text
    place = tmp_path / "woosh_msgs" / "msg"
    place.mkdir(parents=True)
    shorter = re.sub(r"(?m)^(?!.*batteryPercentage).*\n?", "", text)
    (place / "Battery.msg").write_text(f"{shorter}\nuint16 cells\n")
    with Chassis(sim.master_uri, msg_path=[tmp_path]) as chassis:
        ours: Any = message_type("woosh_msgs/Battery")
        if first == "feed":
            chassis.battery.wait(10.0)
            with pytest.raises(LocalProtocolError, match="is subscribed in this node as woosh_msgs/Battery"):
                chassis.node.subscriber("/battery", "woosh_msgs/Battery")
            return
        with chassis.node.subscriber("/battery", "woosh_msgs/Battery") as mine:
            heard = mine.next(timeout=10.0)
            assert heard.__slots__ == ["batteryPercentage", "cells"]
            assert chassis.battery.wait(10.0).percent == pytest.approx(heard.batteryPercentage)
            (reading,) = [chassis.battery.reading]
            assert reading is not None
            assert type(reading.message) is ours


def test_a_robot_of_another_revision_beside_the_users_own(tmp_path: Path) -> None:
    """Three definitions of one type: the robot's, the user's, and the API's; each reads the robot's bytes."""
    place = tmp_path / "woosh_msgs" / "msg"
    place.mkdir(parents=True)
    (place / "Battery.msg").write_text("uint8 batteryPercentage\nuint16 cells\n")
    robots = rosproto.define(
        "woosh_msgs/Battery", "uint16 cells\n" + bundled().full_text("woosh_msgs/Battery")
    )
    with (
        rosproto.Master() as master,
        rosproto.Node("/robot", master_uri=master.uri, rosout=False, intraprocess=False) as robot,
        robot.publisher("/battery", robots, latch=True) as publisher,
        Chassis(master.uri, msg_path=[tmp_path], learned=False) as chassis,
        chassis.node.subscriber("/battery", "woosh_msgs/Battery") as mine,
    ):
        publisher.publish(batteryPercentage=77, cells=8)
        heard = mine.next(timeout=10.0)
        assert (heard.batteryPercentage, heard.cells) == (77, 8)
        feed = chassis.battery
        feed.open()
        publisher.publish(batteryPercentage=78, cells=8)
        assert feed.wait(10.0, new=False).percent in (77, 78)
