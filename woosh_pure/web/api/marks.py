"""The routes of the list of marks. None of them moves the robot."""

from __future__ import annotations

from urllib.parse import quote

from fastapi import APIRouter, Path, Request, Response

from rosproto.sentence import say
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.marks import UserMark
from woosh_pure.reasons import ReasonKey
from woosh_pure.web import models
from woosh_pure.web.api.dependencies import CREATED, PROBLEMS, check_command, problems, robot_of
from woosh_pure.web.goals import command
from woosh_pure.web.http_errors import Problem
from woosh_pure.web.marks import mark_part
from woosh_pure.web.robot import Robot
from woosh_pure.web.robot_site import FIRST_SECONDS

router = APIRouter(tags=["marks"], responses=PROBLEMS)
_CHANGES = problems(409)
HERE_SECONDS = 3.0
"""Seconds to wait for the robot's pose."""
_NAME = Path(max_length=200, description="name of a mark of this list")


@router.get("/marks", response_model=list[models.Mark])
def get_marks(request: Request) -> list[dict[str, object]]:
    """The marks of this server's list, and those that the robot itself names, which are read only."""
    return [mark_part(mark) for mark in robot_of(request).all_marks(FIRST_SECONDS)]


@router.post("/marks", status_code=201, response_model=models.Mark, responses={**CREATED, **_CHANGES})
def create_mark(body: models.MarkRequest, request: Request, response: Response) -> dict[str, object]:
    """Save a mark: where the robot stands (`here`), at x and y, or by the name of a mark of the chassis."""
    robot, client = check_command(request, lease=False, connected=False)
    pose = _pose(robot, body, Pose2D(0.0, 0.0))
    mark = robot.marks.add(UserMark(body.name, pose, body.note, body.charger, body.on_chassis))
    robot.journal.note(client.name, command("save_mark", mark=mark.name))
    response.headers["location"] = f"{request.url.path.rstrip('/')}/{quote(mark.name, safe='')}"
    return mark_part(mark)


@router.get("/marks/{mark:path}", response_model=models.Mark)
def get_mark(request: Request, mark: str = _NAME) -> dict[str, object]:
    """One mark by its name."""
    robot = robot_of(request)
    return mark_part(robot.find_mark(mark) or robot.marks.get(mark))


@router.patch("/marks/{mark:path}", response_model=models.Mark, responses=_CHANGES)
def change_mark(body: models.MarkChange, request: Request, mark: str = _NAME) -> dict[str, object]:
    """Rename a mark, move it, or change its note. Fields that are not given stay."""
    robot, client = check_command(request, lease=False, connected=False)
    changes = body.model_dump(include={"name", "note", "charger", "on_chassis"}, exclude_none=True)
    old = robot.marks.find(mark)
    pose = _pose(robot, body, (old and old.pose) or Pose2D(0.0, 0.0))
    if pose is not None:
        changes["pose"] = pose
    changed = robot.marks.change(mark, changes)
    robot.journal.note(
        client.name, command("change_mark", mark=mark), text=say("now {name}", name=changed.name)
    )
    return mark_part(changed)


@router.delete("/marks/{mark:path}", status_code=204, responses=_CHANGES)
def delete_mark(request: Request, mark: str = _NAME) -> None:
    """Remove a mark from the list. The chassis's own map is not changed."""
    robot, client = check_command(request, lease=False, connected=False)
    robot.marks.remove(mark)
    robot.journal.note(client.name, command("delete_mark", mark=mark))


def _pose(robot: Robot, body: models.MarkRequest | models.MarkChange, old: Pose2D) -> Pose2D | None:
    """Return the pose in a request; None if there is none. `here` waits for the robot's pose."""
    given = [value is not None for value in (body.x, body.y, body.yaw)]
    if body.here:
        if any(given):
            raise Problem(422, "here: true is where the robot stands; leave out x, y and yaw", "invalid")
        return _here(robot)
    if not any(given):
        return None
    if body.x is None or body.y is None:
        raise Problem(422, "x and y belong together: give both", "invalid")
    yaw = old.yaw if body.yaw is None else body.yaw
    return Pose2D(body.x, body.y, yaw).require_sensible()


def _here(robot: Robot) -> Pose2D:
    """Return the robot's pose; refuse if it is not localised."""
    robot.require_connection()
    robot.listen()
    here: Pose2D = robot.feed("pose").wait(HERE_SECONDS)
    for reason in robot.chassis.readiness().reasons:
        if reason.key is ReasonKey.NOT_LOCALISED:
            raise Problem(409, reason.text, "not-localised")
    return here.require_sensible()
