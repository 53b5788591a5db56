"""`inline=True`: callbacks in the receiving thread, as rospy has them."""

from __future__ import annotations

import threading
from typing import Any

from rosproto.master import Master
from rosproto.node import Node
from rosproto.node.incoming.subscriber_queue import Inbox, InlineCaller


def test_a_batch_is_cut_to_the_queue_and_called_in_order() -> None:
    """Of what one read brings, the last `queue_size` messages are called with, in their order."""
    seen: list[Any] = []
    inbox = Inbox(3)
    InlineCaller(seen.append, inbox, "/t").offer([1, 2, 3, 4, 5], 0.0)
    assert seen == [3, 4, 5]
    assert (inbox.received, inbox.dropped, inbox.latest) == (5, 2, 5)


def test_an_error_in_the_callback_does_not_end_the_batch() -> None:
    """The next message is called with all the same."""
    seen: list[Any] = []

    def callback(message: Any) -> None:
        seen.append(message)
        raise ValueError("mine")

    InlineCaller(callback, Inbox(9), "/t").offer([1, 2], 0.0)
    assert seen == [1, 2]


def test_closing_in_the_callback_ends_the_batch() -> None:
    """No callback begins after `close`."""
    seen: list[Any] = []
    inbox = Inbox(9)

    def callback(message: Any) -> None:
        seen.append(message)
        inbox.close()

    caller = InlineCaller(callback, inbox, "/t")
    caller.offer([1, 2], 0.0)
    caller.offer([3], 0.0)
    assert seen == [1]


def test_all_messages_of_a_publisher_come_in_one_thread_even_when_slow() -> None:
    """A callback that blocks keeps its thread; nothing is handed to another one."""
    threads: list[int] = []
    done, go = threading.Event(), threading.Event()

    def callback(message: Any) -> None:
        threads.append(threading.get_ident())
        if len(threads) == 1:
            go.wait(20)
        if len(threads) == 3:
            done.set()

    with Master() as master, Node("/n", master_uri=master.uri, intraprocess=False) as node:
        publisher = node.publisher("/t", "std_msgs/String")
        node.subscriber("/t", "std_msgs/String", callback, queue_size=100, inline=True)
        publisher.wait_for_connection()
        for word in "abc":
            publisher.publish(data=word)
        go.set()
        assert done.wait(20)
    assert len(set(threads)) == 1
