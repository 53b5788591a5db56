"""The chassis for asyncio: every verb, service and feed of `woosh_pure.Chassis`, awaited.

    async with aio.Chassis("169.254.128.2") as robot:     # or Chassis(...).aio
        await robot.go_to_mark("A1")                      # there, or GoalFailed
        async for pose in robot.pose: ...

Names, arguments, values and errors are those of `Chassis`, from which all this is made: the same calls, in
threads of its own. Cancelling a task ends what it has begun, also what is only being prepared: see `Chassis`.
It is not imported with woosh_pure, since asyncio takes longer to import than all of woosh_pure.
"""

from woosh_pure.aio.chassis import Chassis, Missions, RobotApi, view
from woosh_pure.aio.drive import Drive, VelocityBlock
from woosh_pure.aio.feed import Feed
from woosh_pure.aio.goals import ActionHandle, Goal, GoalHandle, NavigationHandle, StepHandle, TaskHandle

__all__ = [
    "ActionHandle",
    "Chassis",
    "Drive",
    "Feed",
    "Goal",
    "GoalHandle",
    "Missions",
    "NavigationHandle",
    "RobotApi",
    "StepHandle",
    "TaskHandle",
    "VelocityBlock",
    "view",
]
