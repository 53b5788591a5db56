"""What the proxy needs of a client's session: the interface between it and `Session`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

__all__ = ["MakeSession", "ProxiedSession"]


class ProxiedSession(Protocol):
    """The session of a client that was let in.

    Attributes:
        port: Where its SDK server listens.
        introduction: Bytes the proxy sends to that server ahead of the client's own, to prove who it is.
    """

    port: int
    introduction: bytes

    def upstream_connected(self, port: int) -> None:
        """The proxy has connected to the SDK server, from this port; called in a thread that may wait.

        Raises:
            Exception: The client cannot be served.
        """

    def client_connected(self) -> None:
        """The client has the answer to its handshake; called in a thread that may wait."""

    def pause_sending(self) -> None:
        """The client reads too slowly; called in the proxy's thread, must not block."""

    def resume_sending(self) -> None:
        """The client has caught up; called in the proxy's thread, must not block."""

    def close(self) -> None:
        """The client is gone. Called once, in a thread that may wait."""


MakeSession = Callable[[str, Callable[[], None]], ProxiedSession]
"""`make(peer, hang_up)`: called in a thread that may wait; `hang_up` ends the connection, from any thread."""
