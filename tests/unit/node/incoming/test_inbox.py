"""Inbox and callbacks: what a slow program sees."""

from __future__ import annotations

import threading
from collections.abc import Callable
from time import perf_counter, thread_time

import pytest

from rosproto.node.incoming import subscriber_queue
from rosproto.node.incoming.subscriber_queue import SLOW_CALL, SURELY_SLOW, CallbackRunner, Inbox


@pytest.fixture(autouse=True)
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """A callback's thread that waits for a test on a busy computer does not end because nothing arrives."""
    monkeypatch.setattr(subscriber_queue, "IDLE_WAIT", 60.0)


def test_the_newest_is_kept() -> None:
    """size=1 holds the newest message; the others are counted."""
    inbox = Inbox(1)
    inbox.put([1, 2, 3], 0.5)
    inbox.put([4], 0.6)
    assert inbox.latest == 4
    assert inbox.get(0) == (4, 0.6)
    assert inbox.get(0) is None
    assert (inbox.received, inbox.dropped) == (4, 3)


def test_a_waiting_program_is_woken_by_a_message_and_by_close() -> None:
    """`get` ends with the message, or with None when the inbox is closed."""
    inbox = Inbox(5)
    got: list[object] = []
    thread = threading.Thread(target=lambda: got.extend([inbox.get(10), inbox.get(10)]))
    thread.start()
    inbox.put(["a"], 1.0)
    while not got and thread.is_alive() and len(inbox):
        pass
    inbox.close()
    thread.join(20)
    assert got == [("a", 1.0), None]


def test_a_quick_callback_runs_in_the_callers_thread() -> None:
    """No hand-over: the thread that received calls, in order, and nothing is dropped."""
    seen: list[tuple[int, int]] = []
    runner = CallbackRunner(lambda n: seen.append((n, threading.get_ident())), Inbox(1), "/t")
    runner.offer(list(range(100)), 0.0)
    assert seen == [(n, threading.get_ident()) for n in range(100)]
    assert runner.takes_all


def test_a_slow_callback_gets_a_thread_and_sees_the_newest() -> None:
    """After one slow call the receiving thread is free again; in between only the newest is kept."""
    inbox = Inbox(1)
    gate, entered, finished = threading.Event(), threading.Event(), threading.Event()
    seen: list[int] = []

    def callback(n: int) -> None:
        seen.append(n)
        if n == 0:
            threading.Event().wait(SURELY_SLOW * 1.2)
        elif n == 1:
            entered.set()
            gate.wait(20)
        else:
            finished.set()

    runner = CallbackRunner(callback, inbox, "/t")
    runner.offer([0], 0.0)
    assert not runner.takes_all
    runner.offer([1], 0.0)
    assert entered.wait(20)
    for n in range(2, 100):
        runner.offer([n], 0.0)  # does not wait for the callback
    gate.set()
    assert finished.wait(20)
    inbox.close()
    assert seen == [0, 1, 99]


def _sleep(seconds: float) -> None:
    threading.Event().wait(seconds)


def _wait_for_a_lock(seconds: float) -> None:
    lock = threading.Lock()
    lock.acquire()
    timer = threading.Timer(seconds, lock.release)
    timer.start()
    assert lock.acquire(timeout=20)
    timer.join(20)


def _compute(seconds: float) -> None:
    """Also by the clock that tells slow calls: a thread's own time advances by 10 ms at once on some systems."""
    end, end_of_thread = perf_counter() + seconds, thread_time() + seconds
    while perf_counter() < end or thread_time() < end_of_thread:
        pass


@pytest.mark.parametrize("takes_long", [_sleep, _wait_for_a_lock, _compute])
def test_whatever_makes_a_callback_slow_it_gets_a_thread(takes_long: Callable[[float], None]) -> None:
    """Slow time after time, but never surely slow at once: the receiving thread goes on, the newest is called."""
    inbox = Inbox(1)
    gate, entered, finished = threading.Event(), threading.Event(), threading.Event()
    returned = threading.Semaphore(0)  # on a busy computer the first call may be surely slow
    seen: list[int] = []

    def callback(n: int) -> None:
        seen.append(n)
        if n < 2:
            takes_long(SLOW_CALL * 3)
            returned.release()
        elif n == 2:
            entered.set()
            gate.wait(20)
        else:
            finished.set()

    runner = CallbackRunner(callback, inbox, "/t")
    for n in range(2):
        runner.offer_one(n)
        assert returned.acquire(timeout=20)
    assert not runner.takes_all
    runner.offer_one(2)
    assert entered.wait(20)
    for n in range(3, 100):
        runner.offer_one(n)  # does not wait for the callback
    gate.set()
    assert finished.wait(20)
    inbox.close()
    assert seen == [0, 1, 2, 99]


def test_one_call_that_took_long_proves_nothing_and_two_in_a_row_do(monkeypatch: pytest.MonkeyPatch) -> None:
    """A busy computer interrupts a quick callback now and then; a slow one takes long each time."""
    inbox, now = Inbox(10), [0.0]
    monkeypatch.setattr(subscriber_queue, "perf_counter", lambda: now[0])
    takes_long: list[bool] = [True, False, True, True]
    called = threading.Semaphore(0)

    def callback(n: int) -> None:
        now[0] += SLOW_CALL * 3 if takes_long[n] else 0.0
        called.release()

    for offer in (lambda runner, n: runner.offer_one(n), lambda runner, n: runner.offer([n], 0.0)):
        runner = CallbackRunner(callback, inbox, "/t")
        found = []
        for n in range(len(takes_long)):
            offer(runner, n)
            assert called.acquire(timeout=20)
            found.append(not runner.takes_all)
        assert found == [False, False, False, True]
    inbox.close()


def test_a_callback_that_became_quick_takes_over_many_messages_at_once() -> None:
    """All of them, in order; a slow one takes them one by one, so that old ones can be dropped behind it."""
    inbox = Inbox(1000)
    gate, entered, done = threading.Event(), threading.Event(), threading.Event()
    seen: list[int] = []

    def callback(n: int) -> None:
        seen.append(n)
        if n == 0:
            threading.Event().wait(SURELY_SLOW * 1.2)
        elif n == 1:
            entered.set()
            gate.wait(20)
        elif n == 899:
            done.set()

    runner = CallbackRunner(callback, inbox, "/t")
    runner.offer_one(0)
    runner.offer_one(1)
    assert entered.wait(20)
    runner.offer(list(range(2, 900)), 0.0)
    gate.set()
    assert done.wait(20)
    inbox.close()
    assert seen == list(range(900))


def test_one_slow_first_call_does_not_leave_a_thread_for_ever() -> None:
    """An import in the first call: after a few quick ones the receiving thread calls again."""
    inbox = Inbox(10)
    called = threading.Semaphore(0)

    def callback(n: int) -> None:
        if n == 0:
            threading.Event().wait(SURELY_SLOW * 1.2)
        called.release()

    runner = CallbackRunner(callback, inbox, "/slow_first")
    runner.offer_one(0)
    assert called.acquire(timeout=20)
    (thread,) = (each for each in threading.enumerate() if each.name == "rosproto:callback /slow_first")
    for n in range(1, 50):
        runner.offer_one(n)
        assert called.acquire(timeout=20)
        if runner.takes_all:
            break
    thread.join(20)
    assert not thread.is_alive()
    inbox.close()


def test_calls_never_overlap_when_two_links_deliver() -> None:
    """Two receiving threads, one callback at a time."""
    running, most, count = [0], [0], [0]
    lock = threading.Lock()

    def callback(n: int) -> None:
        with lock:
            running[0] += 1
            most[0] = max(most[0], running[0])
        count[0] += 1
        with lock:
            running[0] -= 1

    inbox = Inbox(100_000)
    runner = CallbackRunner(callback, inbox, "/t")
    threads = [
        threading.Thread(target=lambda: [runner.offer([1], 0.0) for _ in range(500)]) for _ in range(2)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(10)
    deadline = threading.Event()
    for _ in range(500):
        if count[0] == 1000:
            break
        deadline.wait(0.01)
    inbox.close()
    assert count[0] == 1000
    assert most[0] == 1


def test_an_exception_in_a_callback_is_logged_and_the_next_message_comes(caplog) -> None:  # type: ignore[no-untyped-def]
    """One bad call does not end anything."""
    seen: list[int] = []

    def callback(n: int) -> None:
        seen.append(n)
        if n == 1:
            raise ValueError("one")

    inbox = Inbox(10)
    runner = CallbackRunner(callback, inbox, "/t")
    runner.offer([1, 2], 0.0)
    runner.offer([3], 0.0)  # in a thread of its own when the logging took long
    for _ in range(500):
        if len(seen) == 3:
            break
        threading.Event().wait(0.01)
    inbox.close()
    assert seen == [1, 2, 3]
    assert "the subscriber continues" in caplog.text
