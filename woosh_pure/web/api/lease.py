"""GET, POST and DELETE lease, POST lease/grant."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Request

from woosh_pure.web import models
from woosh_pure.web.api.dependencies import PROBLEMS, check_command, client_of, problems, robot_of
from woosh_pure.web.problems import Problem
from woosh_pure.web.snapshot import lease_part

__all__ = ["router"]

router = APIRouter(tags=["lease"], responses=PROBLEMS)


def get_lease(request: Request) -> dict[str, Any]:
    """Who commands the robot, and who has asked for it."""
    return lease_part(robot_of(request).chassis.lease.state, mine=client_of(request).name)


def ask_for_lease(request: Request, body: models.LeaseRequest | None = None) -> dict[str, Any]:
    """Take the lease if it is free, or renew it. Otherwise its holder is asked; `yours` tells which."""
    robot, client = check_command(request, lease=False)
    lease = robot.chassis.lease
    if not lease.acquire(client.name, (body or models.LeaseRequest()).seconds):
        lease.request(client.name)
    return get_lease(request)


def give_lease_back(request: Request) -> dict[str, Any]:
    """Give the lease back, or withdraw the request for it."""
    robot, client = robot_of(request), client_of(request)
    robot.chassis.lease.release(client.name)
    if robot.teleop.driver == client.name:
        robot.teleop.halt("the lease was given back")
    return get_lease(request)


def grant_lease(request: Request, body: models.GrantRequest | None = None) -> dict[str, Any]:
    """Hand the lease over to a client that has asked for it."""
    robot, client = robot_of(request), client_of(request)
    lease = robot.chassis.lease
    to = (None if body is None else body.to) or next(iter(lease.state.asking), "")
    if not lease.grant(client.name, to):
        raise Problem(409, "the lease is not yours to grant, or nobody of that name asks for it", "lease")
    if robot.teleop.driver == client.name:
        robot.teleop.halt("the lease was handed over")
    return get_lease(request)


ORDERS = problems(403, 409, 422, 429)
add = router.add_api_route
add("/lease", get_lease, response_model=models.LeaseAnswer)
add("/lease", ask_for_lease, methods=["POST"], response_model=models.LeaseAnswer, responses=ORDERS)
add("/lease", give_lease_back, methods=["DELETE"], response_model=models.LeaseAnswer)
add("/lease/grant", grant_lease, methods=["POST"], response_model=models.LeaseAnswer, responses=ORDERS)
