"""The WebSocket of the page."""

from __future__ import annotations

from typing import cast

from fastapi import APIRouter, WebSocket

from woosh_pure.web.context import House
from woosh_pure.web.live.viewer import Session
from woosh_pure.web.problems import Problem

__all__ = ["router"]

router = APIRouter()
MOST_VIEWERS = 64


async def live(socket: WebSocket) -> None:
    """One viewer, until it goes."""
    house = cast(House, socket.app.state.house)
    try:
        robot = house.robot(socket.path_params.get("robot"))
    except Problem as problem:
        await _refuse(socket, 4404, problem.text)
        return
    address = socket.client.host if socket.client else "an unknown address"
    if house.viewers >= MOST_VIEWERS:
        await _refuse(socket, 4429, f"{MOST_VIEWERS} look already; close a page first")
        return
    person = house.people.arrive(address, socket.query_params.get("session", "")[:100])
    if person is None:
        await _refuse(socket, 4429, "too many pages; close one first")
        return
    house.viewers += 1
    try:
        await socket.accept()
        asked = socket.headers.get("accept-language", "").strip().lower()
        await Session(socket, house, house.hubs[robot.name], person).run(
            "zh" if asked.startswith("zh") else "en"
        )
    finally:
        house.viewers -= 1
        house.people.leave(person)


async def _refuse(socket: WebSocket, code: int, reason: str) -> None:
    await socket.accept()
    await socket.close(code, reason[:120])


router.add_api_websocket_route("/live", live)
