"""Deadlines and back-off, on a clock that the test advances."""

from __future__ import annotations

import queue
import threading

import pytest

from rosproto.errors import RosTimeout
from rosproto.transport.backoff import Backoff
from rosproto.transport.deadline import SYSTEM, Deadline, next_item
from tests.support.clock import FakeClock


def test_rounding_adds_no_time() -> None:
    """(t + 0.1) - t is more than 0.1 for half of all t; clocks of Windows often stand still between two looks."""
    clock = FakeClock()
    for _ in range(20):
        clock.advance(1234.567)
        left = Deadline(0.1, clock).remaining()
        assert left is not None
        assert left <= 0.1


def test_a_deadline_counts_down_and_stays_at_zero() -> None:
    clock = FakeClock()
    deadline = Deadline(2.0, clock)
    assert deadline.remaining() == 2.0
    clock.advance(1.5)
    assert deadline.remaining() == 0.5
    assert not deadline.expired
    deadline.check("x")
    clock.advance(5)
    assert deadline.remaining() == 0.0
    assert deadline.expired
    with pytest.raises(RosTimeout, match=r"the answer: not within 2\.0 s") as caught:
        deadline.check("the answer")
    assert (caught.value.what, caught.value.seconds) == ("the answer", 2.0)


def test_none_never_comes() -> None:
    deadline = Deadline(None, FakeClock())
    assert deadline.remaining() is None
    assert not deadline.expired
    deadline.check("x")
    assert deadline.at_most(3).remaining() == 3


def test_zero_is_over_at_once() -> None:
    assert Deadline(0, FakeClock()).expired


def test_at_most_takes_the_earlier() -> None:
    clock = FakeClock()
    assert Deadline(5, clock).at_most(2).remaining() == 2
    assert Deadline(1, clock).at_most(2).remaining() == 1


def test_the_system_clock_waits_for_events() -> None:
    event = threading.Event()
    assert not SYSTEM.wait(event, 0)
    event.set()
    assert SYSTEM.wait(event, None)
    assert SYSTEM.monotonic() <= SYSTEM.monotonic()


def test_delays_double_up_to_the_most_and_start_again() -> None:
    backoff = Backoff(first=1, factor=2, maximum=5, jitter=0)
    assert [backoff.next() for _ in range(5)] == [1, 2, 4, 5, 5]
    backoff.reset()
    assert backoff.next() == 1


def test_jitter_stays_within_its_share() -> None:
    backoff = Backoff(first=1, factor=1, maximum=1, jitter=0.25)
    delays = [backoff.next() for _ in range(200)]
    assert all(0.75 <= delay <= 1.25 for delay in delays)
    assert len(set(delays)) > 1


def test_an_item_that_does_not_come_is_not_waited_for_for_ever() -> None:
    """`SimpleQueue.get` alone hung within seconds when its time ran out within the call (before CPython 3.13)."""

    def look() -> None:
        for _ in range(10_000):
            with pytest.raises(queue.Empty):
                next_item(queue.SimpleQueue(), 1e-6)

    thread = threading.Thread(target=look, daemon=True)
    thread.start()
    thread.join(60.0)
    assert not thread.is_alive()


def test_an_item_is_taken_at_once_or_when_it_comes() -> None:
    items: queue.SimpleQueue[int] = queue.SimpleQueue()
    items.put(1)
    assert next_item(items, 0.0) == 1
    threading.Timer(0.05, items.put, [2]).start()
    assert next_item(items, 20.0) == 2
