"""Actions with asyncio, over real nodes and a real master."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator

import pytest

from rosproto import aio
from rosproto.action import GoalStatus
from rosproto.codec import message_class
from rosproto.errors import ConnectionLost, RosTimeout
from rosproto.master import Master

Goal = message_class("actionlib/TestGoal")
Feedback = message_class("actionlib/TestFeedback")
Result = message_class("actionlib/TestResult")


@pytest.fixture(scope="module")
def uri() -> Iterator[str]:
    with Master() as master:
        yield master.uri


def run(main) -> None:
    asyncio.run(asyncio.wait_for(main(), 30))


def nodes(uri: str) -> tuple[aio.Node, aio.Node]:
    return tuple(aio.Node(n, master_uri=uri, anonymous=True, rosout=False) for n in ("robot", "laptop"))  # type: ignore[return-value]


def test_a_goal_is_awaited_and_its_feedback_iterated(uri):
    async def main() -> None:
        seen = asyncio.Event()

        async def count(goal):
            for n in range(goal.goal.goal):
                goal.publish_feedback(Feedback(feedback=n))
            await seen.wait()  # a result may overtake feedback: they are two topics
            goal.succeed(Result(result=7), "counted")

        robot, laptop = nodes(uri)
        async with robot, laptop, robot.action_server("/count", "actionlib/Test", count):
            client = await laptop.action_client("/count", "actionlib/Test")
            await client.wait_for_server(20)
            goal = await client.send_goal(Goal(goal=5))
            numbers = []
            async for message in goal.feedback(10):
                numbers.append(message.feedback)
                if len(numbers) == 5:
                    seen.set()
            assert numbers == [0, 1, 2, 3, 4]
            assert (await goal.wait(20)).result == 7
            assert (await goal).result == goal.result.result == 7
            assert (goal.status, goal.text, goal.done) == (GoalStatus.SUCCEEDED, "counted", True)

    run(main)


def test_a_goal_is_cancelled_and_one_that_takes_long_times_out(uri):
    async def until_cancelled(goal):
        while not goal.cancel_requested:
            await asyncio.sleep(0.005)
        goal.preempted(Result(result=1), "as you wish")

    async def main() -> None:
        robot, laptop = nodes(uri)
        async with robot, laptop, robot.action_server("/long", "actionlib/Test", until_cancelled):
            client = await laptop.action_client("/long", "actionlib/Test")
            await client.wait_for_server(20)
            goal = await client.send_goal(Goal(goal=1))
            with pytest.raises(RosTimeout, match="is still"):
                await goal.wait(0.05)
            with pytest.raises(RosTimeout, match="is still"):
                async for _ in goal.feedback(0.05):
                    pass
            assert goal.cancel()
            assert (await goal.wait(20)).result == 1
            assert goal.status is GoalStatus.PREEMPTED
            await client.close()

    run(main)


def test_closing_the_client_ends_the_wait_and_the_goal_goes_on(uri):
    async def main() -> None:
        started, gate = asyncio.Event(), asyncio.Event()

        async def wait_for_gate(goal):
            started.set()
            await gate.wait()
            goal.succeed(Result(result=1))

        robot, laptop = nodes(uri)
        async with robot, laptop, robot.action_server("/gone", "actionlib/Test", wait_for_gate) as server:
            client = await laptop.action_client("/gone", "actionlib/Test")
            await client.wait_for_server(20)
            goal = await client.send_goal(Goal(goal=1))
            await started.wait()
            waiting = asyncio.create_task(goal.wait(20))
            await asyncio.sleep(0)
            await client.close()
            with pytest.raises(ConnectionLost):
                await waiting
            assert len(server.server.goals) == 1
            gate.set()

    run(main)


def test_the_server_closing_aborts_the_goal(uri):
    async def main() -> None:
        started = asyncio.Event()

        async def until_cancelled(goal):
            started.set()
            while not goal.cancel_requested:
                await asyncio.sleep(0.005)

        robot, laptop = nodes(uri)
        async with laptop:
            await robot
            await robot.action_server("/closing", "actionlib/Test", until_cancelled)
            client = await laptop.action_client("/closing", "actionlib/Test")
            await client.wait_for_server(20)
            goal = await client.send_goal(Goal(goal=1))
            await started.wait()
            await robot.close()
            await goal.wait(20)
            assert goal.status in (GoalStatus.ABORTED, GoalStatus.PREEMPTED)

    run(main)
