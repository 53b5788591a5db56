"""POST stop, and POST pose. A stop is carried out before its request is validated.

Every client with access to the server (token, `Host`, `Origin`) may stop, also with an unknown session, an
odd path or method, or an invalid or missing body. The goals of this server are stopped before the body is
read. Those of others are stopped, too, unless the body excludes them in time.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import Future

from fastapi import APIRouter, Request, Response
from fastapi.responses import JSONResponse
from pydantic import ValidationError
from starlette.types import Receive, Scope, Send

from rosproto.sentence import say
from woosh_pure.geometry import Pose2D
from woosh_pure.stopping.report import StopReport
from woosh_pure.web import models
from woosh_pure.web.api.dependencies import PROBLEMS, check_command, context_of, name_of, problems
from woosh_pure.web.goals import command
from woosh_pure.web.http_errors import MEDIA_TYPE, Problem, worded
from woosh_pure.web.middleware import MAX_BODY
from woosh_pure.web.robot import Robot
from woosh_pure.web.snapshot import stop_part
from woosh_pure.web.validation_errors import refusal

router = APIRouter(tags=["stop"], responses=PROBLEMS)
_BODY = {"content": {"application/json": {"schema": {"$ref": "#/components/schemas/StopRequest"}}}}
BODY_SECONDS = 0.5
"""Seconds to wait for the body to exclude goals; then everything is stopped."""
REST_SECONDS = 10.0
"""Seconds to read the rest of a body after its answer was sent."""
ANSWER_SECONDS = 30.0
"""Seconds after which a stop is answered even without a result."""


@router.post(
    "/stop", response_model=models.StopAnswer, responses=problems(422), openapi_extra={"requestBody": _BODY}
)
async def stop(request: Request) -> Response:
    """Stop the robot. Needs no lease and is not limited. This is NO emergency stop; the answer tells whether
    the robot stands still. It stops whatever the request looks like, and complains afterwards.
    """
    robots, complaint = _meant(request)
    name, body = name_of(request), _Body(request)
    begun = [] if body.is_absent else [robot.begin_stop(name, everything=False) for robot in robots]
    if await body.asks_for_everything():
        begun += [robot.begin_stop(name) for robot in robots]
    try:
        report = await _over(begun)
    except BaseException:
        body.close()
        raise
    complaint = complaint or _of_method(request) or body.complaint()
    if complaint is None:
        return JSONResponse(worded(stop_part(report), request.headers))
    complaint.text = say(
        "stopped anyway: {report}; but {complaint}",
        report=str(report),
        complaint=say(complaint.text),
    )
    document = worded({**stop_part(report), **complaint.document(request.url.path)}, request.headers)
    headers = {"connection": "close"} if complaint.status in (408, 413) else {}
    if complaint.status == 405:
        headers["allow"] = "POST"
    return _AnswerBeforeBody(body, document, complaint.status, headers)


def _meant(request: Request) -> tuple[list[Robot], Problem | None]:
    """Return the robot to stop; all robots if the path's name is unknown: it may have been renamed."""
    context = context_of(request)
    try:
        return [context.robot(request.path_params.get("robot"))], None
    except Problem as problem:
        return list(context.robots.values()), problem


def _of_method(request: Request) -> Problem | None:
    method = request.scope.get("woosh.method", "POST")
    if method == "POST":
        return None
    return Problem(405, "this address accepts {methods}, not {method}", methods="POST", method=method[:20])


async def _over(begun: list[Future[StopReport]]) -> StopReport:
    """Return the combined result of these stops.

    Raises:
        Problem: There is no result in time.
    """
    done, late = await asyncio.wait(map(asyncio.wrap_future, begun), timeout=ANSWER_SECONDS)
    if late:
        raise Problem(
            504, "the stop was sent, but is not confirmed: watch the robot, and use its emergency stop button"
        )
    reports = [one.result() for one in done]
    standing = [report.standing for report in reports]
    return StopReport(
        False if False in standing else None if None in standing else True,
        _each(reports, lambda report: report.cancelled),
        _each(reports, lambda report: report.problems),
        any(report.looked for report in reports),
    )


def _each(reports: list[StopReport], part: Callable[[StopReport], list[str]]) -> list[str]:
    return list(dict.fromkeys(text for report in reports for text in part(report)))


class _AnswerBeforeBody(JSONResponse):
    """Reads the rest of the body after the answer: closing the connection earlier would reset it, and the
    client might lose the answer.
    """

    media_type = MEDIA_TYPE

    def __init__(
        self, body: _Body, document: dict[str, object], status: int, headers: dict[str, str]
    ) -> None:
        super().__init__(document, status, headers)
        self._rest = body

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """See Starlette."""
        head = {"type": "http.response.start", "status": self.status_code, "headers": self.raw_headers}
        await send(head)
        await send({"type": "http.response.body", "body": self.body, "more_body": True})
        await self._rest.ends(REST_SECONDS)
        await send({"type": "http.response.body", "body": b""})


class _Body:
    """The body of a stop, read while the robot is being stopped. Only its beginning is kept."""

    def __init__(self, request: Request) -> None:
        headers = request.headers
        self.is_absent = headers.get("content-length", "0") == "0" and "transfer-encoding" not in headers
        kind = headers.get("content-type", "").partition(";")[0].strip().lower()
        self._is_json = kind == "application/json"
        self._text = b""
        self._reading = asyncio.ensure_future(self._read(request.receive))

    async def _read(self, receive: Receive) -> None:
        more = not self.is_absent
        while more:
            message = await receive()
            self._text = (self._text + message.get("body", b""))[: MAX_BODY + 1]
            more = bool(message.get("more_body", False))

    async def asks_for_everything(self) -> bool:
        """Whether to stop goals of others, too: true unless the body excludes them in time."""
        await asyncio.wait([self._reading], timeout=BODY_SECONDS)
        if not self._reading.done() or not self._is_json or not 0 < len(self._text) <= MAX_BODY:
            return True
        try:
            return self._request().everything
        except ValidationError:
            return True

    def _request(self) -> models.StopRequest:
        return models.StopRequest.model_validate_json(self._text)

    def complaint(self) -> Problem | None:
        """Return the error in the body; None if it is valid."""
        if len(self._text) > MAX_BODY:
            return Problem(413, "the body is larger than {maximum} bytes", maximum=MAX_BODY)
        if not self._reading.done():
            return Problem(408, "the body did not arrive")
        if not self._text:
            return None
        if not self._is_json:
            return Problem(422, "the body is not sent as content-type: application/json", "invalid")
        try:
            self._request()
        except ValidationError as error:
            schema = models.StopRequest.model_json_schema()
            return Problem(422, refusal(error.errors(), schema, {}), "invalid")
        return None

    async def ends(self, seconds: float) -> None:
        """Wait until the body is complete, or the time is over."""
        try:
            await asyncio.wait([self._reading], timeout=seconds)
        finally:
            self.close()

    def close(self) -> None:
        """Stop reading the body."""
        self._reading.cancel()


@router.post("/pose", response_model=models.Pose, responses=problems(409))
def set_pose(body: models.PoseRequest, request: Request) -> dict[str, object]:
    """Tell the robot where it is, for example after power-up."""
    robot, client = check_command(request)
    pose = Pose2D(body.x, body.y, body.yaw).require_sensible()
    entry = robot.journal.begin(client.name, command("set_pose", x=pose.x, y=pose.y, yaw=pose.yaw))
    try:
        robot.chassis.set_pose(pose)
    except Exception as error:
        robot.journal.end(entry, "failed", str(error))
        raise
    robot.journal.end(entry, "sent", say("whether it has found itself there is told by its readiness"))
    return {"x": pose.x, "y": pose.y, "yaw": pose.yaw}
