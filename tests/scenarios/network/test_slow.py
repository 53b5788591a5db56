"""Networks that are slow, lose packets, or are full: everything goes on working, and small topics stay timely."""

from __future__ import annotations

import pytest

from tests.scenarios.network.conftest import Network, start_laptop, start_robot, wait
from tests.support.load import crowd

pytestmark = pytest.mark.slow

ROBOT_SIDE = """
from rosproto import ActionServer
server = node.service_server("/set", "std_srvs/SetBool", lambda r: {"success": r.data, "message": "done"})
def act(goal):
    goal.succeed()
actions = ActionServer(node, "/act", "move_base_msgs/MoveBaseAction", act)
"""
TOO_OLD = "s old, have not arrived"  # the rule by which a publisher gives a connection up
NOTED = """
import logging
class Noted(logging.Handler):
    why = []
    def emit(self, record):
        if " is gone" in record.getMessage():
            self.why.append(record.getMessage())
noted = Noted()
logging.getLogger("rosproto").addHandler(noted)
logging.getLogger("rosproto").setLevel(logging.DEBUG)
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
    """Subscriptions, services, parameters and actions, with their default time-outs; no link breaks.

    One exception is a matter of chance: the same bytes are lost again and again, until they are four seconds old.
    """
    robot, laptop, air = connected
    robot.python.do(NOTED)
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
    why = robot.python.ask("noted.why")
    assert all(TOO_OLD in text for text in why), why
    errors = laptop.python.ask("[str(error) for error in heard.subscriber.errors]")
    assert laptop.python.ask("heard.subscriber.stats()[0].reconnects") <= len(why), errors
    assert laptop.python.ask("node.stats().master_lost") is False


def test_a_network_that_always_loses_some_ends_no_link_by_the_limit_of_the_system(network: Network) -> None:
    """Linux counts from the first loss as long as there is another one, also while data arrives all the time."""
    robot, laptop, air = network
    robot.python.do(
        "from rosproto.transport import tcp; tcp.KEEPALIVE_IDLE, tcp.KEEPALIVE_INTERVAL = 1, 1"
    )  # 5 s
    start_robot(robot.python)
    start_laptop(laptop.python)
    robot.python.do("tickers = [Ticker(node, f'/many{n}', 20) for n in range(20)]")
    laptop.python.do("many = [Heard(node, f'/many{n}') for n in range(20)]")
    laptop.python.eventually("all(one.messages for one in many)")
    robot.python.do(NOTED)
    for way in (air.there, air.back):
        way.delay, way.loss = 0.3, 0.05
    began = wait(20.0)
    laptop.python.eventually(f"all(one.first_sent_after({began!r}) for one in many)")
    why = robot.python.ask("noted.why")
    assert all(TOO_OLD in text for text in why), why
    assert len(why) <= 10, why


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
