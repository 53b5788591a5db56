"""The tools that move the robot, stop it, or make light or noise."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

from mcp_types import ToolAnnotations
from pydantic import Field

from rosproto.sentence import say as words
from rosproto.sentence import shown
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.marks import UserMark
from woosh_pure.mcp import texts
from woosh_pure.mcp.motion import OWNER, GoalRide, MissionRide, Result, Wanted
from woosh_pure.missions import Mission
from woosh_pure.missions.mission import MOVING
from woosh_pure.motion.steps import MAX_DISTANCE
from woosh_pure.stopping.report import StopReport
from woosh_pure.web.goals import command
from woosh_pure.web.robot import Robot

if TYPE_CHECKING:
    from woosh_pure.mcp.limits import Limits
    from woosh_pure.mcp.server import Door

STEP_SPEED = 0.2
"""m/s: the chassis's own for a step."""
ACTS = ToolAnnotations(
    read_only_hint=False, destructive_hint=False, idempotent_hint=True, open_world_hint=True
)
MarkName = Annotated[str, Field(min_length=1, max_length=200, description="its name, as `marks` lists it")]
Text = Annotated[str, Field(min_length=1, max_length=200)]


class Stopped(Result):
    """How a stop ended."""

    stands_still: bool | None = Field(description="null if that is not known")
    sentence: str


class Done(Result):
    """What was done."""

    sentence: str


def add(door: Door, *, motion: bool) -> None:
    """Add the tools to a server: those that move the robot only with `motion`."""
    door.tool(ACTS, noted=False)(stop)
    for tool in (stop_mission, say, lights):
        door.tool(ACTS)(tool)
    if motion:
        _add_moving(door, door.limits)


async def stop(robot: Robot) -> Stopped:
    """Stop the robot now, whoever moves it. It is never refused. It is no emergency stop."""
    return _stopped(await asyncio.wrap_future(robot.begin_stop(OWNER)))


def stop_mission(robot: Robot) -> Stopped:
    """Stop the robot, end the mission that runs, and pause the queue of missions."""
    return _stopped(robot.chassis.missions.stop(by=OWNER))


def _stopped(report: StopReport) -> Stopped:
    return Stopped(stands_still=report.standing, sentence=texts.data(shown(str(report)), 1000))


def say(robot: Robot, text: Text) -> Done:
    """Let the robot speak, where it has a voice."""
    robot.require_connection()
    robot.chassis.say(texts.data(text, 200))
    return Done(sentence="it was told to speak")


def lights(
    robot: Robot, color: Annotated[str, Field(max_length=20, description='"red", or "ff8000"')]
) -> Done:
    """Set the colour of the robot's light strip."""
    robot.require_connection()
    robot.chassis.light(color=color)
    return Done(sentence="the light was set")


def _add_moving(door: Door, limits: Limits) -> None:
    seconds = limits.max_seconds

    def ride(
        robot: Robot, kind: str, what: Any, verb: Callable[[], Any], target: Any = None
    ) -> Callable[[], GoalRide]:
        place = None if target is None else {"x": target.x, "y": target.y}
        return lambda: GoalRide(robot.goals.begin(kind, OWNER, what, verb, target=place))

    def to_mark(robot: Robot, kind: str, mark: str) -> Wanted:
        known = _find(robot, mark)
        name, pose = (mark, None) if known is None else (known.name, known.pose)
        what = command(kind, mark=texts.data(name, 200))
        verb: Callable[[], Any] = partial(
            getattr(robot.chassis, "go_to_mark" if kind == "mark" else kind), name, timeout=seconds
        )
        if known is not None and not known.on_chassis and pose is not None and kind == "mark":
            verb = partial(robot.chassis.go_to, pose.x, pose.y, pose.yaw, timeout=seconds)
        missing = "no mark of that name is known" if known is None and limits.only_marks else ""
        return Wanted(
            what, ride(robot, kind, what, verb, pose), lambda here: pose, check=lambda here: missing
        )

    @door.moves("Let the robot drive to the mark {mark}?")
    def go_to_mark(robot: Robot, mark: MarkName) -> Wanted:
        """Drive to a mark. Returns when the robot has arrived, or with the reason why not."""
        return to_mark(robot, "mark", mark)

    @door.moves("Let the robot park at the mark {mark}?")
    def park(robot: Robot, mark: MarkName) -> Wanted:
        """Drive to a parking mark and park. Returns at its end."""
        return to_mark(robot, "park", mark)

    @door.moves("Let the robot drive to the charger {mark} and charge?")
    def charge(robot: Robot, mark: MarkName) -> Wanted:
        """Drive to a charger and charge. Returns at its end."""
        return to_mark(robot, "charge", mark)

    @door.moves("Start the mission {mission}? The robot moves as its steps say.")
    def start_mission(
        robot: Robot,
        mission: Annotated[
            str, Field(min_length=1, max_length=100, description="its file, as `missions` lists it")
        ],
        parameters: Annotated[dict[str, str | float | bool], Field(max_length=50)] = {},
    ) -> Wanted:
        """Start a mission and follow it to its end; it is stopped when this call ends before. A question of it is
        answered by `answer_mission` meanwhile."""
        found = robot.missions.file(mission).mission
        if found is None:
            raise ValueError(
                words("the file of the mission {mission} is faulty", mission=texts.data(mission, 100))
            )
        given = found.filled(parameters)
        missions = robot.chassis.missions
        return Wanted(
            command("mission", mission=texts.data(found.name, 100)),
            lambda: MissionRide(robot, missions.run(found, parameters, by=OWNER)),
            check=lambda here: _mission_refusal(robot, found, given, limits, here),
            mission=True,
        )

    @door.tool(ToolAnnotations(read_only_hint=False, destructive_hint=True, open_world_hint=True))
    def answer_mission(robot: Robot, answer: Text, run: Annotated[str, Field(max_length=100)] = "") -> Done:
        """Answer the question of the mission that this server's `start_mission` carries out."""
        active = robot.chassis.missions.state.active
        if active is None or active.entry.by != OWNER:
            raise ValueError(words("no mission that an assistant has started asks a question now"))
        robot.chassis.missions.answer(answer, by=OWNER, run=run)
        return Done(sentence="the mission goes on")

    if limits.only_marks:
        return

    @door.moves("Let the robot drive to x {x_m} m, y {y_m} m, heading {heading_deg} degrees?")
    def go_to_pose(
        robot: Robot,
        x_m: Annotated[float, Field(ge=-1e4, le=1e4)],
        y_m: Annotated[float, Field(ge=-1e4, le=1e4)],
        heading_deg: Annotated[
            float, Field(ge=-360, le=360, description="counter-clockwise from the x axis")
        ] = 0.0,
    ) -> Wanted:
        """Drive to a place in the map. Returns when the robot has arrived, or with the reason why not."""
        pose = Pose2D(x_m, y_m, math.radians(heading_deg)).require_sensible()
        what = command("pose", x=pose.x, y=pose.y, yaw=pose.yaw)
        verb = partial(robot.chassis.go_to, pose.x, pose.y, pose.yaw, timeout=seconds)
        return Wanted(what, ride(robot, "pose", what, verb, pose), lambda here: pose)

    @door.moves("Let the robot drive {distance_m} m straight ahead (negative: back)?")
    def move(
        robot: Robot,
        distance_m: Annotated[float, Field(ge=-MAX_DISTANCE, le=MAX_DISTANCE, description="negative: back")],
        speed_m_per_s: Annotated[float, Field(ge=0, le=2, description="0: the robot's own, 0.2")] = 0.0,
    ) -> Wanted:
        """Drive straight by a distance, with obstacle avoidance. Returns at its end."""
        what, speed = command("move", distance=distance_m), limits.speed(speed_m_per_s, STEP_SPEED)
        verb = partial(robot.chassis.move, distance_m, speed=speed, timeout=seconds)
        return Wanted(
            what,
            ride(robot, "move", what, verb),
            lambda here: here.transformed(distance_m, 0.0, 0.0),
            straight=True,
        )

    @door.moves("Let the robot turn by {angle_deg} degrees (positive: to the left)?")
    def turn(
        robot: Robot, angle_deg: Annotated[float, Field(ge=-360, le=360, description="left positive")]
    ) -> Wanted:
        """Turn on the spot. Returns at its end."""
        what = command("rotate", angle=math.radians(angle_deg))
        verb = partial(robot.chassis.rotate, math.radians(angle_deg), timeout=seconds)
        return Wanted(what, ride(robot, "rotate", what, verb), lambda here: here)


def _find(robot: Robot, name: str) -> UserMark | None:
    """The mark with that name, or with that name as the tools show it."""
    all_marks = robot.all_marks()
    return next(
        (one for one in all_marks if one.name == name),
        next((one for one in all_marks if texts.data(one.name, 200) == name), None),
    )


def _mission_refusal(robot: Robot, mission: Mission, given: Any, limits: Limits, here: Pose2D | None) -> str:
    """Why a mission is refused by its steps; "" if it is not. Their ways are judged when they are driven."""
    for step in (*mission.steps, *mission.on_abort):
        if step.do == "call" and str(step.values.get("service", "")).startswith("$"):
            return "it calls a service that is named by a parameter"
        if step.do not in MOVING or not (limits.only_marks or limits.by_place):
            continue
        mark = None if "mark" not in step.keys else robot.find_mark(str(step.value("mark", given)))
        if mark is None:
            return words("its step {step} leads to no known mark, so the limits cannot be kept", step=step.do)
        if why := limits.refusal(here, mark.pose):
            return why
    return ""
