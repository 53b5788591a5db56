"""One robot, one driver: a velocity block beside other programs that can send velocities."""

from __future__ import annotations

import logging
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

import rosproto
from rosproto.errors import RosTimeout
from tests.support import ros
from woosh_pure import Chassis, MotionRefused, SimulatedChassis
from woosh_pure.connection import other_drivers

ROOT = Path(__file__).resolve().parents[2]
TWIST = "geometry_msgs/Twist"

DRIVER = """
import sys
from woosh_pure import Chassis
with Chassis(sys.argv[1], name="first_driver") as chassis:
    with chassis.velocity(bypasses_protection=True) as drive:
        drive.set(0.1, valid_for=5.0)
        print("driving", flush=True)
        sys.stdin.readline()
    print("left", flush=True)
    sys.stdin.readline()
"""


class Program:
    """A Python program in a process of its own."""

    def __init__(self, code: str, uri: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-c", code, uri],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
        )

    def expect(self, line: str) -> None:
        assert self.process.stdout is not None
        assert self.process.stdout.readline() == f"{line}\n"

    def go_on(self) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write("\n")
        self.process.stdin.flush()


@contextmanager
def program(code: str, uri: str) -> Iterator[Program]:
    started = Program(code, uri)
    try:
        yield started
    finally:
        started.process.kill()
        started.process.communicate()


def alone(chassis: Chassis) -> bool:
    return other_drivers.other_drivers(chassis.node) == ()


@pytest.mark.promise("another program can send velocities, too")
def test_the_second_of_two_programs_is_refused_until_the_first_has_left_its_block(sim, chassis, until):
    with program(DRIVER, chassis.node.master_uri) as first:
        first.expect("driving")
        block = chassis.velocity(bypasses_protection=True)
        with pytest.raises(MotionRefused, match=r"first_driver.*can also send velocities.*share=True"):
            block.__enter__()
        with pytest.raises(MotionRefused):
            block.set(0.1)
        assert chassis.stop(timeout=2.0).problems == []  # a stop is never refused
        first.go_on()
        first.expect("left")  # its Chassis stays open: only the block counted
        until(lambda: alone(chassis))
        with chassis.velocity(bypasses_protection=True) as drive:
            assert drive.others == ()
            drive.hold(0.1, seconds=0.1)


def test_a_killed_program_stays_registered_and_refuses_nobody(sim, chassis, until):
    with program(DRIVER, chassis.node.master_uri) as first:
        first.expect("driving")
        first.process.kill()
        first.process.wait(10)
        state = chassis.node.master.get_system_state()
        assert any("first_driver" in node for node in state.publishers["/smooth_cmd_vel"])
        with chassis.velocity(bypasses_protection=True) as drive:
            assert drive.others == ()


def test_who_says_so_shares_and_is_told_of_the_other(sim, chassis, caplog):
    with (
        rosproto.Node("/teleop", master_uri=chassis.node.master_uri) as node,
        node.publisher("/base_cmd_vel", TWIST),  # also the other topic: it is the same base
        chassis.velocity(bypasses_protection=True, share=True) as drive,
    ):
        drive.hold(0.1, seconds=0.1)
        assert drive.others == ("/teleop",)
    assert "/teleop" in caplog.text
    assert "/base_cmd_vel" in caplog.text


def test_the_robots_own_nodes_do_not_refuse(sim, chassis):
    """Which of them publish there is not known: the navigation may, and the remote control does."""
    own = sim.graph.node("/move_base").publisher("/smooth_cmd_vel", TWIST)
    keys = sim.graph.node("/ros_interface").publisher("/key_cmd_vel", TWIST)
    with chassis.velocity(bypasses_protection=True) as drive:
        assert drive.others == ()
    own.close()
    keys.close()


def test_a_newcomer_is_a_warning_and_the_drive_goes_on(sim, chassis, until, caplog, monkeypatch):
    monkeypatch.setattr("woosh_pure.velocity.drive._LOOK_AROUND", 0.05)
    with (
        rosproto.Node("/late", master_uri=chassis.node.master_uri) as node,
        chassis.velocity(bypasses_protection=True) as drive,
    ):
        assert drive.others == ()
        late = node.publisher("/smooth_cmd_vel", TWIST)
        until(lambda: drive.others == ("/late",))
        until(lambda: "/late" in caplog.text)
        until(lambda: sum("/late" in r.message for r in caplog.records) == 1)
        drive.hold(0.1, seconds=0.1)
        late.close()
        until(lambda: drive.others == ())
    assert [r.levelno for r in caplog.records if "/late" in r.message] == [logging.WARNING]


def test_a_robot_that_moves_already_is_told_of_once_where_a_program_takes_it(
    sim, real_time, chassis, until, caplog
):
    """In a program under `woosh run`, too: it is not refused, as the chassis replaces the other's goal."""
    with Chassis(sim.master_uri) as other:
        other.go_to(2.5, 0.0)
        until(lambda: not sim.world.body.velocity.is_standing())
        handle = chassis.move(0.2)
        assert [r.levelno for r in caplog.records if "the robot moves already" in r.message] == [
            logging.WARNING
        ]
        handle.cancel()
        chassis.move(0.2).cancel()
    assert sum("the robot moves already" in record.message for record in caplog.records) == 1


def test_a_robot_that_stands_is_taken_without_a_word(sim, chassis, caplog):
    chassis.move(0.1).wait(timeout=20)
    chassis.move(0.1).cancel()
    assert "moves already" not in caplog.text


@pytest.fixture
def ticking(chassis) -> Iterator[rosproto.Publisher]:
    """A program that sends zero velocities all the time, as an idle joystick does."""
    over = threading.Event()
    with rosproto.Node("/joystick", master_uri=chassis.node.master_uri) as node:
        publisher = node.publisher("/base_cmd_vel", TWIST)

        def tick() -> None:
            while not over.wait(0.02):
                publisher.publish()

        thread = threading.Thread(target=tick)
        thread.start()
        yield publisher
        over.set()
        thread.join()


@pytest.mark.promise("another program can send velocities, too")
@pytest.mark.parametrize("share", [False, True], ids=["came later", "was said to be silent"])
def test_a_program_that_sends_beside_a_drive_ends_it(sim, chassis, request, monkeypatch, share):
    """Its own counters tell: the robot would obey both in turn."""
    monkeypatch.setattr("woosh_pure.velocity.drive._LOOK_AROUND", 0.05)
    monkeypatch.setattr("woosh_pure.velocity.drive._LOOK_AGAIN", 0.1)
    if share:
        request.getfixturevalue("ticking")
    with chassis.velocity(bypasses_protection=True, share=share) as drive:
        if not share:
            request.getfixturevalue("ticking")
        with pytest.raises(MotionRefused, match=r"/joystick .* also sends velocities on /base_cmd_vel"):
            drive.hold(0.1, seconds=20.0)
        assert not drive.active


def test_a_drive_that_checks_nothing_goes_on_beside_it(sim, chassis, ticking, until, caplog, monkeypatch):
    monkeypatch.setattr("woosh_pure.velocity.drive._LOOK_AGAIN", 0.05)
    looks = []
    monkeypatch.setattr(other_drivers.OtherDriver, "has_sent_since", lambda *two: looks.append(two) or True)
    with chassis.velocity(bypasses_protection=True, share=True, check=False) as drive:
        until(lambda: "/joystick" in caplog.text)
        drive.hold(0.1, seconds=0.3)
        assert drive.active
    assert looks == []


def test_an_unknown_node_on_the_robots_computer_is_taken_for_a_part_of_it(sim, chassis, caplog, monkeypatch):
    """Other firmwares have other nodes; from a computer beside the robot its address tells them."""
    monkeypatch.setattr(other_drivers, "_robot_host", lambda node, state: "127.0.0.1")
    with (
        rosproto.Node("/woosh_unheard_of", master_uri=chassis.node.master_uri) as node,
        node.publisher("/smooth_cmd_vel", TWIST),
        chassis.velocity(bypasses_protection=True) as drive,
    ):
        assert drive.others == ("/woosh_unheard_of",)
    assert "runs on the robot itself" in caplog.text


def test_the_robots_computer_is_told_from_ours_by_its_nodes():
    class Master:
        def lookup_node(self, name: str, *, timeout: float) -> str:
            return "http://169.254.128.2:45177/"

    class Node:
        master = Master()
        uri = "http://169.254.128.20:4000/"

    class State:
        nodes = ("/other", "/ros_interface")

    assert other_drivers._robot_host(Node(), State()) == "169.254.128.2"
    Node.uri = "http://169.254.128.2:4000/"  # on the robot itself addresses tell nothing
    assert other_drivers._robot_host(Node(), State()) is None


def test_a_node_that_does_not_answer_refuses_and_the_way_out_is_named(sim, chassis, monkeypatch):
    def silent(client):
        raise RosTimeout("no answer", what="getPublications", seconds=1.0)

    with (
        rosproto.Node("/gone", master_uri=chassis.node.master_uri) as node,
        node.publisher("/smooth_cmd_vel", TWIST),
    ):
        monkeypatch.setattr("rosproto.node.NodeClient.get_publications", silent)
        with pytest.raises(MotionRefused, match=r"/gone.*does not answer.*rosproto node cleanup"):
            chassis.velocity(bypasses_protection=True).__enter__()


def test_a_driver_whose_host_nobody_knows_is_not_taken_for_gone(sim, chassis):
    """That nobody listens at the master's address in its place proves nothing."""
    uri = "http://laptop-of-somebody.invalid:9/"
    with rosproto.MasterClient(chassis.node.master_uri, "/elsewhere") as client:
        client.register_publisher("/smooth_cmd_vel", TWIST, uri)
        try:
            with pytest.raises(MotionRefused, match=r"/elsewhere.*does not answer"):
                chassis.velocity(bypasses_protection=True).__enter__()
        finally:
            client.unregister_publisher("/smooth_cmd_vel", uri)


def test_without_its_master_nobody_knows_who_drives(until):
    with SimulatedChassis(speed=8, full_graph=False) as sim, Chassis(sim.master_uri, timeout=1.0) as chassis:
        block = chassis.velocity(bypasses_protection=True)
        (chassis._bridge or sim)._master.close()
        with pytest.raises(rosproto.RosError):
            block.__enter__()
        with pytest.raises(MotionRefused):
            block.set(0.1)


ROSPY = """
import rospy
from geometry_msgs.msg import Twist
rospy.init_node("rospy_teleop")
publisher = rospy.Publisher("/smooth_cmd_vel", Twist, queue_size=1)
print("up", flush=True)
rospy.spin()
"""


@pytest.mark.interop
def test_a_rospy_publisher_is_another_driver(sim, chassis, until):
    ros.require_ros()
    with ros.start_rospy(ROSPY, chassis.node.master_uri) as process:
        process.wait_for("^up$", 60.0)
        with pytest.raises(MotionRefused, match=r"/rospy_teleop"):
            chassis.velocity(bypasses_protection=True).__enter__()
        with chassis.velocity(bypasses_protection=True, share=True) as drive:
            assert drive.others == ("/rospy_teleop",)
    until(lambda: alone(chassis))
    with chassis.velocity(bypasses_protection=True) as drive:
        drive.hold(0.1, seconds=0.1)
