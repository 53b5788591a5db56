"""Whoever drives is killed with kill -9, stopped or hung: the watchdog beside it stops the robot.

WATCHDOG_TRIALS=50 in the environment repeats the trials of chance so often.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from tests.support.waiting import until

if os.name != "posix":
    pytest.skip("needs SIGKILL and SIGSTOP", allow_module_level=True)

from rosproto.errors import RosError
from rosproto.node import Node, NodeClient
from rosproto.watchdog import is_watchdog_name
from tests.support.driving_commands import COMMANDS, children, driving, is_alive, moving
from tests.support.extras import needs
from tests.support.load import crowd
from woosh_pure import Chassis, MotionRefused, SimulatedChassis
from woosh_pure.connection.other_drivers import other_drivers

TRIALS = int(os.environ.get("WATCHDOG_TRIALS", "1"))
STANDS = 3.0
"""Seconds in which the robot has stopped, its own ramp and an overloaded computer included; the benchmark measures."""
NEEDS = {"woosh web": "uvicorn", "woosh vda5050": "paho", "rosproto bridge": "websockets"}
NEEDS |= {"rosproto foxglove": "websockets", "woosh foxglove": "websockets", "woosh robot-api": "websockets"}


@pytest.fixture(autouse=True)
def in_real_time(real_time):
    """What is seen while it moves."""


@pytest.fixture(params=sorted(COMMANDS))
def command(request) -> str:
    if request.param in NEEDS:
        pytest.importorskip(NEEDS[request.param])
    return request.param


def stands(sim: SimulatedChassis, seconds: float = STANDS) -> bool:
    end = time.monotonic() + seconds
    while moving(sim):
        if time.monotonic() > end:
            return False
        time.sleep(0.01)
    time.sleep(0.3)
    return not moving(sim)  # and it does not go on


def gone(pid: int) -> bool:
    until(lambda: not is_alive(pid), what=f"the end of {pid}")
    return True


@pytest.mark.promise("kill -9 (or a crash, or no memory left) of `woosh web`", "kill -9 of `rosproto bridge`")
def test_after_kill_9_the_robot_stands_and_nobody_is_left(command: str, sim, tmp_path: Path) -> None:
    with driving(command, sim, tmp_path) as pid:
        (watchdog,) = children(pid)
        os.kill(pid, signal.SIGKILL)
        assert stands(sim)
        assert gone(watchdog)


@pytest.mark.promise("**the program and its watchdog are killed at once")
def test_without_a_watchdog_it_drives_on(sim, tmp_path: Path) -> None:
    needs("bridge")
    with driving("rosproto bridge", sim, tmp_path, "--no-watchdog") as pid:
        assert children(pid) == []
        os.kill(pid, signal.SIGKILL)
        assert not stands(sim)
    Chassis(sim.master_uri).stop()


@pytest.mark.promise("one of these is stopped")
@pytest.mark.parametrize("command", ["woosh web", "Chassis, goal", "Chassis, task"])
def test_a_program_that_is_stopped_or_hangs_is_taken_for_gone(command: str, sim, tmp_path: Path) -> None:
    if command in NEEDS:
        pytest.importorskip(NEEDS[command])
    with driving(command, sim, tmp_path) as pid:
        (watchdog,) = children(pid)
        os.kill(pid, signal.SIGSTOP)
        assert stands(sim)
        assert is_alive(watchdog)
        os.kill(pid, signal.SIGCONT)
        assert stands(sim, 1.0), "nothing resumes"


@pytest.mark.parametrize("name", ["goto A1", "drive +x"])
def test_what_is_said_of_a_pause_agrees(name: str, sim: SimulatedChassis) -> None:
    """The watchdog stopped the robot: then neither has somebody else done it, nor did the robot drive on."""
    body = {
        "goto A1": "print(chassis.go_to_mark('A1').wait(timeout=60, raises=False), flush=True)",
        "drive +x": "\n".join((
            "with chassis.velocity(bypasses_protection=True, feedback_timeout=None) as drive:",
            "            drive.hold(0.1, seconds=999)",
        )),
    }[name]  # fmt: skip
    code = (
        "import logging, sys\nfrom woosh_pure import Chassis, MotionRefused\nlogging.basicConfig()\n"
        "with Chassis(sys.argv[1], watchdog=True) as chassis:\n    try:\n        "
        f"{body}\n    except MotionRefused as error:\n        print(error, flush=True)\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code, sim.master_uri],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    try:
        until(lambda: moving(sim), what="a robot that moves", timeout=20.0)
        os.kill(process.pid, signal.SIGSTOP)
        assert stands(sim)
        time.sleep(1.2)  # a pause that the program itself notices
        os.kill(process.pid, signal.SIGCONT)
        said, _ = process.communicate(timeout=30)
    finally:
        process.kill()
        process.communicate()
    notice = "when its watchdog stopped the robot"
    warning, *rest = [line for line in said.splitlines() if line]
    assert notice in warning
    # The notice and the end of the motion arrive in either order; only the first gives the reason.
    own = {
        "goto A1": "or our watchdog while this program did not run",
        "drive +x": "without a watchdog the robot went on with the last velocity",
    }[name]
    assert notice in rest[-1] or own in rest[-1]


def is_ready(node: Node) -> bool:
    """Whether the watchdog of the velocity topic is connected with the robot, by its own account."""
    for name in node.master.get_system_state().publishers["/smooth_cmd_vel"]:
        if name.endswith("_rosproto_watchdog"):
            try:
                with NodeClient(node.master.lookup_node(name), node.name) as slave:
                    ((_, _, links),) = slave.get_bus_stats()[0]
                    return bool(links)
            except (RosError, ValueError):
                return False  # the one before
    return False


@pytest.mark.promise("the watchdog itself is killed")
def test_a_killed_watchdog_is_replaced_and_the_next_one_does_the_same(sim, tmp_path: Path) -> None:
    with driving("Chassis, velocity", sim, tmp_path) as pid:
        (first,) = children(pid)
        os.kill(first, signal.SIGKILL)
        until(lambda: children(pid) not in ([], [first]), what="another watchdog")
        (second,) = children(pid)
        with Node("/looks", master_uri=sim.master_uri, rosout=False) as node:
            until(lambda: is_ready(node), what="a watchdog that is ready")
        assert moving(sim)
        os.kill(pid, signal.SIGKILL)
        assert stands(sim)
        assert gone(second)


def watchdog_nodes(node: Node) -> set[str]:
    state = node.master.get_system_state()
    return {
        name
        for names in (*state.publishers.values(), *state.subscribers.values())
        for name in names
        if is_watchdog_name(name)
    }


@pytest.mark.slow
@pytest.mark.promise("another node takes the name of the watchdog")
@pytest.mark.parametrize("trial", range(TRIALS))
@pytest.mark.parametrize("command", ["Chassis, velocity", "Chassis, goal"])
def test_a_watchdog_whose_name_was_taken_takes_another_one(
    command: str, trial: int, sim: SimulatedChassis, tmp_path: Path
) -> None:
    with (
        driving(command, sim, tmp_path) as pid,
        Node("/looks", master_uri=sim.master_uri, rosout=False) as node,
    ):
        until(lambda: watchdog_nodes(node))
        (first,) = watchdog_nodes(node)
        with Node(first, master_uri=sim.master_uri, rosout=False) as taker:
            taker.publisher("/anything", "std_msgs/String")
            until(lambda: watchdog_nodes(node) - {first}, what="another name")
            (second,) = watchdog_nodes(node) - {first}
            topic = {"Chassis, velocity": "/smooth_cmd_vel", "Chassis, goal": "/move_base/cancel"}[command]

            def connected() -> bool:
                with NodeClient(node.master.lookup_node(second), node.name) as slave:
                    return any(link.topic == topic and link.connected for link in slave.get_bus_info())

            until(connected, what="a link to the robot")
            os.kill(pid, signal.SIGKILL)
            until(lambda: sim.world.motion is None, STANDS, "no goal")
            assert stands(sim, 2 * STANDS)


@pytest.mark.slow
@pytest.mark.promise("are sent at once, and three times more within a tenth of a second")
def test_killed_after_its_first_zero_it_has_done_its_work(sim, tmp_path: Path) -> None:
    """How soon after its program it may be killed depends on when the computer lets it run."""
    zero = threading.Event()

    def receive(twist: Any) -> None:
        if not twist.linear.x and not twist.angular.z:
            zero.set()

    with (
        driving("Chassis, velocity", sim, tmp_path) as pid,
        Node("/witness", master_uri=sim.master_uri, rosout=False) as node,
        node.subscriber("/smooth_cmd_vel", "geometry_msgs/Twist", callback=receive) as velocities,
    ):
        (watchdog,) = children(pid)
        until(lambda: velocities.latest is not None and velocities.connections >= 2, what="both links")
        zero.clear()
        os.kill(pid, signal.SIGKILL)
        assert zero.wait(10.0)
        os.kill(watchdog, signal.SIGKILL)
        assert stands(sim)


def has_ended(pid: int) -> bool:
    """Whether a child has ended, all its threads included."""
    return os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None


@pytest.mark.slow
@pytest.mark.timeout(60 + 20 * TRIALS)
@pytest.mark.promise(
    "It sees the end of its program when the system has ended the last of the program's threads"
)
@pytest.mark.parametrize("command", ["Chassis, velocity", "Chassis, goal", "Chassis, task"])
def test_a_watchdog_that_is_killed_a_tenth_of_a_second_after_its_program_has_stopped_the_robot(
    command: str, tmp_path: Path
) -> None:
    """A tenth of a second on a quiet computer, longer on a busy one, where a watchdog may not run in that time.

    The system closes the pipe with the program's last thread, which may take it that long, too. So only programs
    that have ended in half of the time count; the others are printed.
    """
    half = 0.05 * crowd()
    went_on, still_ending = [], []
    for trial in range(TRIALS):
        with SimulatedChassis(full_graph=False) as sim, driving(command, sim, tmp_path) as pid:
            (watchdog,) = children(pid)
            os.kill(pid, signal.SIGKILL)
            time.sleep(half)
            ended = has_ended(pid)
            time.sleep(half)
            os.kill(watchdog, signal.SIGKILL)
            if not stands(sim):
                (went_on if ended else still_ending).append(trial)
    print(f"{command}: went on in {len(went_on)} of {TRIALS}, and while the program ended: {still_ending}")
    assert not went_on


@pytest.mark.promise("our programs do not count such a node as another driver")
def test_a_watchdog_is_nobody_who_drives(sim) -> None:
    """Not for its own program, nor for others: they look for publishers of the velocity topics."""
    with (
        Chassis(sim.master_uri, watchdog=True) as chassis,
        Node("/other", master_uri=sim.master_uri, rosout=False) as other,
        chassis.velocity(bypasses_protection=True) as drive,
    ):
        drive.hold(0.0, seconds=3.0)  # nothing moves: a machine that is busy for a second ends nothing
        publishers = other.master.get_system_state().publishers["/smooth_cmd_vel"]
        assert any(name.endswith("_rosproto_watchdog") for name in publishers)
        assert drive.others == ()
        assert [driver.node for driver in other_drivers(other)] == [chassis.node.name]


def test_it_is_on_the_velocity_topic_only_while_somebody_drives(sim, until) -> None:
    def there() -> bool:
        publishers = chassis.node.master.get_system_state().publishers.get("/smooth_cmd_vel", [])
        return any(name.endswith("_rosproto_watchdog") for name in publishers)

    with Chassis(sim.master_uri, watchdog=True) as chassis:
        assert not there()
        # On a machine that does not run this program for 0.8 s, its watchdog ends the drive, as it should.
        with suppress(MotionRefused), chassis.velocity(bypasses_protection=True) as drive:
            drive.set(0.0)
            assert there()
        until(lambda: not there())


@pytest.mark.promise("kill -9 (or a crash, or no memory left) of `woosh web`")
def test_goals_that_are_left_running_are_left_by_the_watchdog_too(sim, until) -> None:
    chassis = Chassis(sim.master_uri, watchdog=True, leave_running=True)
    with chassis:
        chassis.go_to(2.0, 0.0)
        until(lambda: moving(sim))
        publishers = chassis.node.master.get_system_state().publishers["/move_base/cancel"]
        assert not any(name.endswith("_rosproto_watchdog") for name in publishers)
    chassis = Chassis(sim.master_uri)
    chassis.stop(everything=True)
    chassis.close()
