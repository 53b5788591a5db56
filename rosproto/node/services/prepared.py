"""One request that has its connection before it is needed, and is encoded.

For a program that must be able to ask at a bad moment: when no thread can be started, no file opened, or a
signal handler has interrupted a frame that holds locks. `send` writes bytes to a socket, and does nothing
else.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from rosproto.errors import ConnectionLost, RosError
from rosproto.node.services.link import ServiceLink
from rosproto.transport.deadline import Deadline


class PreparedCall:
    """A call that is ready; made by `ServiceClient.prepare`, which see. Close it when it is not needed any
    more.

    Args:
        link: The connection; nobody else uses it.
        body: The request, encoded as the provider wants it.
        decode: From an answer to the response.
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
        """Whether it can be sent: it was not, and the provider has kept the connection."""
        return not self.sent and self._link.usable

    def send(self) -> bool:
        """Write the request, once; False when there is no connection any more.

        Waits for nothing: neither for a lock nor for the answer.
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
        """The response to what was sent.

        Raises:
            ServiceError: The provider answered "no"; its text.
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
