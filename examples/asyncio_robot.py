"""The chassis in an asyncio program: verbs and feeds awaited; a cancelled task leaves the robot standing."""

import asyncio

from _robot import robot

from woosh_pure import Chassis, aio


async def watch(chassis: aio.Chassis) -> None:
    async for pose in chassis.pose:
        if pose.x > 1.0:
            print("  past one metre:", pose)
            return


async def main(connected: Chassis) -> None:
    async with connected.aio as chassis:  # or: async with aio.Chassis("169.254.128.2") as chassis
        print("battery", (await chassis.battery).percent, "%")

        # Two tasks of one program: one drives, one watches.
        outcome, _ = await asyncio.gather(chassis.go_to_mark("A1"), watch(chassis))
        print(outcome.sentence())

        # With a handle: leaving the block cancels what still runs.
        async with chassis.go_to(0.0, 0.0) as handle:
            async for _ in handle.reports():
                print("  on its way:", handle.progress)
                break
        print(handle.outcome)

        # A time limit: when it is over, the goal is cancelled and the robot stands.
        try:
            await asyncio.wait_for(chassis.move(2.0, speed=0.2), timeout=0.5)
        except asyncio.TimeoutError:
            print("stopped by its time limit; under way:", chassis.under_way)

        async with chassis.velocity(bypasses_protection=True) as drive:
            await drive.hold(0.0, 0.4, seconds=0.5)  # turning in place: no wall is near enough for that


with robot() as connected:
    asyncio.run(main(connected))
