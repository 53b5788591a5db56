"""A velocity block while the network falls silent: the drive is over at once, and nothing of it moves the robot later."""

from __future__ import annotations

import pytest

from tests.scenarios.network.conftest import Network, soon, wait

pytestmark = pytest.mark.slow

DRIVE = """
from woosh_pure import Chassis
chassis = Chassis("10.77.0.1")
driving, ended, said = __import__("threading").Event(), [], []
def drive():
    try:
        with chassis.velocity(bypasses_protection=True) as block:
            block.set(0.2, valid_for=5.0)
            chassis.measured_velocity.wait_for(lambda v: v.vx > 0.1, 10.0)
            driving.set()
            block.hold(0.2, seconds=60.0)
    except Exception as error:
        said.append(type(error).__name__)
    ended.append(time.monotonic())
__import__("threading").Thread(target=drive, daemon=True).start()
"""
ROBOT_SIDE = """
from woosh_pure import SimulatedChassis
from woosh_pure.sim import Settings
sim = SimulatedChassis(host="10.77.0.1", port=11311, full_graph=False).start()
speeds = []
def watch():
    while True:
        speeds.append((time.monotonic(), sim.world.body.velocity.vx))
        time.sleep(0.01)
"""


@pytest.mark.parametrize(
    ("ways", "seconds"),
    [(("there", "back"), 2.0), (("there", "back"), 7.0), (("there",), 3.0), (("back",), 3.0)],
    ids=["links live", "links are given up", "only the robot's packets are lost", "only ours are lost"],
)
def test_silence_in_a_velocity_block(ways: tuple[str, ...], seconds: float, network: Network) -> None:
    """The program is told within a second; the robot stands soon after the network is back, and stays where it is.

    Where only one direction is lost, TCP has kept the drive's last velocities: they come together with its zero.
    """
    robot, laptop, air = network
    robot.python.do(ROBOT_SIDE, 60)
    robot.python.do("__import__('threading').Thread(target=watch, daemon=True).start()")
    laptop.python.do(DRIVE, 60)
    laptop.python.eventually("driving.is_set()")
    for way in ways:
        getattr(air, way).open = False
    gone = wait(0.0)
    told = laptop.python.eventually("ended")
    assert told - gone < soon(1.0)
    assert laptop.python.ask("said") == ["ConnectionLost"]
    back = wait(max(0.0, gone + seconds - told))
    air.clear()
    standing = robot.python.eventually("abs(sim.world.body.velocity.vx) < 0.001")
    assert standing - back < soon(2.0)
    wait(1.5)
    fastest = robot.python.ask(f"max(abs(vx) for at, vx in speeds if at > {standing!r} + 0.1)")
    assert fastest < 0.001


def test_a_program_killed_in_silence(network: Network) -> None:
    """Its last velocities are not zero: delivered late, they would set a robot off that has stopped meanwhile."""
    robot, laptop, air = network
    robot.python.do(ROBOT_SIDE.replace("full_graph", "settings=Settings(on_silence='stop'), full_graph"), 60)
    robot.python.do("__import__('threading').Thread(target=watch, daemon=True).start()")
    program = laptop.another()
    program.do(DRIVE, 60)
    program.eventually("driving.is_set()")
    air.silence()
    wait(0.25)  # the drive has not noticed yet
    program.kill()
    standing = robot.python.eventually("abs(sim.world.body.velocity.vx) < 0.001")
    air.clear()
    wait(2.5)
    fastest = robot.python.ask(f"max(abs(vx) for at, vx in speeds if at > {standing!r} + 0.1)")
    assert fastest < 0.001


def test_a_move_that_is_sent_into_silence(network: Network) -> None:
    """Only our packets are lost: the program hears that the connection is lost, and the robot does not move later."""
    robot, laptop, air = network
    robot.python.do(ROBOT_SIDE, 60)
    robot.python.do("x = lambda: sim.world.body.pose.x\nstart = x()")
    laptop.python.do(
        "from woosh_pure import Chassis\nchassis = Chassis('10.77.0.1')\nchassis.wait_until_ready(20)\nchassis.move(0.05).wait()",
        60,
    )
    robot.python.do("start = x()")
    air.back.open = False
    laptop.python.do("outcome = chassis.move(0.5).wait(raises=False)", 40)
    assert laptop.python.ask("outcome.kind.name") == "CONNECTION_LOST"
    air.back.open = True
    laptop.python.do("chassis.wait_until_ready(20)", 40)
    wait(4.0)
    assert robot.python.ask("abs(x() - start)") < 0.1
    assert robot.python.ask("abs(sim.world.body.velocity.vx)") < 0.001
