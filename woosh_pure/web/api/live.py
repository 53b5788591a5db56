"""The WebSocket of the page."""

from __future__ import annotations

from typing import cast

from fastapi import APIRouter, WebSocket

from woosh_pure.web.context import WebContext
from woosh_pure.web.live.viewer import Viewer
from woosh_pure.web.problems import Problem

__all__ = ["router"]

router = APIRouter()
MOST_VIEWERS = 64


async def live(socket: WebSocket) -> None:
    """Serve one viewer until it disconnects."""
    context = cast(WebContext, socket.app.state.context)
    try:
        robot = context.robot(socket.path_params.get("robot"))
    except Problem as problem:
        await _refuse(socket, 4404, problem.text)
        return
    address = socket.client.host if socket.client else "an unknown address"
    if context.viewers >= MOST_VIEWERS:
        await _refuse(socket, 4429, f"{MOST_VIEWERS} look already; close a page first")
        return
    client = context.clients.connect(address, socket.query_params.get("session", "")[:100])
    if client is None:
        await _refuse(socket, 4429, "too many pages; close one first")
        return
    context.viewers += 1
    try:
        await socket.accept()
        asked = socket.headers.get("accept-language", "").strip().lower()
        await Viewer(socket, context, context.hubs[robot.name], client).run(
            "zh" if asked.startswith("zh") else "en"
        )
    finally:
        context.viewers -= 1
        context.clients.disconnect(client)


async def _refuse(socket: WebSocket, code: int, reason: str) -> None:
    await socket.accept()
    await socket.close(code, reason[:120])


router.add_api_websocket_route("/live", live)
