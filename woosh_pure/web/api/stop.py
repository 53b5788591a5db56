"""POST stop, and POST pose."""

from __future__ import annotations

from functools import partial
from typing import Any

from fastapi import APIRouter, Request

from woosh_pure.geometry import Pose2D
from woosh_pure.web import models
from woosh_pure.web.api.dependencies import PROBLEMS, check_command, client_of, context_of, problems, robot_of

__all__ = ["router"]

router = APIRouter(tags=["stop"], responses=PROBLEMS)


async def stop(request: Request, body: models.StopRequest | None = None) -> dict[str, Any]:
    """Stop the robot. Needs no lease and is not limited. This is NO emergency stop; the answer tells whether
    the robot stands still.
    """
    robot, client = robot_of(request), client_of(request)
    everything = True if body is None else body.everything
    robot.teleop.halt(f"{client.name} stopped the robot")  # at once, before any thread is free
    report = await context_of(request).stops.run(partial(robot.stop, client.name, everything=everything))
    return {
        "stands_still": report.standing,
        "text": report.sentence(),
        "cancelled": list(report.cancelled),
        "problems": list(report.problems),
    }


def set_pose(body: models.PoseRequest, request: Request) -> dict[str, Any]:
    """Tell the robot where it is, for example after power-up."""
    robot, client = check_command(request)
    pose = Pose2D(body.x, body.y, body.theta).require_sensible()
    entry = robot.journal.begin(client.name, f"set the pose to {pose}")
    try:
        robot.chassis.set_pose(pose)
    except Exception as error:
        robot.journal.end(entry, "failed", str(error))
        raise
    robot.journal.end(entry, "done", "sent; whether it has found itself there is told by its readiness")
    return {"x": pose.x, "y": pose.y, "theta": pose.yaw}


router.add_api_route("/stop", stop, methods=["POST"], response_model=models.StopAnswer)
router.add_api_route(
    "/pose", set_pose, methods=["POST"], response_model=models.Pose, responses=problems(403, 409, 422, 429)
)
