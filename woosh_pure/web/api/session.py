"""The routes of the log-in, whose cookie scripts cannot read, and of a page's live connection."""

from __future__ import annotations

import io
import time
from typing import cast

from fastapi import APIRouter, Request, Response, WebSocket

from woosh_pure.web import models
from woosh_pure.web.api.dependencies import address_of, context_of, problems
from woosh_pure.web.context import WebContext
from woosh_pure.web.http_errors import Problem
from woosh_pure.web.live.viewer import Viewer
from woosh_pure.web.middleware import check_access, login_place, problem_of_refusal
from woosh_pure.web.optional_libraries import segno

# -- GET access, POST and DELETE login -----------------------------------------------------------------------

login = APIRouter(tags=["access"])


@login.get("/access", response_model=models.AccessAnswer)
def get_access(request: Request) -> dict[str, object]:
    """Whether a token is needed, and what this client may do. Needs no token itself."""
    context = context_of(request)
    refusal = check_access(context.access, request.scope, request.headers, address_of(request))
    return {
        "needs_token": context.access.needs_token,
        "logged_in": refusal is None,
        "allow_driving": context.allow_driving,
        "robots": list(context.robots) if refusal is None else [],
    }


@login.post("/login", response_model=models.Answer, responses=problems(401))
def log_in(body: models.LoginRequest, request: Request, response: Response) -> dict[str, object]:
    """Log this browser in: it keeps a cookie, good for this port as long as the token is."""
    context = context_of(request)
    refusal = problem_of_refusal(
        context.access.check_token(body.token, address_of(request), time.monotonic())
    )
    if refusal is not None:
        raise refusal
    name, place = login_place(request.scope, request.headers)
    response.set_cookie(
        name,
        context.access.log_in(place),
        path=_path(request),
        httponly=True,
        samesite="strict",
        secure="https" in (request.url.scheme, request.headers.get("origin", "").partition(":")[0]),
    )
    return {"logged_in": True}


@login.delete("/login", response_model=models.Answer)
def log_out(request: Request, response: Response) -> dict[str, object]:
    """Log this browser out: its cookie is deleted."""
    response.delete_cookie(login_place(request.scope, request.headers)[0], path=_path(request))
    return {"logged_in": False}


_SVG: dict[int | str, dict[str, object]] = {
    200: {"content": {"image/svg+xml": {}}, "description": "black on white"}
}


@login.post("/qr", response_class=Response, responses=_SVG)
def draw_qr(body: models.QrRequest) -> Response:
    """A QR code of a text, such as this server's address for a phone. Nothing of the text is kept."""
    out = io.BytesIO()
    segno().make(body.text, micro=False).save(out, kind="svg", scale=8, light="white")
    return Response(out.getvalue(), media_type="image/svg+xml")


def _path(request: Request) -> str:
    return str(request.scope.get("root_path", "")) or "/"


# -- the WebSocket of the page -------------------------------------------------------------------------------

viewers = APIRouter()


@viewers.websocket("/live")
async def live(socket: WebSocket) -> None:
    """Serve one viewer until it disconnects."""
    context = cast(WebContext, socket.app.state.context)
    try:
        robot = context.robot(socket.path_params.get("robot"))
    except Problem as problem:
        await _refuse(socket, 4404, problem.text)
        return
    address = socket.client.host if socket.client else "an unknown address"
    if context.viewers >= context.max_viewers:
        await _refuse(socket, 4429, f"{context.max_viewers} look already; close a page first")
        return
    client = context.clients.connect(address, socket.query_params.get("session", "")[:100])
    if client is None:
        await _refuse(socket, 4429, "too many pages; close one first")
        return
    viewer = Viewer(socket, context, context.hubs[robot.name], client)
    context.viewers += 1
    try:
        await socket.accept()
        await viewer.run()
    finally:
        context.viewers -= 1
        if not viewer.is_replaced:
            context.clients.disconnect(client)


async def _refuse(socket: WebSocket, code: int, reason: str) -> None:
    await socket.accept()
    await socket.close(code, reason[:120])
