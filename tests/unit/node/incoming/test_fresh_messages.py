"""What comes through a connection made now was published after it was made."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest

from msgdefs.std_msgs.msg import Int32, String
from rosproto import Master, Node
from rosproto.errors import ConnectionLost, ProtocolError, RosError
from rosproto.node import Publisher, fresh_messages
from rosproto.transport import Deadline
from tests.support.waiting import until


@pytest.fixture(params=[False, True], ids=["by TCP", "in one process"])
def nodes(request: pytest.FixtureRequest) -> Iterator[tuple[Node, Node]]:
    """A publishing and a reading node."""
    with (
        Master(host="127.0.0.1", port=0) as master,
        Node("talker", master_uri=master.uri, host="127.0.0.1") as one,
        Node("reader", master_uri=master.uri, host="127.0.0.1", intraprocess=request.param) as other,
    ):
        yield one, other


def address_of(reader: Node, publisher: Publisher) -> str:
    """Where its publisher listens, as an ordinary link of the reader shows it."""
    subscriber = reader.subscriber(publisher.topic, Int32)
    until(lambda: subscriber.connections)
    return str(subscriber.stats()[0].address)


@pytest.mark.parametrize("latch", [False, True])
def test_what_was_published_before_does_not_come(nodes: tuple[Node, Node], latch: bool) -> None:
    """Not even the message that a latching publisher sends to each newcomer."""
    talker, reader = nodes
    with talker.publisher("/n", Int32, latch=latch) as publisher:
        address = address_of(reader, publisher)
        publisher.publish(Int32(data=1))
        messages = fresh_messages(reader, "/n", Int32, address, Deadline(10.0))
        got: list[int] = []
        reading = threading.Thread(target=lambda: got.append(next(messages).data))
        reading.start()
        until(lambda: publisher.connections == 2)
        publisher.publish(Int32(data=2))
        reading.join(10.0)
        messages.close()
        assert got == [2]
        until(lambda: publisher.connections == 1)


def test_it_ends_at_the_deadline(nodes: tuple[Node, Node]) -> None:
    talker, reader = nodes
    with talker.publisher("/n", Int32) as publisher:
        address = address_of(reader, publisher)
        assert list(fresh_messages(reader, "/n", Int32, address, Deadline(0.3))) == []


def test_a_publisher_that_is_gone_or_has_another_type_is_an_error(nodes: tuple[Node, Node]) -> None:
    talker, reader = nodes
    with talker.publisher("/n", Int32) as publisher:
        address = address_of(reader, publisher)
        with pytest.raises((ProtocolError, ConnectionLost)):
            next(fresh_messages(reader, "/n", String, address, Deadline(5.0)))
    talker.close()
    with pytest.raises(RosError):
        next(fresh_messages(reader, "/n", Int32, address, Deadline(5.0)))
