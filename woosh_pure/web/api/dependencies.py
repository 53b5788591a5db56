"""Who asks for which robot; used by every part of the REST door."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any, cast

from fastapi import Path, Request

from woosh_pure.web.clients import Client
from woosh_pure.web.problems import MEDIA_TYPE, Problem

if TYPE_CHECKING:
    from woosh_pure.web.context import WebContext
    from woosh_pure.web.robot import Robot

__all__ = [
    "PROBLEMS",
    "address_of",
    "check_command",
    "client_of",
    "context_of",
    "named_robot",
    "problems",
    "robot_of",
]

SESSION = "x-woosh-session"


def problems(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """The errors of an operation, for /openapi.json."""
    content = {MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/ProblemDocument"}}}
    return {status: {"description": "a problem, in words", "content": content} for status in statuses}


PROBLEMS = problems(401, 404, 503, 504)


async def named_robot(
    robot: str = Path(description="name of a robot, of GET robots", max_length=100),
) -> None:
    """Tells /openapi.json of the name in the path. Async, or a stop would wait for a thread to be free."""


def context_of(request: Request) -> WebContext:
    """All robots."""
    return cast("WebContext", request.app.state.context)


def robot_of(request: Request) -> Robot:
    """The robot of the path, or the first one."""
    return context_of(request).robot(request.path_params.get("robot"))


def address_of(request: Request) -> str:
    """Of who asks."""
    return request.client.host if request.client else "an unknown address"


def client_of(request: Request) -> Client:
    """Who asks.

    Raises:
        Problem: The session is not known (any more).
    """
    session = request.headers.get(SESSION, "")
    if not session:
        return Client("", f"program at {address_of(request)}", address_of(request))
    client = context_of(request).clients.by_session(session)
    if client is None:
        raise Problem(403, f"{SESSION}: this session is over; connect to api/v1/live again", "session")
    return client


def check_command(request: Request, *, lease: bool = True) -> tuple[Robot, Client]:
    """Robot and person of an order that moves something: not too often, and not while another has the lease.

    Raises:
        Problem: It is not allowed now.
    """
    refusal = context_of(request).access.check_rate(address_of(request), time.monotonic())
    if refusal is not None:
        raise Problem(refusal.status, refusal.text)
    robot, client = robot_of(request), client_of(request)
    if lease:
        robot.require_lease(client)
    return robot, client
