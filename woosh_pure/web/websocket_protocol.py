"""uvicorn's protocols within a budget of the loop's time, and a limit on the frames of a WebSocket message.

uvicorn limits the bytes of a message (`ws_max_size`), but it keeps a list of the frames, and empty
continuation frames have no bytes. This module imports uvicorn; `server` imports it when a server is made.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any

from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from rosproto.aio import BudgetedProtocol, ReadBudget

if TYPE_CHECKING:
    from websockets.frames import Frame


MAX_FRAMES = 64
"""Of one message of 4096 letters. A browser sends one."""


def budgeted(budget: ReadBudget) -> type[asyncio.Protocol]:
    """uvicorn's protocol for HTTP within a budget; it gives its transport to the WebSocket protocol."""

    class Http(BudgetedProtocol):
        def __init__(self, **given: Any) -> None:
            super().__init__(budget, H11Protocol(**given))

    return Http


class LimitedWebSocketProtocol(WebSocketsSansIOProtocol):
    """Abort the connection when a message has more than `MAX_FRAMES` frames.

    uvicorn takes a protocol class as `ws=`. Overriding `handle_cont` is undocumented; the name is public, and
    a test sends such frames to a real server.
    """

    frames_of_message = 1

    def handle_cont(self, event: Frame) -> None:
        """Count a continuation frame, and handle it while the message is within the limit."""
        self.frames_of_message += 1
        if self.frames_of_message > MAX_FRAMES:
            self.transport.abort()  # further frames of the same piece come here, too
            return
        if event.fin:
            self.frames_of_message = 1
        super().handle_cont(event)
