"""One request that is encoded and connected in advance.

For calls that must work when no thread can be started, no file opened, or a signal handler has interrupted
a frame that holds locks. `send` only writes bytes to a socket.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from rosproto.errors import ConnectionLost, RosError
from rosproto.node.services.link import ServiceLink
from rosproto.transport.deadline import Deadline


class PreparedCall:
    """A prepared call, made by `ServiceClient.prepare`. Close it after use.

    Args:
        link: The connection, used only by this call.
        body: The request, encoded for the provider's revision.
        decode: Decodes the answer to the response.
        drop: Closes the connection.
    """

    def __init__(
        self,
        link: ServiceLink,
        body: bytes,
        decode: Callable[[ServiceLink, bytes], Any],
        drop: Callable[[ServiceLink], None],
    ) -> None:
        self._link = link
        self._body = body
        self._decode = decode
        self._drop = drop
        self._turn = threading.Lock()
        self._answer: Any = None
        self.sent = False
        link.prepare()

    @property
    def usable(self) -> bool:
        """Whether it can be sent: it was not sent before, and the connection is still open."""
        return not self.sent and self._link.usable

    def send(self) -> bool:
        """Write the request, once; False if the connection has ended.

        Does not wait, neither for a lock nor for the answer.
        """
        if self.sent:
            return True
        try:
            self._link.post(self._body)
        except (RosError, OSError):
            return False
        self.sent = True
        return True

    def answer(self, timeout: float) -> Any:
        """Wait for the response.

        Raises:
            ServiceError: The provider reported failure; with its text.
            ConnectionLost: Nothing was sent, or the provider ended the connection.
            RosTimeout: Not in time.
        """
        if not self.sent:
            raise ConnectionLost("nothing was sent on this connection")
        with self._turn:
            if self._answer is None:
                self._answer = self._decode(self._link, self._link.answer(Deadline(timeout)))
            return self._answer

    def close(self) -> None:
        """End the connection."""
        self._drop(self._link)
