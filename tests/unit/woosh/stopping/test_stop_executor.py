"""The thread in which motion is stopped: what is handed over is done once, whatever interrupts who waits for it."""

from __future__ import annotations

import gc
import signal
import threading
import time

import pytest

from woosh_pure.stopping.stop_executor import Job, StopExecutor, begin


@pytest.fixture(autouse=True)
def no_collection():
    """An interrupt that Python raises in a callback of its garbage collector is lost there: printed, and ignored.

    hypothesis has such a callback in every process that imports it: with one, 5 of 200 interrupts were lost.
    """
    gc.disable()
    yield
    gc.enable()


@pytest.fixture
def executor():
    kept = StopExecutor()
    kept.start()
    yield kept
    kept.end()


def test_what_it_does_is_returned_and_what_it_raises_is_raised(executor):
    assert executor.do(lambda: threading.current_thread().name, 5.0) == "woosh:stop"
    with pytest.raises(ZeroDivisionError):
        executor.do(lambda: 1 // 0, 5.0)


def test_elsewhere_than_in_the_main_thread_it_is_a_plain_call(executor):
    seen: list[str] = []
    thread = threading.Thread(
        target=lambda: seen.append(executor.do(lambda: threading.current_thread().name, 1.0))
    )
    thread.start()
    thread.join(5.0)
    assert seen == [thread.name]


def test_interrupts_neither_end_nor_hasten_it_and_are_raised_afterwards(executor):
    """Here from the thread itself, in place of a person who is impatient."""
    done: list[str] = []

    def work() -> None:
        for _ in range(20):
            signal.raise_signal(signal.SIGINT)
            time.sleep(0.005)
        done.append("all of it")

    with pytest.raises(KeyboardInterrupt):
        executor.do(work, 20.0)
    assert done == ["all of it"]


def test_an_interrupt_does_not_hide_what_went_wrong(executor):
    interrupted = threading.Event()

    def interrupt(number, frame):
        interrupted.set()
        raise KeyboardInterrupt

    def work() -> None:
        signal.raise_signal(signal.SIGINT)
        assert interrupted.wait(10.0), "the main thread has not seen the signal"
        raise ValueError("not stopped")

    before = signal.signal(signal.SIGINT, interrupt)
    try:
        with pytest.raises(KeyboardInterrupt) as caught:
            executor.do(work, 20.0)
    finally:
        signal.signal(signal.SIGINT, before)
    assert isinstance(caught.value.__cause__, ValueError)


def test_nobody_waits_longer_than_it_may_take(executor):
    release = threading.Event()
    with pytest.raises(TimeoutError, match=r"not done within 0.05 s"):
        executor.do(lambda: release.wait(20.0), 0.05)
    release.set()


def test_a_job_that_is_begun_twice_is_done_once():
    count: list[int] = []
    job = Job(lambda: count.append(1), 5.0)
    begin(job, "one")
    begin(job, "two")
    assert job.join() is None
    assert count == [1]


def test_where_no_thread_can_be_started_it_is_done_here(monkeypatch):
    """At the end of a program, from CPython 3.12 on."""

    def refuse(_):
        raise RuntimeError("can't create new thread at interpreter shutdown")

    monkeypatch.setattr(threading.Thread, "start", refuse)
    job = Job(lambda: threading.current_thread(), 5.0)
    begin(job, "one")
    assert job.result() is threading.current_thread()


def test_before_it_has_started_and_after_its_end_things_are_done_all_the_same():
    executor = StopExecutor()
    assert executor.do(lambda: "before", 5.0) == "before"
    executor.start()
    executor.end()
    assert executor.do(lambda: "after", 5.0) == "after"
    executor.hold(Job(lambda: None, 60.0))  # nobody will ever do it: not waited for


def test_a_fork_has_a_keeper_of_no_thread_and_waits_for_none(executor, monkeypatch):
    """What its parent has started does not run there."""
    monkeypatch.setattr("woosh_pure.stopping.stop_executor.os.getpid", lambda: -1)
    monkeypatch.setattr(executor, "put", lambda job: pytest.fail("nobody would do it"))
    assert executor.do(lambda: "done", 5.0) == "done"
    executor.hold(Job(lambda: None, 60.0))
