"""GET status, snapshot, readiness, faults, marks, journal, and the robots of this server."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Request

from woosh_pure.web import models
from woosh_pure.web.api.dependencies import PROBLEMS, context_of, robot_of
from woosh_pure.web.live import robot_state

__all__ = ["router", "server_router"]

router, server_router = APIRouter(tags=["state"], responses=PROBLEMS), APIRouter(tags=["robots"])


def get_status(request: Request) -> dict[str, Any]:
    """The state in brief."""
    shown = robot_state.snapshot(robot_of(request))
    status, battery, readiness = shown["status"], shown["battery"], shown["readiness"]
    ages = [age for age in shown["ages"].values() if age is not None]
    return {
        "robot": shown["robot"],
        "state": None if status is None else status["robot_state"],
        "battery_percent": None if battery is None else battery["percent"],
        "pose": shown["pose"],
        "ready": readiness["answer"],
        "text": readiness["text"],
        "age": min(ages, default=None),
    }


def get_snapshot(request: Request) -> dict[str, Any]:
    """The whole state at once, with the age of each part."""
    return robot_state.snapshot(robot_of(request))


def get_readiness(request: Request) -> Any:
    """Whether the robot would move now, and if not, why."""
    return robot_state.slow_parts(robot_of(request))["readiness"]


def get_faults(request: Request) -> Any:
    """The faults that are active now."""
    return robot_state.slow_parts(robot_of(request))["faults"]


def get_marks(request: Request) -> list[dict[str, Any]]:
    """The marks that this server was given: the chassis cannot list its own."""
    return [mark.as_json() for mark in robot_of(request).marks]


def get_journal(request: Request) -> list[dict[str, Any]]:
    """What was done, by whom, and how it ended; the oldest first."""
    return [entry.as_json() for entry in robot_of(request).journal.entries()]


def list_robots(request: Request) -> list[dict[str, Any]]:
    """The robots of this server. Paths without a robot's name mean the first one."""
    root = str(request.scope.get("root_path", ""))
    return [
        {"name": name, "page": f"{root}/robots/{name}/", "api": f"{root}/api/v1/robots/{name}/"}
        for name in context_of(request).robots
    ]


router.add_api_route("/status", get_status, response_model=models.Status)
router.add_api_route("/snapshot", get_snapshot, response_model=models.Snapshot)
router.add_api_route("/readiness", get_readiness, response_model=models.Readiness)
router.add_api_route("/faults", get_faults, response_model=models.Faults)
router.add_api_route("/marks", get_marks, response_model=list[models.Mark])
router.add_api_route("/journal", get_journal, response_model=list[models.Entry])
server_router.add_api_route("/robots", list_robots, response_model=list[models.RobotEntry])
