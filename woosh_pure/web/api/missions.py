"""The routes of missions: the files of the server's folder, the runs, and the queue.

A start needs what a goal needs. A stop needs no lease and is not refused; nor does an answer or a pause need
one, because the mission holds it.
"""

from __future__ import annotations

from functools import partial
from typing import Any, Literal

from fastapi import APIRouter, Depends, Path, Request, Response

from rosproto.logs import get_logger
from woosh_pure.missions import KINDS, STEP_KEYS
from woosh_pure.web import mission_models as models
from woosh_pure.web.access import Client
from woosh_pure.web.api import dependencies
from woosh_pure.web.api.commands import KEY_USED, Key, answered_once
from woosh_pure.web.api.dependencies import CREATED, PROBLEMS, check_command, problems, robot_of
from woosh_pure.web.api.readings import EVENTS, EventStream
from woosh_pure.web.goals import command
from woosh_pure.web.http_errors import Problem, worded
from woosh_pure.web.missions import file_part
from woosh_pure.web.robot import Robot
from woosh_pure.web.snapshot import plain

_logger = get_logger("woosh_pure.web")
router = APIRouter(tags=["missions"], responses=PROBLEMS)
_CHANGES = problems(409)
# Within the call that it notes, a stop since the request has arrived refuses what would let a mission go on.
_ARRIVAL = [Depends(dependencies.note_arrival)]
_FILE = Path(max_length=100, description="name of a file of the folder, without .mission.toml")

# -- files: GET, PUT and DELETE ------------------------------------------------------------------------------


@router.get("/missions", response_model=models.MissionFolder)
def list_missions(request: Request) -> dict[str, Any]:
    """The missions of the server's folder, and the keys of each kind of step, and those of every step."""
    files = [file_part(one) for one in robot_of(request).chassis.missions.list()]
    kinds = {name: plain(keys) for name, keys in KINDS.items()}
    return worded({"missions": files, "kinds": kinds, "common": plain(STEP_KEYS)}, request.headers)


@router.get("/missions/{file}", response_model=models.MissionFile)
def get_mission(request: Request, file: str = _FILE) -> dict[str, Any]:
    """One mission."""
    return worded(file_part(robot_of(request).missions.file(file)), request.headers)


@router.put("/missions/{file}", response_model=models.MissionFile)
def save_mission(body: models.MissionRequest, request: Request, file: str = _FILE) -> dict[str, Any]:
    """Save a mission, new or instead of the old one. A faulty one is refused with the path of its fault."""
    robot, client = check_command(request, lease=False, connected=False)
    try:
        saved = robot.chassis.missions.save(file, body.mission)
    except OSError as error:
        _logger.error("! mission %s cannot be saved: %s", file, error)
        text = "mission {file!r} cannot be saved; the log of the server says why"
        raise Problem(503, text, "mission-not-kept", file=file) from error
    robot.journal.note(client.name, command("save_mission", mission=file))
    return worded(file_part(saved), request.headers)


@router.delete("/missions/{file}", status_code=204, responses=_CHANGES)
def delete_mission(request: Request, file: str = _FILE) -> None:
    """Delete a mission's file. A run of it goes on."""
    robot, client = check_command(request, lease=False, connected=False)
    robot.chassis.missions.remove(robot.missions.file(file).file)
    robot.journal.note(client.name, command("delete_mission", mission=file))


# -- runs: GET and POST; DELETE and PATCH in the queue; answering one ----------------------------------------


@router.get("/mission-runs", response_model=models.MissionRuns)
def list_runs(request: Request) -> dict[str, Any]:
    """The last runs, the one under way, and the queue, in this order."""
    return worded(robot_of(request).missions.part(), request.headers)


@router.get("/mission-events", response_class=Response, responses=EVENTS)
def stream_runs(request: Request) -> Response:
    """The same as Server-Sent Events: one at once, and one after each step, question and end."""
    source, context = robot_of(request).missions, dependencies.context_of(request)
    return EventStream(context, "missions", source, lambda: worded(source.part(), request.headers), 4.0)


@router.post(
    "/mission-runs",
    status_code=201,
    response_model=models.MissionRun,
    responses={**CREATED, **problems(404, 409), **KEY_USED},
    dependencies=_ARRIVAL,
)
def create_run(
    body: models.MissionStart, request: Request, response: Response, key: Key = None
) -> dict[str, Any]:
    """Start a mission, or append it to the queue while another one is there. It depends on no connection."""
    robot, client = check_command(request, lease=False)
    run = answered_once(robot, client, key, body, partial(_begin, robot, client, body, request))
    response.headers["location"] = f"{request.url.path}/{run['id']}"
    return worded(run, request.headers)


def _begin(robot: Robot, client: Client, body: models.MissionStart, request: Request) -> dict[str, Any]:
    missions, stored = robot.chassis.missions, robot.missions.file(body.file)
    if stored.mission is None:
        raise Problem(409, stored.error, "mission")
    begin = missions.append
    if not (missions.state.active or missions.state.queue):
        robot.require_lease(client)
        begin = missions.run
    with request.state.call:
        return robot.missions.run(begin(stored.mission, body.parameters, by=client.name).id)


@router.get("/mission-runs/{run}", response_model=models.MissionRun)
def get_run(run: str, request: Request) -> dict[str, Any]:
    """One run by its id."""
    return worded(robot_of(request).missions.run(run), request.headers)


@router.delete("/mission-runs/{run}", status_code=204, responses=_CHANGES)
def remove_run(run: str, request: Request) -> None:
    """Take a mission out of the queue. One that has begun is ended by POST `stop`."""
    robot, client = check_command(request, lease=False, connected=False)
    robot.chassis.missions.unqueue(robot.missions.run(run)["id"], by=client.name)


@router.patch("/mission-runs/{run}", response_model=models.MissionRuns, responses=_CHANGES)
def move_run(run: str, body: models.MissionPlace, request: Request) -> dict[str, Any]:
    """Move a mission to another place in the queue."""
    robot, client = check_command(request, lease=False, connected=False)
    robot.chassis.missions.reorder(robot.missions.run(run)["id"], int(body.place), by=client.name)
    return list_runs(request)


@router.post(
    "/mission-runs/{run}/answer", response_model=models.MissionRun, responses=_CHANGES, dependencies=_ARRIVAL
)
def answer_run(run: str, body: models.MissionAnswer, request: Request) -> dict[str, Any]:
    """Answer the question of a run; with `step`, only that of this step."""
    robot, client = check_command(request, lease=False, connected=False)
    if body.step not in (None, robot.missions.run(run)["step"]):
        raise Problem(409, "this question was answered already; another step is under way", "answered")
    with request.state.call:
        robot.chassis.missions.answer(body.answer, by=client.name, run=run)
    robot.journal.note(client.name, command("answer_mission", answer=body.answer))
    return get_run(run, request)


@router.post(
    "/mission-queue/{verb}", response_model=models.MissionRuns, responses=_CHANGES, dependencies=_ARRIVAL
)
def control_queue(verb: Literal["pause", "resume", "stop", "clear"], request: Request) -> dict[str, Any]:
    """Pause, resume or stop the run under way and the queue, or clear the queue. `stop` ends the run, stops
    the robot and pauses the queue; it is not refused. `resume` also lets an interrupted run go on.
    """
    robot, who = robot_of(request), dependencies.name_of(request)
    if verb != "stop":
        _, client = check_command(request, lease=False, connected=False)
        if verb == "resume" and robot.chassis.lease.holder != robot.chassis.missions.owner:
            robot.require_lease(client)
            robot.chassis.lease.release(client.name)  # for the mission
    with request.state.call:
        getattr(robot.chassis.missions, verb)(by=who)
    robot.journal.note(who, command(f"{verb}_missions"))
    return list_runs(request)
