"""Cancelled at any moment, nothing stays open: a begun opening is in the caller's hands or closed again, and a
begun closing completes.

A larger storm by command: `python -m tests.unit.aio.test_cancel_storm 1000`.
"""

from __future__ import annotations

import asyncio
import os
import random
import sys
import threading
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest

from rosproto import aio
from rosproto.aio.pool import Pool
from rosproto.codec import message_class, service_class
from rosproto.errors import RosError
from rosproto.master import Master
from rosproto.node import MasterClient

String = message_class("std_msgs/String")
SetBool = service_class("std_srvs/SetBool")
ACTION = "actionlib/Test"
FILES = Path("/proc/self/fd")
TRIALS = 40


class Thing:
    """Something that is opened and closed in a thread."""

    open: int = 0

    def __init__(self) -> None:
        type(self).open += 1
        self.closed = False

    def close(self) -> None:
        if not self.closed:
            self.closed = True
            type(self).open -= 1


def settled(condition: Callable[[], bool], seconds: float = 20.0) -> bool:
    """Whether it holds in time: threads end a moment after what they did."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.005)
    return True


def run(main: Awaitable[Any]) -> Any:
    async def bounded() -> Any:
        return await asyncio.wait_for(main, 60)

    return asyncio.run(bounded())


def test_what_is_opened_in_the_turn_of_the_cancel_is_closed_again():
    """The result has arrived, the task has not run yet, and is cancelled: that result was lost before."""

    class Link(Thing):
        open = 0

    async def main() -> None:
        pool = Pool(2)
        for _ in range(20):
            loop, told = asyncio.get_running_loop(), threading.Event()

            async def opens() -> Link:
                return await pool.run(Link, dispose=Link.close)

            task = asyncio.create_task(opens())
            await asyncio.sleep(0)
            assert settled(lambda: Link.open == 1)  # this holds the loop: the result waits for its turn
            loop.call_soon(lambda task=task, told=told: (task.cancel(), told.set()))
            with pytest.raises(asyncio.CancelledError):
                await task
            assert told.is_set()
            assert settled(lambda: Link.open == 0)

    run(main())


def test_a_closing_that_is_cancelled_before_it_began_is_carried_out():
    """Also when every thread is busy: what ends something waits for nobody."""

    async def main() -> list[str]:
        pool, gate, closed = Pool(1), threading.Event(), []
        busy = asyncio.create_task(pool.run(lambda: gate.wait(20)))
        closing = asyncio.create_task(pool.run(lambda: closed.append("closed"), always=True))
        await asyncio.sleep(0)
        closing.cancel()
        with pytest.raises(asyncio.CancelledError):
            await closing
        seen = list(closed)
        gate.set()
        await busy
        return seen

    assert run(main()) == ["closed"]


def test_a_task_that_is_cancelled_again_and_again_waits_for_its_closing():
    async def main() -> bool:
        pool, gate, closed = Pool(1), threading.Event(), threading.Event()
        closing = asyncio.create_task(pool.run(lambda: (gate.wait(20), closed.set()), always=True))
        for _ in range(10):
            await asyncio.sleep(0)
            closing.cancel()
        assert not closing.done()
        gate.set()
        with pytest.raises(asyncio.CancelledError):
            await closing
        return closed.is_set()

    assert run(main())


def test_a_closing_that_fails_and_is_cancelled_tells_both():
    async def main() -> BaseException | None:
        pool, started = Pool(1), threading.Event()

        def fails() -> None:
            started.set()
            raise OSError("gone")

        closing = asyncio.create_task(pool.run(fails, always=True))
        await asyncio.sleep(0)
        assert started.wait(20)
        closing.cancel()
        with pytest.raises(asyncio.CancelledError) as cancelled:
            await closing
        error: BaseException | None = cancelled.value
        while error is not None and not isinstance(error, OSError):
            error = error.__cause__ or error.__context__  # Python 3.10 raises another CancelledError here
        return error

    assert isinstance(run(main()), OSError)


def test_what_is_opened_for_a_loop_that_is_closed_is_closed_again():
    """A loop that ends without cancelling its tasks, as after `run_until_complete`."""

    class Link(Thing):
        open = 0
        made = 0

        def __init__(self) -> None:
            super().__init__()
            Link.made += 1

    pool, gate, begun = Pool(1), threading.Event(), threading.Event()

    def opens() -> Link:
        begun.set()
        gate.wait(20)
        return Link()

    loop = asyncio.new_event_loop()
    loop.set_exception_handler(lambda *_: None)  # of the task that is not cancelled
    task = loop.create_task(pool.run(opens, dispose=Link.close))
    loop.run_until_complete(asyncio.sleep(0))
    assert begun.wait(20)
    loop.close()
    gate.set()
    asyncio.run(pool.run(lambda: None))  # by the same thread, afterwards
    assert (Link.made, Link.open) == (1, 0)
    assert not task.done()


def test_two_tasks_that_open_a_node_get_the_same():
    async def main(uri: str) -> None:
        node = aio.Node("twice", master_uri=uri, rosout=False)

        async def opens() -> object:
            return (await node).node

        one, other = await asyncio.gather(opens(), opens())
        assert one is other
        await node.close()

    with Master() as master:
        run(main(master.uri))


def test_a_node_closed_while_it_is_opened_is_not_left_open():
    async def main(uri: str) -> None:
        node = aio.Node("hasty", master_uri=uri, rosout=False)

        async def opens() -> aio.Node:
            return await node

        task = asyncio.create_task(opens())
        await asyncio.sleep(0)
        await node.close()
        with pytest.raises(RosError, match="while it was being opened"):
            await task

    with Master() as master:
        run(main(master.uri))
        assert settled(lambda: not registered(master.uri))


def registered(uri: str) -> list[str]:
    """What the master knows, and of whom."""
    with MasterClient(uri, "/watch") as master:
        state = master.get_system_state()
    parts = {"publisher": state.publishers, "subscriber": state.subscribers, "service": state.services}
    return [
        f"{kind} {topic} of {node}"
        for kind, part in parts.items()
        for topic, nodes in part.items()
        for node in nodes
    ]


# -- the storm -----------------------------------------------------------------------------------------------


async def live(uri: str, draw: random.Random) -> None:
    """Open a node and some of what there is, use it, and close it: cancelled somewhere in this."""

    async def answer(request: Any) -> Any:
        await asyncio.sleep(0)
        return True, ""

    async with aio.Node("storm", master_uri=uri, anonymous=True, rosout=False) as node:
        kinds = [
            lambda: node.subscriber("/chat", String),
            lambda: node.publisher("/chat", String),
            lambda: node.service_client("/door", SetBool, persistent=True),
            lambda: node.service_server("/door", SetBool, answer),
            lambda: node.action_client("/act", ACTION),
            lambda: node.action_server("/act", ACTION, answer),
            lambda: node.params.subscribe("/speed"),
        ]
        draw.shuffle(kinds)
        for kind in kinds[:4]:
            if draw.random() < 0.5:
                async with kind():
                    await asyncio.sleep(0)
            else:
                await kind()


async def storm(uri: str, trials: int, seed: int) -> int:
    """Number of trials that were cancelled."""
    draw, cancelled = random.Random(seed), 0
    for _ in range(trials):
        task = asyncio.create_task(live(uri, random.Random(draw.random())))
        end = time.monotonic() + draw.uniform(0.0, 0.06)
        while time.monotonic() < end and not task.done():
            await asyncio.sleep(0)
        for _ in range(draw.choice((1, 1, 2, 5))):
            task.cancel()
            await asyncio.sleep(draw.choice((0.0, 0.0, 0.003)))
        try:
            await task
        except asyncio.CancelledError:
            cancelled += 1
    return cancelled


def leftovers(uri: str, files: int, threads: set[threading.Thread]) -> str:
    """What is still there after all was closed, in words; "" when nothing is."""
    names: list[str] = []

    def clean() -> bool:
        names[:] = [
            *(f"thread {t.name}" for t in threading.enumerate() if t not in threads),
            *(f"registration {name}" for name in registered(uri)),
        ]
        more = open_files() - files
        if more > 0:
            names.append(f"{more} open files")
        return not names

    return "" if settled(clean, 30.0) else "; ".join(names)


def open_files() -> int:
    return len(os.listdir(FILES)) if FILES.exists() else 0


def trial(trials: int, seed: int) -> tuple[int, str]:
    """Number of cancelled trials, and what they have left."""
    with Master() as master:
        run(live(master.uri, random.Random(0)))  # whatever is opened once per process is open now
        files, threads = open_files(), set(threading.enumerate())
        cancelled = asyncio.run(storm(master.uri, trials, seed))
        return cancelled, leftovers(master.uri, files, threads)


@pytest.mark.whole
def test_a_storm_of_cancels_leaves_nothing_open():
    """Nodes, topics, services, actions and parameters, cancelled while they are opened, used and closed."""
    cancelled, left = trial(TRIALS, random.randrange(1 << 30))
    assert not left
    assert cancelled > TRIALS // 4


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    done, rest = trial(count, 1)
    print(f"{count} trials, {done} cancelled; left: {rest or 'nothing'}")
    sys.exit(bool(rest))
