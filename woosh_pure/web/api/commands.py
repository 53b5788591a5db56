"""The routes of goals, the lease, recordings and the simulation.

After a DELETE there is nothing at the address, and the next DELETE is answered with 404. DELETE cancels a
running goal first, is refused for a running recording, and gives the lease back.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from functools import partial
from typing import Annotated

from fastapi import APIRouter, Depends, Header, Query, Request, Response
from fastapi.responses import FileResponse
from pydantic import BaseModel
from starlette.concurrency import run_in_threadpool

from woosh_pure.web import models
from woosh_pure.web.access import Client
from woosh_pure.web.api.dependencies import (
    CREATED,
    PROBLEMS,
    check_command,
    client_of,
    context_of,
    name_of,
    note_arrival,
    problems,
    refuse_null,
    robot_of,
)
from woosh_pure.web.goals import Goal, command
from woosh_pure.web.http_errors import Problem, worded
from woosh_pure.web.recordings import Recording
from woosh_pure.web.robot import Robot
from woosh_pure.web.snapshot import lease_part

# -- goals: POST and GET; waiting for, cancelling, deleting, pausing and resuming one ------------------------

goals = APIRouter(tags=["goals"], responses=PROBLEMS)
_GOAL_PROBLEMS = problems(409, 501)
KEY_USED: dict[int | str, dict[str, object]] = {
    422: {**problems(422)[422], "description": "not as described, or another request had this key"}
}
CANCEL_SECONDS = 2.0
"""Seconds for which a cancel waits until the robot confirms."""
_NO_NULL = [Depends(refuse_null)]
Key = Annotated[
    str | None,
    Header(
        alias="Idempotency-Key",
        min_length=1,
        max_length=200,
        description="of your choice, new for each goal: the same request with the same key gets the first "
        "answer, and nothing moves again; another request with it is refused with 422. The last 1000 "
        "keys are known, until the server ends",
    ),
]


@goals.post(
    "/goals",
    status_code=201,
    response_model=models.Goal,
    responses={**CREATED, **_GOAL_PROBLEMS, **KEY_USED},
    dependencies=[Depends(note_arrival)],
)
def create_goal(
    body: models.GoalRequest, request: Request, response: Response, key: Key = None
) -> dict[str, object]:
    """Start a motion. It does not depend on this connection: it ends when done, cancelled, or timed out."""
    robot, client = check_command(request, lease=False)
    with request.state.call:
        goal = answered_once(robot, client, key, body, partial(_begin, robot, client, body))
    response.headers["location"] = f"{request.url.path}/{goal['id']}"
    return worded(goal, request.headers)


def answered_once(
    robot: Robot, client: Client, key: str | None, body: BaseModel, begin: Callable[[], dict[str, object]]
) -> dict[str, object]:
    """Return what `begin` returns, or the first answer to this request if its key is known."""
    if key is None:
        return begin()
    return robot.idempotent_answers.give(client.name, key.strip('"'), body.model_dump_json(), begin)


def _begin(robot: Robot, client: Client, body: models.GoalRequest) -> dict[str, object]:
    robot.require_lease(client)
    return robot.begin_goal(body, client.name).as_json()


@goals.get("/goals", response_model=list[models.Goal])
def list_goals(request: Request) -> list[dict[str, object]]:
    """The last goals, the oldest first."""
    return worded([goal.as_json() for goal in robot_of(request).goals.all()], request.headers)


@goals.get("/goals/{goal}", response_model=models.Goal)
def get_goal(goal: str, request: Request) -> dict[str, object]:
    """One goal by its id."""
    return worded(robot_of(request).goals.get(goal).as_json(), request.headers)


@goals.get("/goals/{goal}/wait", response_model=models.Goal)
async def wait_for_goal(
    goal: str, request: Request, timeout: float = Query(30.0, gt=0.0, le=300.0)
) -> dict[str, object]:
    """Wait until the goal has ended or the time is up; `done` tells which."""
    found, until = robot_of(request).goals.get(goal), time.monotonic() + timeout
    while not found.done and time.monotonic() < until:
        if context_of(request).closed or await request.is_disconnected():
            break
        await asyncio.sleep(0.05)
    return worded(await run_in_threadpool(found.as_json), request.headers)


@goals.post("/goals/{goal}/cancel", response_model=models.Goal, responses=problems(409))
def cancel_goal(goal: str, request: Request) -> dict[str, object]:
    """Cancel the goal, and wait until the robot confirms. It may have arrived meanwhile."""
    return worded(_cancelled(goal, request).as_json(), request.headers)


@goals.delete(
    "/goals/{goal}",
    response_model=models.Goal,
    responses={
        202: {"model": models.Goal, **CREATED[201], "description": "not confirmed yet"},
        **problems(409),
    },
)
def delete_goal(goal: str, request: Request, response: Response) -> dict[str, object]:
    """Cancel the goal if it is under way, and forget it. 202 if the robot has not confirmed yet: then the
    goal is still there, and another DELETE is needed.
    """
    found = _cancelled(goal, request)
    if found.done:
        robot_of(request).goals.remove(found.id)
    else:
        response.status_code = 202
        response.headers["location"] = request.url.path
    return worded(found.as_json(), request.headers)


def _cancelled(number: str, request: Request) -> Goal:
    robot = robot_of(request)
    found = robot.goals.get(number)
    if not found.done:
        robot.journal.note(name_of(request), command("cancel", goal=found.id))
        found.handle.cancel()
        found.ended.wait(CANCEL_SECONDS)
    return found


@goals.post("/goals/{goal}/pause", response_model=models.Goal, responses=_GOAL_PROBLEMS)
def pause_goal(goal: str, request: Request) -> dict[str, object]:
    """Pause the goal."""
    return _hold(goal, request, "pause")


@goals.post("/goals/{goal}/resume", response_model=models.Goal, responses=_GOAL_PROBLEMS)
def resume_goal(goal: str, request: Request) -> dict[str, object]:
    """Resume a paused goal."""
    return _hold(goal, request, "resume")


def _hold(number: str, request: Request, verb: str) -> dict[str, object]:
    robot, client = check_command(request, lease=verb == "resume")
    goal = robot.goals.get(number)
    act = getattr(goal.handle, verb, None)
    if act is None:
        text = "{description}: this kind of goal cannot be paused; cancel it"
        raise Problem(409, text, "no-pause", description=goal.handle.description)
    if goal.done:
        raise Problem(
            409, "{description}: it has ended already", "ended", description=goal.handle.description
        )
    act()
    goal.paused = verb == "pause"
    robot.journal.note(client.name, command(verb, goal=goal.id))
    return worded(goal.as_json(), request.headers)


# -- lease: GET, POST and DELETE; POST lease/grant -----------------------------------------------------------

lease = APIRouter(tags=["lease"], responses=PROBLEMS)


@lease.get("/lease", response_model=models.LeaseAnswer, responses=problems(403))
def get_lease(request: Request) -> dict[str, object]:
    """The holder of the lease, and the clients that have requested it."""
    state = robot_of(request).chassis.lease.state
    return lease_part(state, mine=client_of(request).name, is_page=context_of(request).clients.is_page)


@lease.post("/lease", response_model=models.LeaseAnswer, responses=problems(409), dependencies=_NO_NULL)
def ask_for_lease(request: Request, body: models.LeaseRequest | None = None) -> dict[str, object]:
    """Take the lease if it is free, or renew it. Otherwise its holder is asked; `yours` tells which. A
    program does not answer: who has asked it takes the lease over by a second request that says so.
    """
    robot, client = check_command(request, lease=False, connected=False)
    lease, body = robot.chassis.lease, body or models.LeaseRequest()
    if body.take_over:
        context_of(request).take_over(robot, client.name, body.seconds)
    elif not lease.acquire(client.name, body.seconds):
        lease.request(client.name)
    return get_lease(request)


@lease.delete("/lease", response_model=models.LeaseAnswer)
def give_lease_back(request: Request) -> dict[str, object]:
    """Give the lease back, or withdraw the request for it. Who has neither gets the same answer."""
    robot, client = robot_of(request), client_of(request)
    robot.chassis.lease.release(client.name)
    if robot.manual_drive.driver == client.name:
        robot.manual_drive.halt("the lease was given back")
    return get_lease(request)


@lease.post("/lease/grant", response_model=models.LeaseAnswer, responses=problems(409), dependencies=_NO_NULL)
def grant_lease(request: Request, body: models.GrantRequest | None = None) -> dict[str, object]:
    """Grant the lease to a client that has requested it."""
    robot, client = robot_of(request), client_of(request)
    lease = robot.chassis.lease
    to = (None if body is None else body.to) or next(iter(lease.state.asking), "")
    if not lease.grant(client.name, to):
        raise Problem(409, "the lease is not yours to grant, or nobody of that name asks for it", "lease")
    if robot.manual_drive.driver == client.name:
        robot.manual_drive.halt("the lease was handed over")
    return get_lease(request)


# -- recordings: GET, POST and DELETE; the end of one; the download of a bag ---------------------------------

recordings = APIRouter(tags=["recordings"], responses=PROBLEMS)
_BAG: dict[int | str, dict[str, object]] = {
    200: {"content": {"application/octet-stream": {}}, "description": "a bag"}
}


@recordings.get("/recordings", response_model=list[models.Recording])
def list_recordings(request: Request) -> list[dict[str, object]]:
    """The recordings of this server, the oldest first."""
    return worded([one.as_json() for one in robot_of(request).recordings.all()], request.headers)


@recordings.post(
    "/recordings",
    status_code=201,
    response_model=models.Recording,
    responses={**CREATED, **problems(409)},
    dependencies=_NO_NULL,
)
def create_recording(
    request: Request, response: Response, body: models.RecordingRequest | None = None
) -> dict[str, object]:
    """Start a recording: one at a time, for an hour or 1 GiB at most."""
    robot, client = check_command(request, lease=False)
    body = body or models.RecordingRequest()
    found = robot.recordings.begin(client.name, body.seconds, body.camera)
    robot.journal.note(client.name, command("record", recording=found.id), "begun")
    response.headers["location"] = f"{request.url.path}/{found.id}"
    return worded(found.as_json(), request.headers)


@recordings.get("/recordings/{recording}", response_model=models.Recording)
def get_recording(recording: str, request: Request) -> dict[str, object]:
    """One recording by its id."""
    return worded(robot_of(request).recordings.get(recording).as_json(), request.headers)


@recordings.post("/recordings/{recording}/end", response_model=models.Recording)
def end_recording(recording: str, request: Request) -> dict[str, object]:
    """End the recording. Its bag is kept, and can be downloaded."""
    robot, client = robot_of(request), client_of(request)
    running = robot.recordings.get(recording).running
    found = robot.recordings.end(recording)
    if running:
        robot.journal.note(client.name, command("end_record", recording=found.id))
    return worded(found.as_json(), request.headers)


@recordings.delete("/recordings/{recording}", response_model=models.Recording, responses=problems(409))
def delete_recording(recording: str, request: Request) -> dict[str, object]:
    """Delete the recording and its bag. Refused while it runs: POST `end` ends it."""
    robot, client = robot_of(request), client_of(request)
    found = robot.recordings.get(recording)
    if found.running:
        raise _runs(found)
    robot.recordings.remove(recording)
    robot.journal.note(client.name, command("delete_record", recording=found.id))
    return worded(found.as_json(), request.headers)


def _runs(recording: Recording) -> Problem:
    return Problem(409, "recording {id} is still running; end it first", "recording", id=recording.id)


@recordings.get(
    "/recordings/{recording}/bag", response_class=FileResponse, responses={**_BAG, **problems(409)}
)
def download(recording: str, request: Request) -> FileResponse:
    """Download the bag of a finished recording."""
    found = robot_of(request).recordings.get(recording)
    if found.running:
        raise _runs(found)
    if not found.path.is_file():
        raise Problem(404, "the bag of recording {id} no longer exists", id=found.id)
    return FileResponse(found.path, filename=found.path.name, media_type="application/octet-stream")


# -- simulator: POST -----------------------------------------------------------------------------------------

simulator = APIRouter(tags=["simulator"], responses=PROBLEMS)


@simulator.post("/simulator", status_code=204, responses=problems(409))
def change_simulation(body: models.SimulatorRequest, request: Request) -> None:
    """Change a simulated robot and what is around it. Needs no lease: anybody in a room can press the
    emergency stop, or stand in the way.
    """
    robot, client = check_command(request, lease=False, connected=False)
    if robot.simulator is None:
        text = "no simulation is behind this robot; `woosh --sim web` serves one, web.app takes simulator="
        raise Problem(409, text, "no-simulator")
    body.apply(robot.simulator)
    robot.journal.note(client.name, command("simulate", changes=body.model_dump_json(exclude_none=True)))
