"""The queue from threads to the loop: order, limit, waiting, cancellation."""

from __future__ import annotations

import asyncio
import threading

import pytest

from rosproto.aio.mailbox import Closed, Mailbox


def test_items_of_a_thread_arrive_in_order():
    async def main() -> list[int]:
        box: Mailbox[int] = Mailbox(0)
        thread = threading.Thread(target=lambda: [box.put(n) for n in range(1000)])
        thread.start()
        got = [await box.get(5) for _ in range(1000)]
        thread.join()
        return got

    assert asyncio.run(main()) == list(range(1000))


def test_the_oldest_is_dropped_and_counted_when_full():
    async def main() -> tuple[list[int], int]:
        box: Mailbox[int] = Mailbox(2)
        for n in range(5):
            box.put(n)
        return [await box.get(5), await box.get(5)], box.dropped

    assert asyncio.run(main()) == ([3, 4], 3)


def test_waiting_in_vain_times_out_and_loses_nothing():
    async def main() -> int:
        box: Mailbox[int] = Mailbox(2)
        with pytest.raises(asyncio.TimeoutError):
            await box.get(0.01)
        box.put(7)
        return await box.get(5)

    assert asyncio.run(main()) == 7


def test_closing_ends_those_who_wait_after_what_has_arrived():
    async def main() -> int:
        box: Mailbox[int] = Mailbox(2)
        waiting = asyncio.create_task(box.get())
        await asyncio.sleep(0)
        box.close()
        with pytest.raises(Closed):
            await waiting
        box.put(1)  # too late
        full: Mailbox[int] = Mailbox(2)
        full.put(5)
        full.close()
        last = await full.get()
        with pytest.raises(Closed):
            await full.get()
        return last

    assert asyncio.run(main()) == 5


def test_an_item_meant_for_a_cancelled_waiter_goes_to_the_next():
    async def main() -> int:
        box: Mailbox[int] = Mailbox(2)
        first, second = asyncio.create_task(box.get()), asyncio.create_task(box.get())
        await asyncio.sleep(0)
        box.put(1)
        await asyncio.sleep(0)  # the first waiter is woken here
        first.cancel()
        return await asyncio.wait_for(second, 5)

    try:
        assert asyncio.run(main()) == 1
    except asyncio.TimeoutError:
        pytest.fail("the item was lost with the cancelled waiter")


def test_every_item_reaches_one_of_many_waiters():
    async def main() -> list[int]:
        box: Mailbox[int] = Mailbox(0)
        tasks = [asyncio.create_task(box.get(5)) for _ in range(20)]
        await asyncio.sleep(0)
        for n in range(20):
            box.put(n)
        return sorted(await asyncio.gather(*tasks))

    assert asyncio.run(main()) == list(range(20))


def test_a_closed_loop_does_not_hurt_the_thread():
    async def main() -> Mailbox[int]:
        return Mailbox(2)

    box = asyncio.run(main())
    box.put(1)
    box.close()
