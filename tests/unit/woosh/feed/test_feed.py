"""A feed over a node that is a stand-in: first use, waiting, callbacks, closing."""

from __future__ import annotations

import asyncio
import math
import threading
from types import SimpleNamespace

import pytest

from msgdefs.sensor_msgs.msg import Image
from rosproto.errors import ConnectionLost, RosTimeout
from rosproto.node import ConnectedLink
from woosh_pure import interface
from woosh_pure.aio.calls import ThreadCalls
from woosh_pure.aio.feed import Feed as AwaitedFeed
from woosh_pure.connection.call_scope import CallScope
from woosh_pure.feed.feed import Feed
from woosh_pure.values.messages import message_type


class StandIn:
    """A subscriber with links that a test sets."""

    def __init__(self, links=(), latching=False):
        self.states = [SimpleNamespace(connected=c, last_error=e) for c, e in links]
        self.latching = latching
        self.callback = None
        self.options = {}
        self.on_links = None
        self.changes = 0
        self.errors = []
        self.asked = 0
        self.closed = False
        self.close_reason = ""

    @property
    def connections(self):
        return sum(link.connected for link in self.states)

    def connect(self, number, up):
        """Make or lose a link, and tell."""
        self.states[number] = SimpleNamespace(connected=up, last_error="")
        self.changes += 1
        self.tell()

    def tell(self):
        up = [n for n, link in enumerate(self.states) if link.connected]
        self.on_links(frozenset(ConnectedLink("/node", str(n), self.changes) for n in up))

    def stats(self):
        self.asked += 1
        if self.asked > 3:  # a moment later
            for link in self.states:
                link.connected = link.connected or not link.last_error
        return self.states

    def subscriber(self, topic, type_, *, callback, on_links, **options):
        self.callback, self.on_links, self.options = callback, on_links, options
        self.tell()
        return self

    def close(self):
        pass


def feed_of(topic="/odometer", **options):
    node = StandIn(**options)
    return Feed(interface.row(topic), lambda: node), node


def number(value):
    return SimpleNamespace(data=value)


def test_the_first_use_waits_until_the_links_stand():
    feed, node = feed_of(links=[(False, ""), (False, "")])
    assert feed.latest is None
    assert node.connections == 2


def test_a_publisher_that_cannot_be_reached_and_one_that_does_not_exist_are_not_waited_for():
    feed, node = feed_of(links=[(False, "refused")])
    assert feed.wait_connected() is False
    assert node.asked == 1
    assert feed_of(links=[])[0].latest is None


def test_a_latched_value_is_there_at_the_first_use():
    feed, node = feed_of(links=[(True, "")], latching=True)
    feed.open()
    threading.Timer(0.02, lambda: node.callback(number(4.0))).start()
    assert feed.latest == 4.0


def test_a_latched_value_that_comes_while_the_topic_is_opened_is_the_next_one(monkeypatch):
    """On a quick network it is there before `wait` has got round to waiting, and no other follows."""
    feed, node = feed_of(latching=True)
    subscribe = node.subscriber

    def quick(*args, **options):
        subscribe(*args, **options).callback(number(4.0))
        return node

    monkeypatch.setattr(node, "subscriber", quick)
    assert feed.wait(20.0) == 4.0


def test_a_value_sent_on_change_only_is_outdated_while_its_links_are_not_those_it_came_over():
    """A change may have been missed; a link that is up and silent does not make it so, as nothing changed."""
    feed, node = feed_of("/robot_status", links=[(True, ""), (True, "")])
    feed.open()
    assert not feed.outdated  # nothing was heard
    status = message_type("woosh_msgs/RobotStatus")()
    node.callback(status)
    assert not feed.outdated
    node.connect(1, False)
    assert (feed.outdated, feed.publishers) == (True, 1)
    node.connect(1, True)
    assert (feed.outdated, feed.sources) == (True, {"0", "1"})
    node.callback(status)
    assert not feed.outdated
    feed.close()
    assert (feed.outdated, feed.links) == (True, frozenset())


def test_a_value_that_is_sent_all_the_time_is_never_outdated_by_its_links():
    feed, node = feed_of(links=[(True, "")])
    feed.open()
    node.callback(number(1.0))
    node.connect(0, False)
    assert not feed.outdated


def test_opening_does_not_wait():
    feed, node = feed_of(links=[(False, "")])
    feed.open()
    assert node.asked == 0


def test_known_neither_subscribes_nor_waits():
    feed, node = feed_of()
    assert feed.known is None
    assert node.callback is None


def test_what_is_sent_on_change_only_is_never_given_up_for_newer_messages():
    feed, node = feed_of("/robot_status")
    feed.open()
    assert node.options["queue_size"] >= 1000


def test_of_pictures_only_a_few_are_kept():
    """A hundred point clouds of a depth camera are half a gigabyte."""
    picture = Image(height=1, width=1, step=3, encoding="rgb8", data=b"rgb")
    for topic, message, kept in (("/camera_1/color/image_raw", picture, 3), ("/odometer", number(1), 100)):
        feed, node = feed_of(topic)
        feed.open()
        for _ in range(kept + 5):
            node.callback(message)
        assert (feed.count, len(feed.known_history)) == (kept + 5, kept)


def test_the_history_can_be_read_while_it_grows():
    """By another thread, and on a Python without the GIL, where a deque cannot be copied meanwhile."""
    feed, node = feed_of()
    feed.open()

    def receive():
        for value in range(2000):
            node.callback(number(value))

    thread = threading.Thread(target=receive)
    thread.start()
    while thread.is_alive():
        values = [reading.value for reading in feed.known_history]
        assert values == sorted(values)
    thread.join()
    assert feed.known.value == 1999


def test_a_value_that_was_true_for_a_moment_is_not_missed():
    feed, node = feed_of()
    feed.open()
    node.callback(number(1.0))
    seen = []

    def accept(value):
        seen.append(value)
        if value == 1.0:  # two more come while the caller looks at the first
            node.callback(number(2.0))
            node.callback(number(3.0))
        return value == 2.0

    assert feed.wait_for(accept, 1.0) == 2.0
    assert seen == [1.0, 2.0]


def test_waiting_in_its_own_callback_is_an_error_and_not_a_hang(caplog):
    feed, node = feed_of()
    feed.on(lambda value: feed.wait(None))
    node.callback(number(1.0))
    assert "would never end" in caplog.text
    with pytest.raises(RosTimeout):
        feed.wait(0.0)


@pytest.mark.parametrize("timeout", [-1.0, math.nan])
def test_a_time_limit_that_makes_no_sense_is_refused(timeout):
    feed, _ = feed_of()
    for call in (feed.wait, lambda t: feed.wait_for(bool, t)):
        with pytest.raises(ValueError, match="at least 0"):
            call(timeout)


def test_a_closed_feed_tells_so_and_keeps_what_it_heard():
    feed, node = feed_of()
    feed.open()
    node.callback(number(1.0))
    feed.close()
    assert feed.latest == 1.0
    assert list(feed) == []
    for call in (feed.wait, lambda: feed.wait_for(bool), lambda: feed.on(print)):
        with pytest.raises(ConnectionLost, match="closed"):
            call()
    never_used, _ = feed_of()
    never_used.close()
    with pytest.raises(ConnectionLost, match="closed"):
        never_used.latest  # noqa: B018


def test_closing_wakes_who_waits():
    feed, _ = feed_of()
    feed.open()
    threading.Timer(0.05, feed.close).start()
    with pytest.raises(ConnectionLost, match="closed"):
        feed.wait(None)


def test_no_wait_lasts_longer_than_a_slice_at_a_time(monkeypatch):
    """On Windows a lock that waits cannot be interrupted by Ctrl-C: long waits are made of short ones."""
    waited = []
    feed, node = feed_of()
    feed.open()

    def wait(_, timeout=None):
        waited.append(timeout)
        node.callback(number(1.0))

    monkeypatch.setattr("woosh_pure.feed.feed._wait_for", wait)
    assert feed.wait(None) == 1.0
    assert waited
    assert all(timeout is not None and timeout <= 0.1 for timeout in waited)


def test_a_node_that_was_shut_down_by_others_ends_every_wait():
    """`rosnode kill` closes our subscriber: nothing will come, and the reason is known."""
    feed, node = feed_of(links=[(True, "")])
    feed.open()
    node.closed, node.close_reason = True, "user request"
    with pytest.raises(ConnectionLost, match="user request"):
        feed.wait(None)


@pytest.mark.timeout(20)
def test_a_node_that_was_shut_down_by_others_ends_every_iteration():
    """As a chassis that is closed does; the value that was heard before is not given again."""
    feed, node = feed_of(links=[(True, "")])
    feed.open()
    node.callback(number(1.0))
    values = iter(feed)
    assert next(values) == 1.0
    threading.Timer(0.05, setattr, (node, "closed", True)).start()
    assert list(values) == []
    assert list(feed) == []


@pytest.mark.parametrize("heard", [True, False])
def test_an_awaited_iteration_ends_with_its_chassis_however_early_that_closes(heard):
    """Here between its first turn of the loop and the thread that subscribes."""
    feed, node = feed_of(links=[(True, "")])
    if heard:
        feed.open()
        node.callback(number(1.0))

    class CloseFirst(ThreadCalls):
        async def opened(self, function, dispose):
            feed.close()
            return await super().opened(function, dispose)

    async def values():
        return [value async for value in AwaitedFeed(feed, CloseFirst(CallScope))]

    assert asyncio.run(values()) == []


def test_an_awaited_iteration_that_begins_after_the_end_is_as_the_other_one():
    """Of what was heard there is no more; where nothing was, the program has a mistake."""

    async def values(feed):
        return [value async for value in AwaitedFeed(feed, ThreadCalls(CallScope))]

    feed, node = feed_of(links=[(True, "")])
    feed.open()
    node.callback(number(1.0))
    feed.close()
    assert asyncio.run(values(feed)) == list(feed) == []
    never_used, _ = feed_of()
    never_used.close()
    for each in (lambda: list(never_used), lambda: asyncio.run(values(never_used))):
        with pytest.raises(ConnectionLost, match="closed"):
            each()
