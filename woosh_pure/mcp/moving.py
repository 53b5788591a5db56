"""The tools that move the robot, stop it, or make light or noise."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

from anyio import CapacityLimiter
from anyio.to_thread import run_sync
from mcp_types import ToolAnnotations
from pydantic import Field, Strict, StrictFloat

from rosproto.sentence import say as words
from rosproto.sentence import shown
from woosh_pure.geometry import Pose2D
from woosh_pure.mcp import texts
from woosh_pure.mcp.motion import OWNER, GoalRide, MissionRide, Result, Wanted
from woosh_pure.missions import Mission
from woosh_pure.missions.mission import MOVING
from woosh_pure.motion.steps import MAX_DISTANCE, MAX_SPEED
from woosh_pure.stopping.report import StopReport
from woosh_pure.web import models
from woosh_pure.web.robot import Robot

if TYPE_CHECKING:
    from woosh_pure.mcp.door import Door
    from woosh_pure.mcp.limits import Limits

STEP_SPEED = 0.2
"""m/s: the chassis's own for a step."""
MOVES = ToolAnnotations(read_only_hint=False, destructive_hint=True, idempotent_hint=False)
ACTS = ToolAnnotations(read_only_hint=False, destructive_hint=False, idempotent_hint=True)
Text = Annotated[str, Field(min_length=1, max_length=200)]
# Strict: `true` and "1" are no numbers here.
Coordinate = Annotated[models.Metres, Strict()]
Degrees = Annotated[StrictFloat, Field(ge=-360, le=360, description="counter-clockwise (left) positive")]
Distance = Annotated[StrictFloat, Field(ge=-MAX_DISTANCE, le=MAX_DISTANCE, description="negative: back")]
Speed = Annotated[StrictFloat, Field(ge=0, le=MAX_SPEED, description="0: the robot's own, 0.2")]


class Told(Result):
    """What came of it."""

    sentence: str
    stands_still: bool | None = None


async def stop(robot: Robot) -> Told:
    """Stop the robot now, whoever moves it. Never refused. It is no emergency stop."""
    return _stopped(await asyncio.wrap_future(robot.begin_stop(OWNER)))


async def stop_mission(robot: Robot) -> Told:
    """Stop the robot, end the mission that runs, and pause the queue of missions."""
    stop = partial(robot.chassis.missions.stop, by=OWNER)
    return _stopped(await run_sync(stop, limiter=CapacityLimiter(1)))


def _stopped(report: StopReport) -> Told:
    return Told(sentence=texts.data(shown(str(report)), 1000), stands_still=report.standing)


def say(robot: Robot, text: Text) -> Told:
    """Let the robot speak, where it has a voice."""
    robot.chassis.say(texts.data(text, 200))
    return Told(sentence="it was told to speak")


def lights(robot: Robot, color: Annotated[str, Field(max_length=20, description="red, or ff8000")]) -> Told:
    """Set the colour of the robot's light strip."""
    robot.chassis.light(color=color)
    return Told(sentence="the light was set")


def answer_mission(robot: Robot, answer: Text) -> Told:
    """Answer the question of the mission that `start_mission` carries out."""
    active = robot.chassis.missions.state.active
    if active is None or active.entry.by != OWNER:
        raise ValueError("no mission that an assistant has started asks a question now")
    robot.chassis.missions.answer(answer, by=OWNER, run=active.entry.id)
    return Told(sentence="the mission goes on")


def add(door: Door, *, motion: bool) -> None:
    """Add the tools to a server: those that move the robot only with `motion`."""
    for tool in (stop, stop_mission, say, lights):
        door.tool(ACTS)(tool)
    if motion:
        door.tool(ACTS)(answer_mission)
        _add_to_marks(door, door.limits)
        if not door.limits.only_marks:
            _add_free(door, door.limits)


def _drive(robot: Robot, body: models.GoalRequest) -> GoalRide:
    """Begin a goal of the chassis; the call has an entry in the journal already."""
    return GoalRide(robot.begin_goal(body, OWNER, noted=False))


def _add_to_marks(door: Door, limits: Limits) -> None:
    def to_mark(robot: Robot, goal: Callable[..., models.GoalRequest], mark: str) -> Wanted:
        told = (one for one in robot.all_marks() if texts.data(one.name, 200) == mark)
        known = robot.find_mark(mark) or next(told, None)
        body = goal(mark=known.name if known else mark, timeout=limits.max_seconds)
        needed = limits.only_marks or limits.by_place
        missing = "" if known or not needed else "no mark of that name is known; the tool 'marks' lists them"
        pose = known.pose if known else None
        return Wanted(partial(_drive, robot, body), lambda here: pose, check=lambda here: missing)

    @door.tool(MOVES, "Let the robot drive to the mark {mark}?")
    def go_to_mark(robot: Robot, mark: Text) -> Wanted:
        """Drive to a mark. Returns when the robot has arrived, or with the reason why not."""
        return to_mark(robot, partial(models.MarkGoal, kind="mark"), mark)

    @door.tool(MOVES, "Let the robot park at the mark {mark}?")
    def park(robot: Robot, mark: Text) -> Wanted:
        """Drive to a parking mark and park. Returns at its end."""
        return to_mark(robot, partial(models.ParkGoal, kind="park"), mark)

    @door.tool(MOVES, "Let the robot drive to the charger {mark} and charge?")
    def charge(robot: Robot, mark: Text) -> Wanted:
        """Drive to a charger and charge. Returns at its end."""
        return to_mark(robot, partial(models.ChargeGoal, kind="charge"), mark)

    @door.tool(MOVES, "Start the mission {mission} with {parameters}? The robot moves as its steps say.")
    def start_mission(
        robot: Robot, mission: Text, parameters: dict[str, str | float | bool] | None = None
    ) -> Wanted:
        """Start a mission, by its file's name, and follow it to its end; it stops when this call ends before.
        Meanwhile, `answer_mission` answers its question."""
        found, runs = robot.missions.file(mission).mission, robot.chassis.missions
        if found is None:
            raise ValueError("the file of this mission is faulty; `missions` says why")
        given = found.filled(parameters or {})
        return Wanted(
            lambda: MissionRide(runs.run(found, parameters, by=OWNER)),
            check=lambda here: _mission_refusal(robot, found, given, limits, here),
            end=partial(runs.stop, by=OWNER),
        )


def _mission_refusal(robot: Robot, mission: Mission, given: Any, limits: Limits, here: Pose2D | None) -> str:
    """Why a mission is refused by its steps; "" if it is not. Their ways are judged when they are driven."""
    for step in (*mission.steps, *mission.on_abort):
        if step.do == "call":
            return "it calls a service, which an assistant may not do"
        if step.do not in MOVING or not (limits.only_marks or limits.by_place):
            continue
        mark = robot.find_mark(str(step.value("mark", given))) if "mark" in step.keys else None
        if mark is None:
            return words("its step {step} leads to no known mark, so the limits cannot be kept", step=step.do)
        if why := limits.refusal(here, mark.pose):
            return why
    return ""


def _add_free(door: Door, limits: Limits) -> None:
    seconds = limits.max_seconds

    @door.tool(MOVES, "Let the robot drive to x {x_m} m, y {y_m} m, heading {heading_deg} degrees?")
    def go_to_pose(robot: Robot, x_m: Coordinate, y_m: Coordinate, heading_deg: Degrees = 0.0) -> Wanted:
        """Drive to a place in the map. Returns when the robot has arrived, or with the reason why not."""
        pose = Pose2D(x_m, y_m, math.radians(heading_deg))
        body = models.PoseGoal(kind="pose", x=x_m, y=y_m, yaw=pose.yaw, timeout=seconds)
        return Wanted(partial(_drive, robot, body), lambda here: pose)

    @door.tool(MOVES, "Let the robot drive {distance_m} m straight ahead (negative: back)?")
    def move(robot: Robot, distance_m: Distance, speed_m_per_s: Speed = 0.0) -> Wanted:
        """Drive straight by a distance, with obstacle avoidance. Returns at its end."""
        most = limits.max_speed or MAX_SPEED
        if speed_m_per_s > most:
            raise ValueError(words("at most {maximum:g} m/s are allowed", maximum=most))
        speed = speed_m_per_s or min(STEP_SPEED, most)
        body = models.MoveGoal(kind="move", distance=distance_m, speed=speed, timeout=seconds)
        return Wanted(
            partial(_drive, robot, body), lambda here: here.transformed(distance_m, 0.0, 0.0), straight=True
        )

    @door.tool(MOVES, "Let the robot turn by {angle_deg} degrees (positive: to the left)?")
    def turn(robot: Robot, angle_deg: Degrees) -> Wanted:
        """Turn on the spot. Returns at its end."""
        body = models.RotateGoal(kind="rotate", angle=math.radians(angle_deg), timeout=seconds)
        return Wanted(partial(_drive, robot, body), lambda here: here)
