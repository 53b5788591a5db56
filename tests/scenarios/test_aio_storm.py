"""Tasks cancelled at random moments, in every verb, on a quiet and on a slow network: the robot stands in all of them.

A larger storm by command: `python -m tests.scenarios.test_aio_storm 1000`.
"""

from __future__ import annotations

import asyncio
import logging
import random
import sys
import threading
import time
from collections.abc import Awaitable, Callable
from typing import Any

import pytest

import rosproto
from rosproto.errors import RosError
from woosh_pure import Pose2D, SimulatedChassis, aio
from woosh_pure.enums import NavigationMode
from woosh_pure.motion.steps import Step

pytestmark = pytest.mark.slow

TRIALS = 24
STANDS_WITHIN = 10.0
ROUND = 25
"""Trials with one Chassis; then what is left is looked at, and the next one begins."""


async def drive(robot: aio.Chassis) -> None:
    async with robot.velocity(bypasses_protection=True) as block:
        await block.hold(0.3, seconds=20)


async def in_block(robot: aio.Chassis) -> None:
    async with robot.go_to_mark("A1") as handle:
        async for _ in handle.reports():
            pass


async def with_handle(robot: aio.Chassis) -> None:
    handle = None
    try:
        handle = await robot.go_to_mark("A1").start()
        await handle.wait()
    finally:  # whoever takes the handle holds it: cancelled in `wait` it has ended, and nobody can be between the two
        assert handle is None or handle.done


async def paused(robot: aio.Chassis) -> None:
    async with robot.steps([Step.straight(1.0, 0.5), Step.turn(1.5, 0.8)]) as handle:
        await asyncio.sleep(0.1)
        await handle.pause()
        await handle.resume()
        await handle.wait()


async def watch(robot: aio.Chassis) -> None:
    async for _ in robot.pose:
        pass


VERBS: list[Callable[[aio.Chassis], Awaitable[Any]]] = [
    lambda robot: robot.go_to_mark("A1"),
    lambda robot: robot.park("P1"),
    lambda robot: robot.go_to(3.0, 1.0),
    lambda robot: robot.follow([Pose2D(1.0, 0.0), Pose2D(2.0, 0.0)]),
    lambda robot: robot.move(2.0, speed=0.5),
    lambda robot: robot.rotate(3.0, speed=0.8),
    drive, in_block, with_handle, paused, watch,
    lambda robot: robot.set_navigation_mode(NavigationMode.WAIT_THEN_AVOID, waiting_timeout=5.0),
    lambda robot: robot.get_map(),
    lambda robot: robot.plan(Pose2D(3.0, 1.0)),
    lambda robot: robot.stop(),
    lambda robot: robot.wait_until_ready(),
    lambda robot: robot.snapshot(0.5),
    lambda robot: robot.say("hello"),
    lambda robot: robot.wait_until(lambda status: False),
]  # fmt: skip
MOVING = VERBS[:10]


async def trial(robot: aio.Chassis, draw: random.Random) -> None:
    """Use a verb, cancelled after a while: by hand, again and again, or by a time limit."""
    use = draw.choice(MOVING if draw.random() < 0.7 else VERBS)
    seconds = draw.choice((0.0, draw.uniform(0.0, 0.05), draw.uniform(0.0, 0.3), draw.uniform(0.0, 1.5)))

    async def used() -> None:
        await use(robot)

    try:
        if draw.random() < 0.3:
            await asyncio.wait_for(used(), seconds)
            return
        task = asyncio.create_task(used())
        await asyncio.sleep(seconds)
        for _ in range(draw.choice((1, 1, 2, 8))):
            task.cancel()
            await asyncio.sleep(draw.choice((0.0, 0.003)))
        await task
    except (asyncio.CancelledError, asyncio.TimeoutError):
        pass
    except RosError as error:  # it was quicker than the cancel, and refused
        logging.getLogger("storm").debug("%s", error)


def what_moves(sim: SimulatedChassis) -> str:
    """What is under way on the robot, in words; "" when it stands."""
    servers = [s for s in sim.graph._keep if isinstance(s, rosproto.ActionServer)]
    with sim.lock:
        world = sim.world
        parts = [
            *([] if world.body.velocity.is_standing() else [f"moves {world.body.velocity}"]),
            *([f"task {world.tasks.state}"] if world.tasks.busy else []),
            *([f"motion {world.motion}"] if world.motion else []),
        ]
    return ", ".join([*parts, *(f"goal of {s.name}" for s in servers if s._workers)])


async def standing(sim: SimulatedChassis) -> str:
    """What still moves after the time that it may take; "" when it stands, and goes on standing."""
    end = time.monotonic() + STANDS_WITHIN
    while (what := what_moves(sim)) and time.monotonic() < end:
        await asyncio.sleep(0.01)
    if not what:
        await asyncio.sleep(0.05)
        what = what_moves(sim)
        while what and time.monotonic() < end:  # its own velocity is measured with noise: not for long
            await asyncio.sleep(0.01)
            what = what_moves(sim)
    return what


async def storm(sim: SimulatedChassis, trials: int, delay: float, seed: int) -> list[str]:
    """What was wrong, in words."""
    wrong: list[str] = []
    for first in range(0, trials, ROUND):
        async with aio.Chassis(sim.master_uri) as robot:
            for number in range(first, min(first + ROUND, trials)):
                with sim.lock:
                    sim.world.body.pose = Pose2D(0.0, 0.0)
                sim.slow_network(delay)
                await trial(robot, random.Random(f"{seed} {number}"))
                sim.slow_network(0.0)
                if what := await standing(sim):
                    wrong.append(f"trial {number} of seed {seed}: {what}")
                    await robot.stop(everything=True)
                if robot.under_way:
                    wrong.append(
                        f"trial {number} of seed {seed}: {robot} believes that something is under way"
                    )
    return wrong


OURS = ("woosh aio", "/woosh_pure_", "woosh:")
"""In the names of our threads. The robot's are in this process, too, and some begin at their first use."""


def leftovers(sim: SimulatedChassis, threads: set[threading.Thread]) -> str:
    """Threads and registrations of ours that are still there, in words."""
    end = time.monotonic() + 30.0
    while True:
        names = [t.name for t in threading.enumerate() if t not in threads]
        left = [name for name in names if any(part in name for part in OURS) and "simulat" not in name]
        with rosproto.MasterClient(sim.master_uri, "/watch") as master:
            state = master.get_system_state()
        left += [
            n for part in state for nodes in part.values() for n in nodes if n.startswith("/woosh_pure_")
        ]
        if not left or time.monotonic() > end:
            return "; ".join(left)
        time.sleep(0.05)


def run(sim: SimulatedChassis, trials: int, delay: float, seed: int) -> list[str]:
    """A storm; what was wrong, in words."""
    threads = set(threading.enumerate())
    wrong = asyncio.run(storm(sim, trials, delay, seed))
    if left := leftovers(sim, threads):
        wrong.append(f"left open: {left}")
    return wrong


@pytest.mark.promise("an asyncio task is cancelled")
@pytest.mark.parametrize("delay", [0.0, 0.1])
def test_the_robot_stands_after_every_cancel(sim: SimulatedChassis, delay: float) -> None:
    """Whatever was cancelled, and when; and nothing is left open."""
    sim.speed = 1.0
    assert run(sim, TRIALS, delay, random.randrange(1 << 30)) == []


if __name__ == "__main__":
    logging.getLogger("woosh_pure").setLevel(logging.ERROR)
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 400
    with SimulatedChassis(full_graph=False) as simulated:
        problems: list[str] = []
        for slow in (0.0, 0.05, 0.2):
            began = time.monotonic()
            found = run(simulated, count // 3, slow, int(time.time()))
            problems += found
            print(
                f"network delay {slow} s: {count // 3} trials in {time.monotonic() - began:.0f} s, wrong: {found}",
                flush=True,
            )
    sys.exit(bool(problems))
