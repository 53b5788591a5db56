"""Topics shared by clients: subscribed once, while wanted; latched messages for newcomers; nothing left behind."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Iterator

import pytest

from rosproto import Master, Node
from rosproto.codec import AnyMsg, define, message_class
from rosproto.errors import LocalProtocolError
from rosproto.gateway import GatewayLimits, MessageEvent, SharedSubscriptions

String = message_class("std_msgs/String")


class Receiver:
    """Keeps what it is offered."""

    def __init__(self) -> None:
        self.got: queue.Queue[MessageEvent] = queue.Queue()

    def offer(self, event: MessageEvent) -> None:
        self.got.put(event)

    def text(self) -> str:
        text: str = self.got.get(timeout=10).message.data
        return text


@pytest.fixture
def graph() -> Iterator[tuple[Node, Node]]:
    """A robot's node, and the gateway's."""
    with (
        Master() as master,
        Node("/robot", master_uri=master.uri, intraprocess=False) as robot,
        Node("/gateway", master_uri=master.uri, intraprocess=False) as gateway,
    ):
        yield robot, gateway


def until(holds: Callable[[], bool], seconds: float = 10.0) -> None:
    deadline = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < deadline, "it did not become true"
        threading.Event().wait(0.01)


def test_one_subscription_for_any_number_of_receivers(graph: tuple[Node, Node]) -> None:
    """And one decoded message."""
    robot, node = graph
    publisher = robot.publisher("/a", String)
    shared_subscriptions = SharedSubscriptions(node, GatewayLimits(linger_seconds=0.05))
    assert robot.master.get_system_state().subscribers.get("/a") is None
    receivers = [Receiver() for _ in range(5)]
    opened = [shared_subscriptions.open("/a", receiver) for receiver in receivers]
    publisher.wait_for_connection(10)
    assert publisher.connections == 1
    publisher.publish(data="one")
    events = [receiver.got.get(timeout=10) for receiver in receivers]
    assert len({id(event) for event in events}) == 1
    event = events[0]
    assert (event.topic, event.type_name, event.md5sum) == ("/a", "std_msgs/String", String._md5sum)
    assert (event.message.data, event.latched) == ("one", False)
    assert "string data" in event.definition
    assert bytes(event.data) == b"\x03\0\0\0one"
    made: list[int] = []
    assert event.once("json", lambda: made.append(1) or "text") == "text"  # type: ignore[func-returns-value]
    assert event.once("json", lambda: made.append(1) or "text") == "text"  # type: ignore[func-returns-value]
    assert made == [1]
    for subscription in opened:
        subscription.close()
        subscription.close()
    until(lambda: publisher.connections == 0)
    until(lambda: shared_subscriptions.topics == ())
    shared_subscriptions.close()


def test_a_topic_is_kept_for_who_comes_back_at_once(graph: tuple[Node, Node]) -> None:
    """A page that is loaded anew does not make the robot connect anew."""
    robot, node = graph
    publisher = robot.publisher("/a", String)
    left: list[str] = []
    publisher.on_disconnect = left.append
    shared_subscriptions = SharedSubscriptions(node, GatewayLimits(linger_seconds=30))
    first = shared_subscriptions.open("/a", Receiver())
    publisher.wait_for_connection(10)
    first.close()
    again = Receiver()
    shared_subscriptions.open("/a", again)
    publisher.publish(data="one")
    assert again.text() == "one"
    assert not left
    shared_subscriptions.close()
    until(lambda: publisher.connections == 0)
    until(lambda: not [t for t in threading.enumerate() if t.name.startswith("rosproto:leave")])


def test_newcomers_get_the_last_message_of_each_latched_publisher(graph: tuple[Node, Node]) -> None:
    """Of those that are still there; and of others nothing."""
    robot, node = graph
    latched = robot.publisher("/map", String, latch=True)
    shared_subscriptions = SharedSubscriptions(node)
    first = Receiver()
    shared_subscriptions.open("/map", first)
    latched.wait_for_connection(10)
    latched.publish(data="old")
    latched.publish(data="new")
    assert [first.text(), first.text()] == ["old", "new"]
    late = Receiver()
    subscription = shared_subscriptions.open("/map", late)
    assert late.text() == "new"
    assert late.got.empty()
    assert subscription.description is not None
    assert subscription.description.latched
    latched.close()
    until(lambda: subscription.connections == 0)
    later = Receiver()
    shared_subscriptions.open("/map", later)
    assert later.got.empty()
    shared_subscriptions.close()


def test_a_topic_may_change_its_type(graph: tuple[Node, Node]) -> None:
    """Each message comes with its own publisher's definition."""
    robot, node = graph
    other = define("my_msgs/Other", "int32 x\n")
    shared_subscriptions = SharedSubscriptions(node)
    receiver = Receiver()
    shared_subscriptions.open("/a", receiver)
    with robot.publisher("/a", String) as publisher:
        publisher.wait_for_connection(10)
        publisher.publish(data="one")
        assert receiver.text() == "one"
    with robot.publisher("/a", other) as publisher:
        publisher.wait_for_connection(10)
        publisher.publish(x=7)
        event = receiver.got.get(timeout=10)
    assert (event.type_name, event.message.x) == ("my_msgs/Other", 7)
    shared_subscriptions.close()


def test_a_publisher_that_tells_no_type_is_left_out(graph: tuple[Node, Node]) -> None:
    """Its type is unknown, so no client could decode it."""
    robot, node = graph
    shared_subscriptions = SharedSubscriptions(node)
    receiver = Receiver()
    shared_subscriptions.open("/a", receiver)
    with robot.publisher("/a", AnyMsg) as publisher:
        publisher.wait_for_connection(10)
        publisher.publish(b"\x03\0\0\0one")
    with robot.publisher("/a", String) as publisher:
        publisher.wait_for_connection(10)
        publisher.publish(data="two")
        assert receiver.text() == "two"
    shared_subscriptions.close()


def test_a_receiver_that_raises_costs_itself_only(graph: tuple[Node, Node]) -> None:
    """The others get the message."""
    robot, node = graph

    class Broken:
        def offer(self, event: MessageEvent) -> None:
            raise RuntimeError("broken")

    publisher = robot.publisher("/a", String)
    shared_subscriptions = SharedSubscriptions(node)
    shared_subscriptions.open("/a", Broken())
    receiver = Receiver()
    shared_subscriptions.open("/a", receiver)
    publisher.wait_for_connection(10)
    publisher.publish(data="one")
    publisher.publish(data="two")
    assert [receiver.text(), receiver.text()] == ["one", "two"]
    shared_subscriptions.close()


def test_closed_taps_open_nothing(graph: tuple[Node, Node]) -> None:
    """And a wrong name is an error that leaves nothing."""
    _, node = graph
    shared_subscriptions = SharedSubscriptions(node)
    with pytest.raises(ValueError):
        shared_subscriptions.open("/not a name", Receiver())
    assert shared_subscriptions.topics == ()
    shared_subscriptions.close()
    shared_subscriptions.close()
    with pytest.raises(LocalProtocolError):
        shared_subscriptions.open("/a", Receiver())


def test_many_come_and_go_at_once(graph: tuple[Node, Node]) -> None:
    """Threads that open and close the same topics leave none of them subscribed."""
    robot, node = graph
    publisher = robot.publisher("/a", String, latch=True)
    publisher.publish(data="one")
    shared_subscriptions = SharedSubscriptions(node, GatewayLimits(linger_seconds=0.01))
    missed: list[str] = []

    def come_and_go() -> None:
        for _ in range(20):
            receiver = Receiver()
            subscription = shared_subscriptions.open("/a", receiver)
            try:
                receiver.text()
            except queue.Empty:
                missed.append("a latched message")
            subscription.close()

    threads = [threading.Thread(target=come_and_go) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    assert not missed
    until(lambda: shared_subscriptions.topics == () and publisher.connections == 0)
    shared_subscriptions.close()


@pytest.mark.parametrize(("old", "new"), [("Tap", "SharedSubscription"), ("Taps", "SharedSubscriptions")])
def test_the_former_names_still_work(old: str, new: str) -> None:
    """With a warning that names the new one."""
    from rosproto import gateway

    with pytest.warns(DeprecationWarning, match=f"{old} is now {new}"):
        assert getattr(gateway, old) is getattr(gateway, new)
    with pytest.raises(AttributeError, match="no attribute 'Tapes'"):
        _ = gateway.Tapes
