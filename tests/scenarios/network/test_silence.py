"""A network that swallows packets without a word: noticed, nothing old delivered afterwards, back within a second."""

from __future__ import annotations

import pytest

from tests.scenarios.network.conftest import (
    FRESH,
    LINK_SECONDS,
    MASTER,
    Network,
    heard_again,
    soon,
    start_laptop,
    wait,
)
from tests.support.hosts import ROBOT
from tests.support.load import crowd
from tests.support.ros import PYTHON, environment, require_ros

pytestmark = pytest.mark.slow

SILENT = 7.0  # seconds; links are given up after five

TALKER = """
import rospy, time
from std_msgs.msg import String
rospy.init_node("talker")
talk = rospy.Publisher("/t", String, queue_size=10)
rospy.Subscriber("/back", String, lambda m: print("heard", m.data.split()[1], repr(time.monotonic()), flush=True))
rate, n = rospy.Rate(20), 0
while not rospy.is_shutdown():
    talk.publish("%d %r" % (n, time.monotonic())); n += 1
    rate.sleep()
"""


def test_both_ways(connected: Network) -> None:
    """Noticed by keep-alive; heard again within a second, both ways; what was sent meanwhile never comes."""
    robot, laptop, air = connected
    air.silence()
    gone = wait(SILENT)
    laptop.python.eventually("'DISCONNECTED' in [event.kind.name for event in node._parts.context.events]")
    laptop.python.eventually("node.stats().master_lost")
    gone = wait(0.0)
    air.clear()
    for host in (laptop, robot):
        assert heard_again(host.python, gone) < soon(LINK_SECONDS)
        assert host.python.ask(f"heard.latest_after({gone!r})") < FRESH * crowd()
    laptop.python.eventually("not node.stats().master_lost")
    assert laptop.python.ask("heard.subscriber.stats()[0].reconnects") == 1
    assert laptop.python.ask("tick.longest") < 1.0  # publish() never waited
    wait(1.0)  # and nothing comes late later
    assert laptop.python.ask(f"heard.latest_after({gone!r})") < FRESH * crowd()


def test_short_ones_cost_no_connection(connected: Network) -> None:
    """Two seconds: left to TCP, no message is lost and none is reconnected for."""
    _, laptop, air = connected
    air.silence()
    gone = wait(2.0)
    air.clear()
    assert heard_again(laptop.python, gone) < soon(2.0)  # systems before Linux 6.15 repeat later
    assert laptop.python.ask("heard.subscriber.stats()[0].reconnects") == 0
    numbers = laptop.python.ask("[number for _, _, number in heard.messages]")
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))


@pytest.mark.parametrize("ends", [1.0, 5.0], ids=["forgotten meanwhile", "its result was lost"])
def test_a_goal_that_ends_in_silence(ends: float, connected: Network) -> None:
    """Its result went into a dead connection: the wait ends with an error that says so, not with the time-out."""
    robot, laptop, air = connected
    robot.python.do(
        "from rosproto import ActionServer\n"
        f"server = ActionServer(node, '/act', 'move_base_msgs/MoveBaseAction', lambda g: (time.sleep({ends}), g.succeed()))\n"
    )
    laptop.python.do(
        "from msgdefs.move_base_msgs.msg import MoveBaseGoal\n"
        "from rosproto import ActionClient\n"
        "client = ActionClient(node, '/act', 'move_base_msgs/MoveBaseAction')\n"
        "client.wait_for_server(20)\n"
        "goal = client.send_goal(MoveBaseGoal())\n",
        40,
    )
    laptop.python.eventually("goal.state.name == 'ACTIVE'")
    air.silence()
    wait(SILENT)
    air.clear()
    laptop.python.eventually("goal.done or goal.connection_error is None")  # the server is heard again
    laptop.python.do("try: goal.wait(60)\nexcept Exception as error: said = repr(error)", 80)
    assert laptop.python.ask("said").startswith("ConnectionLost(")
    assert "is lost" in laptop.python.ask("said")
    # A goal sent before the server has its goal connection again would go into the dead one, and be unanswered.
    robot.python.eventually(
        "any(s.topic == '/act/goal' and s.connected and s.reconnects for s in node.stats().links)", 20
    )
    laptop.python.do("client.wait_for_server(20)", 30)
    assert laptop.python.ask("client.send_goal(MoveBaseGoal()).wait(30) is not None", 40) is True


@pytest.mark.parametrize("way", ["there", "back"])
def test_one_way(way: str, connected: Network) -> None:
    """Only the robot's packets are lost, or only ours: heard again within a second all the same."""
    robot, laptop, air = connected
    direction = getattr(air, way)
    direction.open = False
    gone = wait(SILENT)
    direction.open = True
    assert heard_again(laptop.python, gone) < soon(LINK_SECONDS)
    assert heard_again(robot.python, gone) < soon(LINK_SECONDS)


def test_a_robot_with_real_ros(network: Network) -> None:
    """rosmaster and a rospy talker: its old messages stay where they are, and it hears us again."""
    require_ros("rosmaster", "std_msgs")
    robot, laptop, air = network
    env = environment(MASTER, extra={"ROS_IP": ROBOT})
    robot.start(PYTHON, "/usr/bin/rosmaster", "--core", "-p", "11311", env=env)
    robot.python.eventually(f"reachable({ROBOT!r}, 11311)")
    talker = robot.start(PYTHON, "-c", TALKER, env=env)
    start_laptop(laptop.python)
    talker.wait_for("^heard")
    air.silence()
    gone = wait(SILENT)
    air.clear()
    assert heard_again(laptop.python, gone) < soon(LINK_SECONDS)
    assert laptop.python.ask(f"heard.latest_after({gone!r})") < FRESH * crowd()
    laptop.python.eventually("tick.publisher.connections")
    wait(2.0)  # its kernel may repeat, and ours, once a second
    heard = [line.split() for line in talker.output.splitlines() if line.startswith("heard")]
    assert any(float(sent) > gone for _, sent, _ in heard)
