"""uvicorn's protocol for WebSockets, with a limit on the frames of a message.

uvicorn limits the bytes of a message (`ws_max_size`), but it keeps a list of the frames, and empty
continuation frames have no bytes. This module imports uvicorn; `server` imports it when a server is made.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

if TYPE_CHECKING:
    from websockets.frames import Frame


MAX_FRAMES = 64
"""Of one message of 4096 letters. A browser sends one."""


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
