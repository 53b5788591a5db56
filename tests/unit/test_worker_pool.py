"""Helper threads: every task is done once, errors reach who asks, and no thread stays."""

from __future__ import annotations

import threading
import weakref
from time import monotonic

import pytest

from rosproto.worker_pool import WorkerPool, worker_count
from tests.support.waiting import until


def threads(name: str) -> int:
    return sum(thread.name == name for thread in threading.enumerate())


@pytest.mark.parametrize("most", [1, 3])
def test_every_task_is_done_once_and_gives_its_result(most):
    helpers = WorkerPool("helpers results", most, daemon=True)
    ran: list[int] = []
    tasks = [helpers.add(lambda i=i: (ran.append(i), i * i)[1]) for i in range(50)]
    assert [task.result(10) for task in tasks] == [i * i for i in range(50)]
    assert sorted(ran) == list(range(50))


def test_an_error_is_raised_where_the_result_is_asked_for():
    helpers = WorkerPool("helpers errors", 1, daemon=True)

    def fails() -> None:
        raise ValueError("no good")

    task = helpers.add(fails)
    after = helpers.add(lambda: "fine")
    for _ in range(2):
        with pytest.raises(ValueError, match="no good"):
            task.result(10)
    assert after.result(10) == "fine"


def test_threads_end_by_themselves_and_come_back():
    helpers = WorkerPool("helpers ends", 2, daemon=False)
    for _ in range(2):
        tasks = [helpers.add(lambda: None) for _ in range(10)]
        for task in tasks:
            task.result(10)
        until(lambda: not threads("helpers ends"), what="the end of the threads")


def test_never_more_threads_than_allowed():
    helpers = WorkerPool("helpers most", 2, daemon=True)
    go = threading.Event()
    tasks = [helpers.add(lambda: go.wait(10)) for _ in range(6)]
    assert threads("helpers most") == 2
    go.set()
    assert all(task.result(10) for task in tasks)


def test_without_threads_to_be_had_the_caller_does_it(monkeypatch):
    def refuse(self: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", refuse)
    helpers = WorkerPool("helpers none", 2, daemon=True, in_caller=True)
    for _ in range(3):
        assert helpers.add(threading.get_ident).result(0) == threading.get_ident()


def test_helpers_are_for_the_processors_of_the_process(monkeypatch):
    import os

    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0}, raising=False)
    assert worker_count() == 1
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(64)), raising=False)
    assert worker_count() == 3
    monkeypatch.delattr(os, "sched_getaffinity")
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    assert worker_count() == 2
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert worker_count() == 1


def test_work_that_is_due_later_runs_in_the_order_of_its_time_on_one_thread(monkeypatch):
    now = [0.0]
    monkeypatch.setattr("rosproto.worker_pool.monotonic", lambda: now[0])
    helpers = WorkerPool("helpers later", 8, daemon=True, gradual=True)
    ran: list[float] = []
    due = {s: helpers.add_later(s, lambda s=s: ran.append(s)) for s in (0.06, 0.02, 0.04)}
    dropped = helpers.add_later(0.03, lambda: ran.append(0.03))
    assert dropped.cancel()
    assert threads("helpers later") == 1
    for now[0] in (0.02, 0.04, 0.06):
        due[now[0]].result(10)
        assert ran[-1] == now[0]
    assert ran == [0.02, 0.04, 0.06]

    def ended() -> bool:
        now[0] += 1.0  # the thread may have looked at the clock just before
        return not threads("helpers later")

    until(ended, what="the end of the thread")


def test_a_thread_stays_for_work_that_is_due_after_the_idle_time():
    helpers = WorkerPool("helpers stays", 8, daemon=True, idle_seconds=0.01, gradual=True)
    assert helpers.add_later(0.1, lambda: "done").result(10) == "done"


def test_work_that_is_due_is_not_delayed_by_a_task_that_waits():
    helpers = WorkerPool("helpers busy", 8, daemon=True, gradual=True)
    go = threading.Event()
    slow = [helpers.add(lambda: go.wait(10)) for _ in range(3)]
    assert helpers.add_later(0.02, lambda: "on time").result(5) == "on time"
    assert helpers.add(lambda: "at once").result(60) == "at once"
    go.set()
    assert all(task.result(10) for task in slow)


def test_quick_tasks_that_come_at_once_share_threads(monkeypatch):
    """As long as the first thread has not taken its task, no other one is started."""
    helpers = WorkerPool("helpers few", 1000, daemon=True, idle_seconds=5.0, gradual=True)
    start, begun = threading.Thread.start, []
    with monkeypatch.context() as patch:
        patch.setattr(threading.Thread, "start", lambda thread: begun.append(thread))
        tasks = [helpers.add(lambda n=n: n) for n in range(50)]
    assert len(begun) == 1
    start(begun[0])
    assert [task.result(10) for task in tasks] == list(range(50))
    helpers.close()


@pytest.mark.parametrize("gradual", [True, False])
def test_work_is_added_while_a_thread_is_being_started(monkeypatch, gradual):
    """On a busy computer that takes a while; an event loop that adds work must not wait for it."""
    helpers = WorkerPool("helpers slow", 8, daemon=True, gradual=gradual)
    start, starting, go = threading.Thread.start, threading.Event(), threading.Event()

    def slow(thread: threading.Thread) -> None:
        if thread.name == "helpers slow" and not starting.is_set():
            starting.set()
            go.wait(60)
        start(thread)

    monkeypatch.setattr(threading.Thread, "start", slow)
    first = threading.Thread(target=helpers.add, args=(lambda: 1,))
    second = threading.Thread(target=helpers.add, args=(lambda: 2,))
    first.start()
    assert starting.wait(20)
    second.start()
    second.join(20)
    added = not second.is_alive()
    go.set()
    assert added
    assert helpers.add(lambda: 3).result(20) == 3
    first.join(20)


@pytest.mark.parametrize("gradual", [True, False])
def test_work_that_relies_on_a_thread_that_cannot_be_started_fails(monkeypatch, gradual):
    helpers = WorkerPool("helpers refused", 1, daemon=True, gradual=gradual)
    start, starting, go = threading.Thread.start, threading.Event(), threading.Event()
    added, heard = threading.Event(), list[str]()

    def refuse(thread: threading.Thread) -> None:
        if thread.name != "helpers refused":
            return start(thread)
        starting.set()
        go.wait(60)
        raise RuntimeError("can't start new thread")

    def add() -> None:
        try:
            task = helpers.add(lambda: 1)
            added.set()
            task.result(20)
        except RuntimeError as problem:
            heard.append(str(problem))

    both = [threading.Thread(target=add) for _ in range(2)]
    with monkeypatch.context() as patch:
        patch.setattr(threading.Thread, "start", refuse)
        both[0].start()
        assert starting.wait(20)
        both[1].start()
        assert added.wait(20)
        go.set()
        for thread in both:
            thread.join(30)
    assert heard == ["can't start new thread"] * 2
    assert helpers.add(lambda: 3).result(20) == 3


def test_closing_waits_for_a_thread_that_is_being_started(monkeypatch):
    helpers = WorkerPool("helpers late", 1, daemon=True, gradual=True)
    start, starting, go = threading.Thread.start, threading.Event(), threading.Event()

    def slow(thread: threading.Thread) -> None:
        if thread.name == "helpers late":
            starting.set()
            go.wait(60)
        start(thread)

    monkeypatch.setattr(threading.Thread, "start", slow)
    adding = threading.Thread(target=helpers.add, args=(lambda: 1,))
    adding.start()
    assert starting.wait(20)
    helpers.close()
    closing = threading.Thread(target=helpers.join, args=(60,))
    closing.start()
    closing.join(0.05)
    assert closing.is_alive()
    go.set()
    closing.join(20)
    assert not closing.is_alive()
    assert not threads("helpers late")
    adding.join(20)


def test_two_urgent_tasks_at_once_wait_for_no_thread():
    helpers = WorkerPool("helpers urgent", 1, daemon=True, gradual=True)
    go = threading.Event()
    busy = helpers.add(lambda: go.wait(60))
    both = threading.Barrier(2)
    urgent = [helpers.add(lambda: both.wait(20), urgent=True) for _ in range(2)]
    assert sorted(task.result(30) for task in urgent) == [0, 1]
    go.set()
    assert busy.result(10)


def test_cancelled_tasks_that_were_due_later_are_not_kept():
    helpers = WorkerPool("helpers swept", 1, daemon=True)
    kept = [weakref.ref(helpers.add_later(3600, lambda: None)) for _ in range(2000)]
    for reference in kept:
        task = reference()
        assert task is not None
        task.cancel()
    del task
    for _ in range(2000):
        helpers.add_later(3600, lambda: None).cancel()
    assert sum(reference() is not None for reference in kept) < 600
    helpers.close()


def test_the_threads_of_a_closed_pool_can_be_waited_for():
    helpers = WorkerPool("helpers joined", 4, daemon=True, idle_seconds=60.0)
    assert helpers.add(lambda: 1).result(10) == 1
    assert threads("helpers joined") == 1
    helpers.close()
    helpers.join(10.0)
    assert threads("helpers joined") == 0


def test_a_task_that_ends_its_pool_does_not_wait_for_itself():
    helpers = WorkerPool("helpers own", 4, daemon=True, idle_seconds=60.0)
    assert helpers.add(lambda: (helpers.close(), helpers.join(30.0))).result(10) == (None, None)


def several_idle(pool: WorkerPool, count: int) -> None:
    """So many threads of the pool that have nothing to do."""
    begun, go = threading.Barrier(count + 1), threading.Event()
    tasks = [pool.add(lambda: (begun.wait(60), go.wait(60))) for _ in range(count)]
    begun.wait(60)
    go.set()
    for task in tasks:
        task.result(60)


def test_one_thread_waits_for_what_is_due_and_the_others_sleep(monkeypatch):
    pool = WorkerPool("helpers herd", 40, daemon=True, idle_seconds=60.0, gradual=True)
    several_idle(pool, 20)
    done: list[int] = []
    awake: set[tuple[int, int]] = set()  # a thread that looks again because a coarse clock stands counts once

    def now() -> float:
        awake.add((threading.get_ident(), len(done)))
        return monotonic()

    monkeypatch.setattr("rosproto.worker_pool.monotonic", now)
    tasks = [pool.add_later(0.01 * n, lambda n=n: done.append(n)) for n in range(50)]
    for task in tasks:
        task.result(60)
    pool.close()
    pool.join(60)
    assert len(awake) < 50 * 4, "for each task two threads wake: that which does it, and the next that waits"


def test_what_is_due_earlier_is_done_in_time_whoever_waits_already():
    pool = WorkerPool("helpers earlier", 20, daemon=True, idle_seconds=30.0, gradual=True)
    several_idle(pool, 5)
    late = [pool.add_later(600.0 - n, lambda: None) for n in range(10)]
    for _ in range(20):
        assert pool.add_later(0.01, lambda: "in time").result(60) == "in time"
        assert pool.add(lambda: "at once").result(60) == "at once"
    assert not any(task.done() for task in late)
    pool.close()
    pool.join(10)
    assert not threads("helpers earlier")
