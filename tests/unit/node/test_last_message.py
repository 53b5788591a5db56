"""`Publisher.close(wait=...)`: subscribers read the last message before the master tells them that we are gone."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest

from rosproto.master import Master
from rosproto.node import Node, Publisher
from tests.support import attacks
from tests.support.victim import eventually

TOPIC = "/last"


@pytest.fixture
def node(master: Master) -> Iterator[Node]:
    with Node("/last_words", master_uri=master.uri, host="127.0.0.1", rosout=False, timeout=20.0) as node:
        yield node


@pytest.fixture
def publisher(node: Node) -> Publisher:
    return node.publisher(TOPIC, "std_msgs/String")


def registered(node: Node) -> bool:
    return bool(node.master.get_system_state().publishers.get(TOPIC))


def test_it_is_unregistered_when_a_slow_subscriber_has_read_everything(
    node: Node, publisher: Publisher
) -> None:
    with attacks.connect(node.tcpros_address, attacks.subscriber_header(TOPIC)) as sock:
        publisher.wait_for_connection(20.0)
        publisher.publish(data="the last word")
        closing = threading.Thread(target=publisher.close, kwargs={"wait": 60.0})
        closing.start()
        read = b""
        while data := sock.recv(7):  # until the publisher says that nothing more comes
            assert registered(node)
            read += data
        assert read.endswith(b"the last word")
        late = attacks.connect(node.tcpros_address, attacks.subscriber_header(TOPIC))
        with late:
            assert b"does not publish" in late.recv(1000)
        assert registered(node)
    closing.join(20.0)
    assert not closing.is_alive()
    assert not registered(node)


def test_a_subscriber_that_reads_nothing_is_not_waited_for(node: Node, publisher: Publisher) -> None:
    with attacks.connect(node.tcpros_address, attacks.subscriber_header(TOPIC)):
        publisher.wait_for_connection(20.0)
        publisher.publish(data="x" * 100)
        publisher.close(wait=0.1)
        assert not registered(node)
        assert publisher.closed


def test_another_publisher_of_the_topic_goes_on(node: Node, publisher: Publisher) -> None:
    with Node("/reader", master_uri=node.master.uri, host="127.0.0.1", rosout=False) as reader:
        subscriber = reader.subscriber(TOPIC, "std_msgs/String")
        second = node.publisher(TOPIC, "std_msgs/String")
        publisher.wait_for_connection(20.0)
        publisher.close(wait=60.0)
        second.publish(data="still here")
        assert subscriber.next(20.0).data == "still here"
        second.publish(data="the last word")
        second.close(wait=60.0)
        assert subscriber.next(20.0).data == "the last word"
        eventually(lambda: subscriber.connections == 0)
