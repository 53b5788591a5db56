"""POST goals; GET goals, and waiting for, cancelling, pausing and resuming one."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from functools import partial
from typing import Any

from fastapi import APIRouter, Query, Request
from starlette.concurrency import run_in_threadpool

from woosh_pure.enums import Direction
from woosh_pure.web import models
from woosh_pure.web.api.dependencies import PROBLEMS, check_command, context_of, name_of, problems, robot_of
from woosh_pure.web.problems import Problem
from woosh_pure.web.robot import Robot

__all__ = ["router"]

router = APIRouter(tags=["goals"], responses=PROBLEMS)
ORDERS = problems(403, 409, 422, 429, 501)


def create_goal(body: models.GoalRequest, request: Request) -> dict[str, Any]:
    """Start a motion. It does not depend on this connection: it ends when done, cancelled, or timed out."""
    robot, client = check_command(request)
    options: dict[str, Any] = {"replace": body.replace}
    if body.timeout is not None:
        options["timeout"] = body.timeout
    what, start = _verb(robot, body, options)
    return robot.goals.begin(body.kind, client.name, what, start).as_json()


def _verb(robot: Robot, body: Any, options: dict[str, Any]) -> tuple[str, Callable[[], Any]]:
    chassis = robot.chassis
    if body.kind == "mark":
        return f"go to {body.mark}", partial(chassis.go_to_mark, body.mark, **options)
    if body.kind == "park":
        return f"park at {body.mark}", partial(chassis.park, body.mark, **options)
    if body.kind == "charge":
        return f"charge at {body.mark}", partial(chassis.charge, body.mark, **options)
    if body.kind == "carry":
        direction = Direction.LOAD if body.direction == "load" else Direction.UNLOAD
        return f"{body.direction} at {body.mark}", partial(chassis.carry, body.mark, direction, **options)
    if body.kind == "pose":
        what = f"go to {body.x:.2f} {body.y:.2f} m, {body.theta:.2f} rad"
        return what, partial(chassis.go_to, body.x, body.y, body.theta, **options)
    if body.kind == "move":
        return f"move {body.distance:.2f} m", partial(
            chassis.move, body.distance, speed=body.speed, **options
        )
    return f"rotate {body.angle:.2f} rad", partial(chassis.rotate, body.angle, speed=body.speed, **options)


def list_goals(request: Request) -> list[dict[str, Any]]:
    """The last goals, the oldest first."""
    return [goal.as_json() for goal in robot_of(request).goals.all()]


def get_goal(goal: str, request: Request) -> dict[str, Any]:
    """One goal by its id."""
    return robot_of(request).goals.get(goal).as_json()


async def wait_for_goal(
    goal: str, request: Request, timeout: float = Query(30.0, gt=0.0, le=300.0)
) -> dict[str, Any]:
    """Wait until the goal has ended or the time is up; `done` tells which."""
    found, until = robot_of(request).goals.get(goal), time.monotonic() + timeout
    while not found.done and time.monotonic() < until:
        if context_of(request).closed or await request.is_disconnected():
            break
        await asyncio.sleep(0.05)
    return await run_in_threadpool(found.as_json)


def cancel_goal(goal: str, request: Request) -> dict[str, Any]:
    """Cancel the goal, and wait until the robot confirms. It may have arrived meanwhile."""
    found = robot_of(request).goals.get(goal)
    if not found.done:
        robot_of(request).journal.note(name_of(request), f"cancel goal {found.id}")
        found.handle.cancel()
        found.wait(2.0)
    return found.as_json()


async def pause_goal(goal: str, request: Request) -> dict[str, Any]:
    """Pause the goal."""
    return await run_in_threadpool(_hold, goal, request, "pause")


async def resume_goal(goal: str, request: Request) -> dict[str, Any]:
    """Resume a paused goal."""
    return await run_in_threadpool(_hold, goal, request, "resume")


def _hold(number: str, request: Request, verb: str) -> dict[str, Any]:
    robot, client = check_command(request, lease=verb == "resume")
    goal = robot.goals.get(number)
    act = getattr(goal.handle, verb, None)
    if act is None:
        raise Problem(
            409, f"{goal.handle.description}: this kind of goal cannot be paused; cancel it", "no-pause"
        )
    if goal.done:
        raise Problem(409, f"{goal.handle.description}: it has ended already", "ended")
    act()
    goal.paused = verb == "pause"
    robot.journal.note(client.name, f"{verb} goal {goal.id}")
    return goal.as_json()


add = router.add_api_route
add("/goals", create_goal, methods=["POST"], status_code=201, response_model=models.Goal, responses=ORDERS)
add("/goals", list_goals, response_model=list[models.Goal])
add("/goals/{goal}", get_goal, response_model=models.Goal)
add("/goals/{goal}/wait", wait_for_goal, response_model=models.Goal)
add("/goals/{goal}", cancel_goal, methods=["DELETE"], response_model=models.Goal)
add("/goals/{goal}/pause", pause_goal, methods=["POST"], response_model=models.Goal, responses=ORDERS)
add("/goals/{goal}/resume", resume_goal, methods=["POST"], response_model=models.Goal, responses=ORDERS)
