"""The client and the robot of a request, for all routes of the REST API."""

from __future__ import annotations

import time
from typing import cast

from fastapi import Path, Request

from rosproto.sentence import say
from woosh_pure.web.access import Client
from woosh_pure.web.context import WebContext
from woosh_pure.web.http_errors import MEDIA_TYPE, Problem, title_of
from woosh_pure.web.robot import Robot

SESSION = "x-woosh-session"


def problems(*statuses: int) -> dict[int | str, dict[str, object]]:
    """The error answers of an operation, for /openapi.json; `web.description` adds those of all."""
    content = {MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/ProblemDocument"}}}
    return {status: {"description": title_of(status), "content": content} for status in statuses}


PROBLEMS = problems(502, 503, 504)
"""Error statuses that the robot can cause."""
CREATED: dict[int | str, dict[str, object]] = {
    201: {
        "headers": {
            "Location": {
                "description": "address of what was made",
                "required": True,
                "schema": {"type": "string", "format": "uri-reference"},
            }
        }
    }
}


async def named_robot(
    robot: str = Path(description="name of a robot, of GET robots", max_length=100),
) -> None:
    """Describe the robot's name in the path for /openapi.json. Async, so that a stop waits for no thread."""


async def refuse_null(request: Request) -> None:
    """Refuse a body that is null, which FastAPI treats as a missing one."""
    if (await request.body()).strip() == b"null":
        raise Problem(422, "the body is null; allowed: a JSON object, or no body", "invalid")


def context_of(request: Request) -> WebContext:
    """Return the context of the application."""
    return cast("WebContext", request.app.state.context)


def robot_of(request: Request) -> Robot:
    """Return the robot named in the path, or the first one."""
    return context_of(request).robot(request.path_params.get("robot"))


def address_of(request: Request) -> str:
    """The client's IP address."""
    return request.client.host if request.client else "an unknown address"


def client_of(request: Request) -> Client:
    """Return the client that sent the request.

    Raises:
        Problem: The session is unknown or has expired.
    """
    session = request.headers.get(SESSION, "")
    if not session:
        address = address_of(request)
        return Client("", say("program at {address}", address=address), address)
    client = context_of(request).clients.by_session(session)
    if client is None:
        raise Problem(
            403, "{session}: this session is over; connect to api/v1/live again", "session", session=SESSION
        )
    return client


def name_of(request: Request) -> str:
    """Return the client's name, for requests that are never refused: stops and endings."""
    try:
        return client_of(request).name
    except Problem:
        return say("page of another session at {address}", address=address_of(request))


async def connected(request: Request) -> None:
    """Refuse a request while the robot is not connected. Async, so that it needs no thread."""
    robot_of(request).require_connection()


async def note_arrival(request: Request) -> None:
    """Note that a command has arrived: a stop that comes before it begins prevents it. Async, so that it does
    not wait for a thread."""
    request.state.call = robot_of(request).chassis.request()


def check_command(request: Request, *, lease: bool = True, connected: bool = True) -> tuple[Robot, Client]:
    """Return robot and client of a command, after checking the rate and the lease.

    Args:
        request: The request.
        lease: Whether the command is refused while another has the lease.
        connected: Whether the command needs the robot.

    Raises:
        Problem: The command is not allowed now.
    """
    refusal = context_of(request).access.check_rate(address_of(request), time.monotonic())
    if refusal is not None:
        raise refusal
    robot, client = robot_of(request), client_of(request)
    if connected:
        robot.require_connection()
    if lease:
        robot.require_lease(client)
    return robot, client
