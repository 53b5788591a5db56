"""`rosproto.node.fresh_messages` with publishers of rospy and roscpp: nothing comes that was published before the call.

The publisher writes the time into each message.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import closing
from itertools import islice

import pytest

from msgdefs.std_msgs.msg import String
from rosproto import Node
from rosproto.errors import ConnectionLost, RosError
from rosproto.node import fresh_messages, probe_topic
from rosproto.transport import Deadline
from tests.support import ros
from tests.support.waiting import until

TICKER = """
import time, rospy
from std_msgs.msg import String
rospy.init_node("ticker", disable_signals=True)
ticks = rospy.Publisher("/ticks", String, queue_size=10)
kept = rospy.Publisher("/kept", String, queue_size=10, latch=True)
now = lambda: repr(time.time())
kept.publish(now())
rospy.Subscriber("/go", String, lambda _: kept.publish(now()))
rospy.Timer(rospy.Duration(0.1), lambda _: ticks.publish(now()))
print("up", flush=True)
rospy.spin()
"""
"""The same program as the role `ticker` of roscpp_peer.cpp."""


@pytest.fixture(params=["rospy", "roscpp"])
def ticker(request: pytest.FixtureRequest, any_master: str) -> Iterator[ros.RosProcess]:
    """Publishes /ticks ten times a second, and latched /kept at its start and at each message of /go."""
    if request.param == "rospy":
        started = ros.start_rospy(TICKER, any_master)
    else:
        started = ros.start_program(request.getfixturevalue("roscpp_peer"), any_master, "ticker")
    with started as process:
        process.wait_for("^up")
        yield process


@pytest.fixture
def node(any_master: str) -> Iterator[Node]:
    """Our node."""
    with Node("/reader", master_uri=any_master) as made:
        yield made


def by_link(node: Node, topic: str) -> str:
    """The address of the publisher as a link shows it that has received something."""
    subscriber = node.subscriber(topic, String)
    subscriber.next(60)
    return str(subscriber.stats()[0].address)


def by_uri(node: Node, topic: str) -> str:
    """The XML-RPC URI of the publisher's node."""
    until(lambda: topic in node.master.get_system_state().publishers)
    return str(node.master.lookup_node("/ticker"))


@pytest.mark.parametrize("address_of", [by_link, by_uri])
def test_what_comes_was_published_after_the_call(
    ticker: ros.RosProcess, node: Node, any_master: str, address_of: Callable[[Node, str], str]
) -> None:
    """It is newer than all that another node had received: a publisher reads the clock a while before it publishes."""
    address = address_of(node, "/ticks")
    received: list[float] = []
    with (
        Node("/witness", master_uri=any_master) as other,
        other.subscriber("/ticks", String, lambda message: received.append(float(message.data))),
    ):
        until(lambda: received)
        for _ in range(20):  # at any moment between two messages
            before = received[-1]
            with closing(fresh_messages(node, "/ticks", String, address, Deadline(60.0))) as messages:
                assert float(next(messages).data) > before
            time.sleep(0.013)


def test_messages_of_a_publisher_that_goes_on_come_one_after_the_other(
    ticker: ros.RosProcess, node: Node
) -> None:
    address = by_link(node, "/ticks")
    with closing(fresh_messages(node, "/ticks", String, address, Deadline(60.0))) as messages:
        times = [float(message.data) for message in islice(messages, 5)]
    assert times == sorted(set(times))


@pytest.mark.promise("rospy ends the older one of two connections of the same callerid to a topic")
def test_the_connection_of_the_subscriber_stays(ticker: ros.RosProcess, node: Node) -> None:
    """rospy ends the older one of two connections with the same callerid."""
    subscriber = node.subscriber("/ticks", String)
    subscriber.next(60)
    (link,) = subscriber.stats()
    address = str(link.address)
    with closing(fresh_messages(node, "/ticks", String, address, Deadline(60.0))) as messages:
        next(messages)
        assert probe_topic(node, "/ticks", "/ticker", Deadline(60.0)).type_name == "std_msgs/String"
        next(messages)
        subscriber.next(60)
    (link,) = subscriber.stats()
    assert (link.connected, link.reconnects, link.last_error) == (True, 0, "")


def test_a_latched_message_is_old_and_the_next_one_is_not(ticker: ros.RosProcess, node: Node) -> None:
    """The same where the ordinary subscriber of the node has had it before."""
    go = node.publisher("/go", String)
    go.wait_for_connection(60)
    address = by_link(node, "/kept")
    assert list(fresh_messages(node, "/kept", String, address, Deadline(1.0))) == []
    began, connected = time.time(), []

    def send() -> None:
        if not connected:
            go.publish(String())

    with (
        node.clock.timer(0.2, lambda _: send()),
        closing(fresh_messages(node, "/kept", String, address, Deadline(60.0))) as messages,
    ):
        assert float(next(messages).data) >= began
        connected.append(True)


def test_a_publisher_that_goes_away_in_between_is_an_error_and_does_not_wait(
    ticker: ros.RosProcess, node: Node
) -> None:
    address = by_link(node, "/ticks")
    with closing(fresh_messages(node, "/ticks", String, address, Deadline(60.0))) as messages:
        next(messages)
        ticker.kill()
        with pytest.raises(ConnectionLost):
            list(messages)
    with pytest.raises(RosError):
        next(fresh_messages(node, "/ticks", String, address, Deadline(60.0)))
