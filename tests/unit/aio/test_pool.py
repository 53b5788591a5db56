"""Blocking calls of asyncio programs: threads are shared, bounded, and notified of cancellation."""

from __future__ import annotations

import asyncio
import threading

import pytest

from rosproto.aio.pool import Pool


def test_a_result_and_an_exception_come_back():
    async def main() -> None:
        pool = Pool(2)
        assert await pool.run(lambda: 42) == 42
        with pytest.raises(ZeroDivisionError):
            await pool.run(lambda: 1 / 0)

    asyncio.run(main())


def test_calls_that_follow_each_other_use_the_same_threads():
    async def main() -> set[int]:
        pool = Pool(8)
        return {await pool.run(threading.get_ident) for _ in range(20)}

    assert len(asyncio.run(main())) == 1


def test_no_more_threads_than_allowed_run_at_a_time():
    async def main() -> int:
        pool, lock, running, most = Pool(3), threading.Lock(), [0], [0]
        gate = threading.Event()

        def work() -> None:
            with lock:
                running[0] += 1
                most[0] = max(most[0], running[0])
                if running[0] == 3:
                    gate.set()
            gate.wait(20)
            with lock:
                running[0] -= 1

        await asyncio.gather(*(pool.run(work) for _ in range(12)))
        return most[0]

    assert asyncio.run(main()) == 3


def test_cancelling_the_task_tells_the_call():
    async def main() -> bool:
        pool, told, started = Pool(1), threading.Event(), threading.Event()

        def block() -> None:
            started.set()
            told.wait(20)

        task = asyncio.create_task(pool.run(block, cancel=told.set))
        while not started.is_set():
            await asyncio.sleep(0)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        return told.is_set()

    assert asyncio.run(main())


def test_what_was_cancelled_before_it_began_is_not_called():
    async def main() -> list[str]:
        pool, gate, called = Pool(1), threading.Event(), []
        first = asyncio.create_task(pool.run(lambda: gate.wait(20)))
        second = asyncio.create_task(pool.run(lambda: called.append("second")))
        await asyncio.sleep(0)
        second.cancel()
        await asyncio.sleep(0)
        gate.set()
        await first
        await pool.run(lambda: called.append("third"))
        return called

    assert asyncio.run(main()) == ["third"]


def test_a_closed_pool_keeps_no_idle_thread_but_still_works():
    pool = Pool(1, idle_seconds=1000, name="close-test")

    async def main() -> None:
        await pool.run(lambda: None)
        pool.close()
        assert await pool.run(lambda: 5) == 5

    asyncio.run(main())
    assert_ended("close-test")
    assert asyncio.run(pool.run(lambda: 6)) == 6  # in a new thread, since none counts as there


def assert_ended(name: str) -> None:
    """The threads of a pool end by themselves."""
    for thread in threading.enumerate():
        if thread.name == name:
            thread.join(20)
            assert not thread.is_alive()


def test_an_idle_thread_ends():
    pool = Pool(1, idle_seconds=0.01, name="idle-test")
    asyncio.run(pool.run(lambda: None))
    assert_ended("idle-test")
    assert asyncio.run(pool.run(lambda: 5)) == 5


def test_what_was_opened_for_a_cancelled_task_is_closed_again():
    async def main() -> list[str]:
        pool, gate, started, closed = Pool(2), threading.Event(), threading.Event(), []
        done = threading.Event()

        def opens() -> str:
            started.set()
            gate.wait(20)
            return "link"

        def dispose(opened: str) -> None:
            closed.append(opened)
            done.set()

        task = asyncio.create_task(pool.run(opens, dispose=dispose))
        while not started.is_set():
            await asyncio.sleep(0)
        task.cancel()
        await asyncio.sleep(0)
        gate.set()
        await pool.run(lambda: done.wait(20))
        return closed

    assert asyncio.run(main()) == ["link"]
