"""What was asked to end while the network was away is ended when the robot can be reached again."""

from __future__ import annotations

import pytest

from tests.scenarios.network.conftest import Network, soon, wait
from tests.scenarios.network.test_driving import ROBOT_SIDE

pytestmark = pytest.mark.slow
AWAY = 12.0  # seconds
BEGIN = """
from woosh_pure import Chassis
chassis = Chassis("10.77.0.1")
chassis.wait_until_ready(20)
"""
MOVES = {
    "goal": "handle = chassis.go_to(0.0, 0.0, 3.1, timeout=None)",
    "steps": "handle = chassis.rotate(40.0, several_turns=True)",
    "task": "handle = chassis.go_to_mark('B1', timeout=None)",
}
ASKS = {
    "stop": "report = chassis.stop(timeout=2.0)",
    "cancel": "try: handle.cancel(2.0)\nexcept Exception as error: pass",
    "time up": "handle.wait(0.5, raises=False)",
}
VELOCITY = ["/smooth_cmd_vel", "/base_cmd_vel"]
DRIVE = """
block = chassis.velocity(bypasses_protection=True, feedback_timeout={feedback})
drive = block.__enter__()
drive.set(0.0, 0.3, valid_for=5.0)
"""
STANDS = (
    "sim.world.motion is None and not sim.world.tasks.busy and sim.world.body.velocity.is_standing(0.0, 0.0)"
)


def begin(network: Network, what: str) -> None:
    network.robot.python.do(ROBOT_SIDE, 60)
    network.laptop.python.do(BEGIN, 60)
    network.laptop.python.do(what, 60)
    network.robot.python.eventually("not sim.world.body.velocity.is_standing(0.005, 0.005)")


@pytest.mark.promise("the network is away when a motion is asked to end")
@pytest.mark.parametrize("ask", ASKS)
@pytest.mark.parametrize("move", MOVES)
def test_a_goal_that_was_asked_to_end_in_silence(network: Network, move: str, ask: str) -> None:
    """A robot that needs longer than the silence: it turns many times, or drives slowly."""
    robot, laptop, air = network
    begin(network, MOVES[move])
    robot.python.do("sim.speed = 0.1")  # what it does in between is not the point, and must not end by itself
    air.silence()
    gone = wait(0.5)
    laptop.python.do(ASKS[ask], 60)
    back = wait(max(0.0, gone + AWAY - wait(0.0)))
    assert not robot.python.ask(STANDS)
    robot.python.do("sim.speed = 1.0")
    air.clear()
    assert robot.python.eventually(STANDS, 30) - back < soon(3.0)
    laptop.python.eventually("not chassis.under_way", 30)


@pytest.mark.promise("the network is away when a motion is asked to end")
def test_a_task_whose_end_was_told_to_a_dead_connection(network: Network) -> None:
    """Its status is sent on change only. The robot says no to the cancels: it has no such task any more."""
    robot, laptop, air = network
    begin(network, MOVES["task"])
    air.silence()
    gone = wait(0.5)
    laptop.python.do(ASKS["stop"], 60)
    robot.python.do("with sim.lock: sim.world.tasks.fail('blocked')")
    wait(max(0.0, gone + AWAY - wait(0.0)))
    air.clear()
    laptop.python.eventually("not chassis.under_way", 30)


@pytest.mark.promise("the network is away when a motion is asked to end")
@pytest.mark.parametrize("end", ["chassis.stop(timeout=2.0)", "block.__exit__(None, None, None)"])
@pytest.mark.parametrize("feedback", [1.0, None])
def test_a_drive_that_was_ended_in_silence(network: Network, feedback: float | None, end: str) -> None:
    """Ended by us before it was noticed: its zeros are in a dead connection."""
    robot, laptop, air = network
    begin(network, DRIVE.format(feedback=feedback))
    air.silence()
    gone = wait(0.1)
    laptop.python.do(f"try: {end}\nexcept Exception as error: print(error)", 60)
    back = wait(max(0.0, gone + AWAY - wait(0.0)))
    assert not robot.python.ask(STANDS)
    air.clear()
    assert robot.python.eventually(STANDS, 30) - back < soon(3.0)
    laptop.python.eventually("not chassis.under_way", 30)
    # Nobody takes us for a driver any more.
    robot.python.do(
        "from rosproto.node import MasterClient\nmaster = MasterClient('http://10.77.0.1:11311/', '/test')"
    )
    drivers = f"[p for t in {VELOCITY!r} for p in master.get_system_state().publishers.get(t, ())]"
    robot.python.eventually(f"not any('woosh_pure' in p for p in {drivers})", 30)
