"""Networks that are slow, lose packets, or are full: everything goes on working, and small topics stay timely."""

from __future__ import annotations

import pytest

from tests.support.load import crowd

from .conftest import Network, wait

pytestmark = pytest.mark.slow

ROBOT_SIDE = """
from rosproto import ActionServer
server = node.service_server("/set", "std_srvs/SetBool", lambda r: {"success": r.data, "message": "done"})
def act(goal):
    goal.succeed()
actions = ActionServer(node, "/act", "move_base_msgs/MoveBaseAction", act)
"""
LAPTOP_SIDE = """
from msgdefs.move_base_msgs.msg import MoveBaseGoal
from rosproto import ActionClient
once = node.service_client("/set", "std_srvs/SetBool")
kept = node.service_client("/set", "std_srvs/SetBool", persistent=True)
client = ActionClient(node, "/act", "move_base_msgs/MoveBaseAction")
client.wait_for_server(30)
"""


def test_three_hundred_milliseconds_and_five_percent_loss(connected: Network) -> None:
    """Subscriptions, services, parameters and actions, with their default time-outs; no link breaks."""
    robot, laptop, air = connected
    for way in (air.there, air.back):
        way.delay, way.loss = 0.3, 0.05
    robot.python.do(ROBOT_SIDE)
    laptop.python.do(LAPTOP_SIDE, 60)
    for _ in range(3):
        assert laptop.python.ask("once.call(data=True).success", 30) is True
        assert laptop.python.ask("kept.call(data=True).success", 30) is True
    laptop.python.do("node.params['/slow'] = 1", 30)
    assert laptop.python.ask("node.params['/slow']", 30) == 1
    assert laptop.python.ask("client.send_goal(MoveBaseGoal()).wait(30) is not None", 40) is True
    began = wait(4.0)
    laptop.python.eventually(f"heard.first_sent_after({began!r})")
    why = laptop.python.ask("[str(error) for error in heard.subscriber.errors]")
    assert laptop.python.ask("heard.subscriber.stats()[0].reconnects") == 0, why
    assert laptop.python.ask("node.stats().master_lost") is False


def test_a_link_that_begins_on_a_slow_network(connected: Network) -> None:
    """A round trip takes longer than the first attempt to connect waits alone."""
    robot, laptop, air = connected
    for way in (air.there, air.back):
        way.delay = 0.7
    laptop.python.do("other = Heard(node, '/t2')", 40)
    robot.python.do("tick2 = Ticker(node, '/t2', 20)", 40)
    laptop.python.eventually("other.messages")


def test_a_command_topic_beside_large_images(connected: Network) -> None:
    """1 MB/s, 9 MB/s of images: commands still take a fraction of a second; publish() waits for neither."""
    robot, laptop, air = connected
    robot.python.do("images = Ticker(node, '/image', 10, padding=900_000, queue_size=1)")
    laptop.python.do("seen = Heard(node, '/image', queue_size=1)")
    laptop.python.eventually("seen.messages")
    for way in (air.there, air.back):
        way.rate, way.delay = 1e6, 0.005
    full = wait(2.0)
    robot.python.do("tick.longest = images.longest = 0.0")
    wait(6.0)
    delays = sorted(got - sent for got, sent, _ in laptop.python.ask(f"heard.since({full!r})"))
    assert len(delays) > 60 / crowd()
    assert delays[len(delays) // 2] < 0.3 * crowd()
    assert delays[-1] < 1.5 * crowd()
    # Old images are dropped where they wait, not carried: what comes is from the last seconds.
    images = [got - sent for got, sent, _ in laptop.python.ask(f"seen.since({full!r})")]
    assert len(images) >= 3
    assert max(images) < 5.0 * crowd()
    dropped, queued = robot.python.ask("[(s.dropped, s.queued) for s in images.publisher.stats()][0]")
    assert dropped > 30 / crowd()
    assert queued <= 2
    assert robot.python.ask("max(tick.longest, images.longest)") < 1.0 * crowd()
