"""Time of a node: real, simulated, jumping back."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from rosproto.master import Master
from rosproto.node import MasterClient, Node, NodeClock, TimerEvent
from rosproto.time import Time
from tests.support.victim import eventually


class Clock:
    """A publisher of /clock."""

    def __init__(self, node: Node) -> None:
        self._publisher = node.publisher("/clock", "rosgraph_msgs/Clock", latch=True)
        self._class: Any = self._publisher.message_class

    def tell(self, seconds: float) -> None:
        self._publisher.publish(self._class(clock=Time.from_sec(seconds)))


@pytest.fixture
def simulated() -> Iterator[tuple[Node, Clock]]:
    with Master() as master:
        with MasterClient(master.uri, "/test") as client:
            client.set_param("/use_sim_time", True)
        with (
            Node("/time", master_uri=master.uri, rosout=False) as source,
            Node("/n", master_uri=master.uri, rosout=False) as node,
        ):
            yield node, Clock(source)


def test_real_time_and_rate() -> None:
    """now() is the computer's; a rate is no faster than it says; sleep ends early when the node closes."""
    with Master() as master, Node("/n", master_uri=master.uri, rosout=False) as node:
        assert not node.clock.simulated
        before = time.time()
        assert before - 1e-6 <= node.clock.now().to_sec() <= time.time() + 1e-6
        rate, began = node.clock.rate(100), time.monotonic()
        for _ in range(5):
            assert rate.sleep()
        assert time.monotonic() - began > 0.03
        woken: list[bool] = []
        sleeper = threading.Thread(target=lambda: woken.append(node.clock.sleep(30)))
        sleeper.start()
        node.close()
        sleeper.join(20)
        assert woken == [False]


def test_simulated_time_is_zero_first_and_follows_clock(simulated: tuple[Node, Clock]) -> None:
    """The node subscribes /clock exactly when /use_sim_time is true."""
    node, clock = simulated
    assert node.clock.simulated
    assert node.clock.now() == Time(0)
    clock.tell(12.5)
    assert node.clock.wait_for_time(20)
    assert node.clock.now() == Time(12, 500_000_000)


def test_sleepers_wake_in_simulated_time_and_on_a_jump_back(simulated: tuple[Node, Clock]) -> None:
    """Ten simulated seconds pass as fast as /clock says; a jump back wakes with False."""
    node, clock = simulated
    clock.tell(100)
    assert node.clock.wait_for_time(20)
    results: list[bool] = []
    asleep = threading.Semaphore(0)
    wait = node.clock._wait

    def counted(done: Callable[[], bool], timeout: float | None) -> bool:
        asleep.release()  # under the lock: the next /clock comes after the look at the present one
        return wait(done, timeout)

    node.clock._wait = counted  # type: ignore[method-assign]

    def sleep() -> None:
        results.append(node.clock.sleep(10))

    first = threading.Thread(target=sleep)
    first.start()
    assert asleep.acquire(timeout=20)
    clock.tell(105)
    eventually(lambda: node.clock.now().secs == 105)
    assert results == []
    clock.tell(110.5)
    first.join(20)
    assert results == [True]
    jumps: list[int] = []
    node.clock.on_jump(lambda: jumps.append(1))
    second = threading.Thread(target=sleep)
    second.start()
    assert asleep.acquire(timeout=20)
    clock.tell(3)
    second.join(20)
    assert results == [True, False]
    assert jumps == [1]


def test_timers(simulated: tuple[Node, Clock]) -> None:
    """One call per simulated period, a one-shot once; an exception does not end a timer."""
    node, clock = simulated
    clock.tell(10)
    assert node.clock.wait_for_time(20)
    calls: list[int] = []
    once: list[int] = []

    def callback(event: Any) -> None:
        calls.append(event.current_expected.secs)
        raise ValueError("logged")

    timer = node.clock.timer(1.0, callback)
    node.clock.timer(1.0, lambda event: once.append(event.current_real.secs), oneshot=True)
    for second in (11, 12, 13):
        clock.tell(second)
        eventually(lambda second=second: calls[-1:] == [second] and once)  # each has its thread
    timer.close()
    clock.tell(20)
    eventually(lambda: node.clock.now().secs == 20)
    assert calls == [11, 12, 13]
    assert once == [11]


def test_a_clock_knows_whether_its_node_is_open() -> None:
    """Neither before a node has it; then one of the two."""
    bare = NodeClock()
    assert (bare.running, bare.over) == (False, False)
    with Master() as master, Node("/n", master_uri=master.uri, rosout=False) as node:
        assert (node.clock.running, node.clock.over) == (True, False)
    assert (node.clock.running, node.clock.over) == (False, True)


def test_time_in_nanoseconds(simulated: tuple[Node, Clock]) -> None:
    node, clock = simulated
    assert node.clock.now_nsec() == 0
    clock.tell(12.5)
    eventually(lambda: node.clock.now_nsec() == 12_500_000_000, 5.0)
    real = NodeClock()
    assert abs(real.now_nsec() - time.time_ns()) < 5_000_000_000


def test_sleeping_until_a_moment_can_be_stopped(simulated: tuple[Node, Clock]) -> None:
    """In real time at once, in simulated time with the next look; a moment that has passed is no wait."""
    node, clock = simulated
    clock.tell(10.0)
    eventually(lambda: node.clock.now_nsec() > 0, 5.0)
    stop = threading.Event()
    assert node.clock.sleep_until_nsec(9_000_000_000, stop)
    stop.set()
    assert not node.clock.sleep_until_nsec(3600_000_000_000, stop)
    real = NodeClock()
    assert not real.sleep_until_nsec(real.now_nsec() + 3600_000_000_000, stop)
    assert real.sleep_until_nsec(real.now_nsec() - 1)


def test_a_timer_tells_of_the_call_before() -> None:
    """Nothing with the first; then when it should have been, when it was, and how long it took."""
    events: list[TimerEvent] = []
    enough = threading.Event()

    def call(event: TimerEvent) -> None:
        events.append(event)
        if len(events) == 2:
            enough.set()

    with (
        Master() as master,
        Node("/n", master_uri=master.uri, rosout=False) as node,
        node.clock.timer(0.02, call),
    ):
        assert enough.wait(5)
    first, second = events[:2]
    assert (first.last_expected, first.last_real, first.last_duration) == (None, None, None)
    assert (second.last_expected, second.last_real) == (first.current_expected, first.current_real)
    assert second.last_duration is not None
    assert second.last_duration >= 0.0
