"""GET, POST and DELETE recordings, and the download of a bag."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import FileResponse

from woosh_pure.web import models
from woosh_pure.web.api.dependencies import PROBLEMS, check_command, client_of, problems, robot_of
from woosh_pure.web.problems import Problem

__all__ = ["router"]

router = APIRouter(tags=["recordings"], responses=PROBLEMS)
_BAG: dict[int | str, dict[str, Any]] = {
    200: {"content": {"application/octet-stream": {}}, "description": "a bag"}
}


def list_recordings(request: Request) -> list[dict[str, Any]]:
    """The recordings of this server, the oldest first."""
    return [one.as_json() for one in robot_of(request).recordings.all()]


def create_recording(request: Request, body: models.RecordingRequest | None = None) -> dict[str, Any]:
    """Start a recording: one at a time, for an hour or 1 GiB at most."""
    robot, client = check_command(request, lease=False)
    body = body or models.RecordingRequest()
    found = robot.recordings.begin(client.name, body.seconds, body.camera)
    robot.journal.note(client.name, f"record bag {found.id}", "begun")
    return found.as_json()


def get_recording(recording: str, request: Request) -> dict[str, Any]:
    """One recording by its id."""
    return robot_of(request).recordings.get(recording).as_json()


def end_recording(recording: str, request: Request) -> dict[str, Any]:
    """End the recording. Its bag is kept, and can be downloaded."""
    robot, client = robot_of(request), client_of(request)
    running = robot.recordings.get(recording).running
    found = robot.recordings.end(recording)
    if running:
        robot.journal.note(client.name, f"end bag {found.id}")
    return found.as_json()


def download(recording: str, request: Request) -> FileResponse:
    """Download the bag of a finished recording."""
    found = robot_of(request).recordings.get(recording)
    if found.running:
        raise Problem(409, f"recording {found.id} still runs; end it first", "recording")
    if found.ended is None:
        found = robot_of(request).recordings.end(recording)
    if not found.path.is_file():
        raise Problem(404, f"the bag of recording {found.id} is not there any more")
    return FileResponse(found.path, filename=found.path.name, media_type="application/octet-stream")


add = router.add_api_route
add("/recordings", list_recordings, response_model=list[models.Recording])
add(
    "/recordings",
    create_recording,
    methods=["POST"],
    status_code=201,
    response_model=models.Recording,
    responses=problems(409, 422, 429),
)
add("/recordings/{recording}", get_recording, response_model=models.Recording)
add("/recordings/{recording}", end_recording, methods=["DELETE"], response_model=models.Recording)
add("/recordings/{recording}/bag", download, response_class=FileResponse, responses=_BAG)
