"""The awaited chassis: what a program for asyncio does with it, and that a cancelled task leaves no moving robot."""

from __future__ import annotations

import asyncio
import functools
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from woosh_pure import Chassis, GoalFailed, MotionRefused, OutcomeKind, Pose2D, SimulatedChassis, aio
from woosh_pure.faults import StatusCode
from woosh_pure.outcome import Outcome

ROOT = Path(__file__).resolve().parents[2]


def in_loop(test: Callable) -> Callable:
    """Run a coroutine test, 60 seconds at most."""

    @functools.wraps(test)
    def run(*args: Any, **kwargs: Any) -> None:
        asyncio.run(asyncio.wait_for(test(*args, **kwargs), 60))

    return run


def stands(sim: SimulatedChassis) -> bool:
    """Whether the robot stands, and nothing is under way on it."""
    servers = [s for s in sim.graph._keep if hasattr(s, "_workers")]
    with sim.lock:
        still = (
            sim.world.body.velocity.is_standing() and not sim.world.tasks.busy and sim.world.motion is None
        )
    return still and not any(server._workers for server in servers)


def require_standing(sim: SimulatedChassis, seconds: float = 10.0) -> None:
    """It comes to stand in time, and stays so."""
    end = time.monotonic() + seconds
    while not stands(sim):
        assert time.monotonic() < end, f"the robot moves: {sim.world.body.velocity}, {sim.world.tasks.state}"
        time.sleep(0.01)


async def moving(sim: SimulatedChassis) -> None:
    """Wait until it moves."""
    async with asyncio.timeout(20) if hasattr(asyncio, "timeout") else _Forever():
        while sim.world.body.velocity.is_standing():
            await asyncio.sleep(0.005)


class _Forever:
    async def __aenter__(self) -> None: ...

    async def __aexit__(self, *exc_info: object) -> None: ...


# -- what it is for ------------------------------------------------------------------------------------------


@in_loop
async def test_a_goal_is_awaited_to_its_end(sim):
    async with aio.Chassis(sim.master_uri) as robot:
        outcome = await robot.go_to_mark("A1")
        assert outcome.arrived
        assert outcome.description.endswith("to A1")
        assert sim.pose.distance_to(Pose2D(3.0, 1.0)) < 0.2
        with pytest.raises(MotionRefused):
            await robot.go_to_mark("nowhere")
        sim.fail_task("no way")
        with pytest.raises(GoalFailed, match="no way"):
            await robot.park("P1")


@in_loop
async def test_the_block_of_a_chassis_that_exists_closes_it(sim):
    chassis = Chassis(sim.master_uri)
    async with chassis.aio as robot:
        assert (await robot.battery).percent == chassis.battery.latest.percent
    made = chassis._components.connection._node
    assert chassis.node.closed if made is None else made.closed


@in_loop
async def test_a_chassis_in_its_own_block_stays_open(sim, chassis):
    """Who opened it closes it; what the inner block has begun is ended with it."""
    sim.speed = 1.0
    async with chassis.aio as robot:
        handle = await robot.go_to(3.0, 1.0).start()
    assert handle.outcome is not None
    assert handle.outcome.kind is OutcomeKind.CANCELLED
    assert chassis.pose.wait() is not None
    assert not chassis.node.closed
    require_standing(sim)


@in_loop
async def test_a_goal_in_a_block_has_a_handle_and_ends_with_the_block(sim):
    sim.speed = 1.0
    async with aio.Chassis(sim.master_uri) as robot:
        async with robot.go_to_mark("A1") as handle:
            async for status in handle.reports():
                assert status.task_id == handle.task_id
                break
            await moving(sim)
            assert not handle.done
            await handle.pause()
            await robot.measured_velocity.wait_for(lambda v: v.is_standing())
            await handle.resume()
            await moving(sim)
        assert handle.outcome.kind is OutcomeKind.CANCELLED
        require_standing(sim)
        goal = robot.go_to_mark("A1")
        async with goal as handle:
            await handle.cancel()
        with pytest.raises(RuntimeError, match="begun before"):
            await goal


@in_loop
async def test_progress_ends_with_the_goal(sim):
    async with aio.Chassis(sim.master_uri) as robot, robot.move(0.4) as handle:
        seen: list[float] = []
        called: list[float] = []
        handle.on_progress(lambda report: called.append(report.percent))
        async for report in handle.reports():
            seen.append(report.percent)
        assert seen == sorted(seen)
        assert (await handle).arrived
        assert handle.progress.percent == 100.0
        assert called


@in_loop
async def test_a_goal_is_a_coroutine_for_tasks(sim):
    async with aio.Chassis(sim.master_uri) as robot:
        outcome = await asyncio.create_task(robot.move(0.2))
        assert isinstance(outcome, Outcome)
        (turned,) = await asyncio.gather(robot.rotate(0.3))
        assert turned.arrived
        assert (await asyncio.wait_for(robot.move(-0.2), 30)).arrived
        assert (await robot.action("/lift_control", _lift())).arrived


def _lift() -> Any:
    from msgdefs.woosh_msgs.msg import LiftControlGoal

    return LiftControlGoal()


@in_loop
async def test_feeds_are_awaited_and_iterated(sim):
    async with aio.Chassis(sim.master_uri) as robot:
        assert robot.odometer.latest is None  # nothing waits; this begins to subscribe
        assert isinstance(await robot.pose, Pose2D)
        poses = []
        async for pose in robot.pose:
            poses.append(pose)
            if len(poses) == 3:
                break
        assert all(isinstance(pose, Pose2D) for pose in poses)
        assert (await robot.measured_velocity.wait_for(lambda v: v.is_standing())).vx == 0.0
        with pytest.raises(TimeoutError, match="nothing was received within"):
            await robot.pose.wait_for(lambda pose: False, timeout=0.05)
        assert robot.pose.reading.age < 10.0
        assert robot.pose.history[-1].value == robot.pose.latest
        assert await robot.faults == ()
        codes: asyncio.Queue[StatusCode] = asyncio.Queue()
        off = await robot.status_code.on(codes.put_nowait)
        sim.press_emergency_stop()
        assert isinstance(await codes.get(), StatusCode)
        off()
        assert await robot.faults
        assert not await robot.readiness()
        sim.release_emergency_stop()
        assert await robot.wait_until_ready(20)
        assert (await robot.odometer.open()).publishers == 1
        assert "battery" in await robot.snapshot()
        seen = asyncio.create_task(_last(robot.pose))
        await asyncio.sleep(0)
    await seen  # the iteration ends with the chassis


async def _last(feed: aio.Feed[Any]) -> None:
    async for _ in feed:
        pass


@in_loop
async def test_velocity_is_a_block(sim):
    async with aio.Chassis(sim.master_uri) as robot:
        async with robot.velocity(bypasses_protection=True) as drive:
            await drive.hold(0.2, seconds=0.3)
            drive.set(0.1)
            assert drive.active
            assert drive.limits.linear >= 0.2
        assert drive.finished
        require_standing(sim)
        with pytest.raises(MotionRefused, match="only inside"):
            drive.set(0.1)
        with pytest.raises(MotionRefused, match="acknowledge"):
            async with robot.velocity(bypasses_protection=False):
                pass
        assert sim.pose.x > 0.0


@in_loop
async def test_services_are_awaited(sim):
    async with aio.Chassis(sim.master_uri) as robot:
        grid, plan, report = await asyncio.gather(robot.get_map(), robot.plan(Pose2D(3.0, 1.0)), robot.stop())
        assert grid.width
        assert plan
        assert report.standing
        node = await robot.node
        async with node.subscriber("/battery", None) as battery:
            assert (await battery.next()).batteryPercentage


# -- cancelled -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("after", "delay"),
    [(0.0, 0.0), (0.01, 0.0), (0.03, 0.0), (0.05, 0.0), (0.1, 0.2), (0.3, 0.2), (0.6, 0.2)],
)
@in_loop
async def test_a_task_cancelled_while_a_goal_is_sent_leaves_the_robot_standing(sim, after, delay):
    """`asyncio.to_thread(chassis.go_to_mark, "A1")` left it driving, without a handle anywhere."""
    sim.speed = 1.0
    with Chassis(sim.master_uri) as chassis:
        chassis.readiness()
        sim.slow_network(delay)
        task = asyncio.create_task(chassis.aio.go_to_mark("A1").start())
        await asyncio.sleep(after)
        task.cancel()
        try:
            handle = await task
        except asyncio.CancelledError:
            pass
        else:  # it was quicker: then there is a handle
            await handle.cancel()
        sim.slow_network(0.0)
        require_standing(sim)
        await asyncio.sleep(0.3)
        require_standing(sim, 0.1)
        assert not chassis.under_way


@pytest.mark.promise("an asyncio task is cancelled")
@in_loop
async def test_a_time_limit_cancels_the_goal(sim):
    sim.speed = 1.0
    async with aio.Chassis(sim.master_uri) as robot:
        with pytest.raises(asyncio.TimeoutError):
            await asyncio.wait_for(robot.go_to(3.0, 1.0), 0.5)
        assert not robot.under_way
        require_standing(sim)


@pytest.mark.promise("an asyncio task is cancelled")
@pytest.mark.skipif(sys.version_info < (3, 11), reason="TaskGroup is new in Python 3.11")
@in_loop
async def test_a_sibling_that_fails_cancels_the_goal(sim):
    sim.speed = 1.0

    async def fails() -> None:
        await moving(sim)
        raise OSError("the door is shut")

    async with aio.Chassis(sim.master_uri) as robot:
        with pytest.raises(BaseException) as group:  # noqa: PT012
            async with asyncio.TaskGroup() as tasks:
                tasks.create_task(robot.go_to_mark("A1"))
                tasks.create_task(fails())
        assert isinstance(group.value.exceptions[0], OSError)
        assert not robot.under_way
        require_standing(sim)


@pytest.mark.promise("an asyncio task is cancelled")
@in_loop
async def test_cancelling_a_hold_stops_the_robot_within_the_block(sim):
    sim.speed = 1.0
    async with aio.Chassis(sim.master_uri) as robot, robot.velocity(bypasses_protection=True) as drive:
        with pytest.raises(asyncio.TimeoutError):
            await asyncio.wait_for(drive.hold(0.3, seconds=30), 0.5)
        require_standing(sim)
        assert drive.active


@in_loop
async def test_a_block_of_velocity_cancelled_while_it_opens_takes_no_velocity(sim):
    sim.slow_network(0.05)
    async with aio.Chassis(sim.master_uri) as robot:

        async def drives() -> None:
            async with robot.velocity(bypasses_protection=True) as drive:
                await drive.hold(0.3, seconds=30)

        for seconds in (0.0, 0.02, 0.1, 0.2, 0.3):
            task = asyncio.create_task(drives())
            await asyncio.sleep(seconds)
            task.cancel()
            with pytest.raises(asyncio.CancelledError):
                await task
        sim.slow_network(0.0)
        require_standing(sim)
        async with robot.velocity(bypasses_protection=True):  # nothing was left open
            pass


@in_loop
async def test_stop_completes_although_its_task_is_cancelled(sim):
    sim.speed = 1.0
    async with aio.Chassis(sim.master_uri) as robot:
        handle = await robot.go_to_mark("A1").start()
        await moving(sim)
        stopping = asyncio.create_task(robot.stop())
        for _ in range(5):
            await asyncio.sleep(0)
            stopping.cancel()
        with pytest.raises(asyncio.CancelledError):
            await stopping
        assert handle.done
        require_standing(sim, 1.0)


@in_loop
async def test_a_request_that_was_cancelled_before_it_was_sent_is_not_sent(sim):
    """Else it would overtake what the program asks for next."""
    async with aio.Chassis(sim.master_uri) as robot:
        gate, asked = threading.Event(), threading.Event()
        threaded = robot.chassis._components.clients
        original = threaded.service

        def service(name: str) -> Any:
            asked.set()
            gate.wait(20)
            return original(name)

        threaded.service = service  # type: ignore[method-assign]
        task = asyncio.create_task(robot.enable_costmaps(False))
        while not asked.is_set():
            await asyncio.sleep(0.001)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        gate.set()
        threaded.service = original  # type: ignore[method-assign]
        await robot.clear_costmaps()
        assert sim.world.costmaps_enabled


def test_a_loop_that_is_closed_over_a_goal_cancels_it(sim, until):
    """`run_until_complete` and `close`, without cancelling what still waits."""
    sim.speed = 1.0
    with Chassis(sim.master_uri) as chassis:
        loop = asyncio.new_event_loop()
        task = loop.create_task(chassis.aio.go_to_mark("A1"))
        loop.run_until_complete(moving(sim))
        loop.close()
        until(lambda: not chassis.under_way)
        require_standing(sim)
        task._log_destroy_pending = False


@pytest.fixture
def program(tmp_path: Path, sim: SimulatedChassis) -> Iterator[Callable[[str], subprocess.Popen[str]]]:
    """Start a program that has `robot`, an awaited chassis."""
    started: list[subprocess.Popen[str]] = []

    def start(body: str) -> subprocess.Popen[str]:
        script = tmp_path / "program.py"
        script.write_text(
            "import asyncio\nfrom woosh_pure import Chassis, aio\n"
            f"async def main():\n    async with aio.Chassis({sim.master_uri!r}) as robot:\n        {body}\n"
            "asyncio.run(main())\n"
        )
        env = {**os.environ, "PYTHONPATH": str(ROOT)}
        process = subprocess.Popen([sys.executable, str(script)], stderr=subprocess.PIPE, text=True, env=env)
        started.append(process)
        return process

    yield start
    for process in started:
        process.kill()
        process.wait()
        assert process.stderr is not None
        process.stderr.close()


@pytest.mark.promise("an asyncio task is cancelled")
@pytest.mark.skipif(os.name == "nt", reason="sends SIGINT to a child")
@pytest.mark.parametrize("times", [1, 4])
def test_ctrl_c_in_asyncio_run_leaves_the_robot_standing(sim, program, times):
    sim.speed = 1.0
    process = program('await robot.go_to_mark("A1")')
    asyncio.run(moving(sim))
    for _ in range(times):
        process.send_signal(signal.SIGINT)
        time.sleep(0.003)  # as a key that is held repeats
    _, told = process.communicate(timeout=30)
    assert process.returncode != 0
    assert "KeyboardInterrupt" in told
    require_standing(sim)
