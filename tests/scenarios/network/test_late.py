"""What reaches the robot too late is not carried out: goals that were given up, words of a dead program."""

from __future__ import annotations

import pytest

from tests.scenarios.network.conftest import MASTER, Network, wait
from tests.support.hosts import ROBOT
from tests.support.ros import PYTHON, environment, require_ros

pytestmark = pytest.mark.slow

CLIENT = """
from msgdefs.move_base_msgs.msg import MoveBaseGoal
from rosproto import ActionClient, Node
client = ActionClient(node, "/act", "move_base_msgs/MoveBaseAction")
client.wait_for_server(20)
"""
SERVER = """
from rosproto import ActionServer
ran = []
server = ActionServer(node, "/act", "move_base_msgs/MoveBaseAction", ran.append)
"""
ROSPY_SERVER = """
import rospy, actionlib, time
from move_base_msgs.msg import MoveBaseAction
rospy.init_node("robot")
def run(goal):
    print("began", flush=True)
    while not server.is_preempt_requested():
        time.sleep(0.01)
    print("cancelled", flush=True)
    server.set_preempted()
server = actionlib.SimpleActionServer("/act", MoveBaseAction, run, auto_start=False)
server.start()
rospy.spin()
"""


def test_a_goal_sent_into_a_connection_that_the_server_gave_up(connected: Network) -> None:
    """It is LOST as soon as the server is heard again and does not know it, and it never runs."""
    robot, laptop, air = connected
    robot.python.do(SERVER)
    laptop.python.do(CLIENT, 40)
    air.silence()
    robot.python.eventually("not any(s.connected for s in node.stats().links if s.topic == '/act/goal')")
    laptop.python.do("goal = client.send_goal(MoveBaseGoal())")
    air.clear()
    laptop.python.eventually("goal.done")
    assert laptop.python.ask("(goal.status.name, goal.state.name)") == ["LOST", "DONE"]
    assert "has not mentioned it" in laptop.python.ask("goal.text")
    assert robot.python.ask("len(ran)") == 0


def test_a_goal_that_arrives_after_it_was_given_up(network: Network) -> None:
    """The link lives and TCP repeats the goal: rospy's server begins, and is told to cancel at once."""
    require_ros("rosmaster", "actionlib", "move_base_msgs")
    robot, laptop, air = network
    env = environment(MASTER, extra={"ROS_IP": ROBOT})
    robot.start(PYTHON, "/usr/bin/rosmaster", "--core", "-p", "11311", env=env)
    robot.python.eventually(f"reachable({ROBOT!r}, 11311)")
    server = robot.start(PYTHON, "-c", ROSPY_SERVER, env=env)
    laptop.python.do(f"from rosproto import Node\nnode = Node('/laptop', master_uri={MASTER!r})")
    laptop.python.do(CLIENT, 40)
    air.back.open = False
    laptop.python.do("goal = client.send_goal(MoveBaseGoal())")
    wait(2.0)
    assert laptop.python.ask("goal.give_up()") is True
    air.back.open = True
    server.wait_for("^cancelled")
    assert "began" in server.output
    assert laptop.python.ask("goal.status.name") == "LOST"


def test_what_a_killed_program_had_sent(connected: Network) -> None:
    """The system would deliver it when the network is back, long after its program: not with `linger=False`."""
    robot, laptop, air = connected
    robot.python.do("command, other = Heard(node, '/command'), Heard(node, '/other')")
    program = laptop.another()
    program.do(
        "from rosproto import Node\n"
        f"node = Node('/program', master_uri={MASTER!r})\n"
        "command = Ticker(node, '/command', 20, linger=False)\n"
        "other = Ticker(node, '/other', 20)\n"
    )
    robot.python.eventually("command.messages and other.messages")
    air.silence()
    gone = wait(0.5)
    program.kill()
    air.clear()
    robot.python.eventually(f"other.since({gone!r})")
    wait(1.0)
    assert robot.python.ask(f"command.since({gone!r})") == []


def test_a_request_whose_caller_has_given_up(connected: Network) -> None:
    """The system would repeat it until the network is back: a task would begin after its program said it failed."""
    robot, laptop, air = connected
    robot.python.do(
        "served = []\n"
        "server = node.service_server('/do', 'std_srvs/Trigger', lambda request: served.append(1) or {'success': True})"
    )
    laptop.python.do(
        "client = node.service_client('/do', 'std_srvs/Trigger', persistent=True)\nclient.call(timeout=10)"
    )
    air.back.open = False
    laptop.python.do("try: client.call(timeout=1.0)\nexcept Exception as error: said = type(error).__name__")
    assert laptop.python.ask("said") == "RosTimeout"
    air.back.open = True
    laptop.python.do("client.call(timeout=10)")
    wait(2.0)
    assert robot.python.ask("len(served)") == 2
