"""Credentials of rosauth: a client is served only after a service has accepted them.

As in rosbridge_suite with its parameter ~authenticate, the first message of a client must be an `auth`, and
its fields go to the service `authenticate` (rosauth/Authentication). Unlike there, the connection also ends
when the service cannot be asked, and when no credentials come in time.
"""

from __future__ import annotations

from typing import Any

from rosproto.gateway.rosbridge.operations import Auth
from rosproto.gateway.rosbridge.shared import Refused, Shared
from rosproto.time import Time

__all__ = ["Authentication"]

SERVICE = "authenticate"
TYPE = "rosauth/Authentication"
NOT_CHECKED = (
    "credentials of rosauth are not checked here (--authenticate); who connects shows a token, as ?token=..."
    " in the URL or as Authorization: Bearer ..."
)


class Authentication:
    """Whether one client may be served yet.

    Args:
        shared: Calls the service.
        required: Whether credentials are asked for at all.

    Attributes:
        begun: Credentials have come.
        done: The client is served.
    """

    def __init__(self, shared: Shared, *, required: bool) -> None:
        self._shared = shared
        self._required = required
        self.begun = False
        self.done = not required

    def check(self, asked: Auth) -> None:
        """Ask the service about credentials; waits for its answer.

        Raises:
            Refused: They are not accepted, or nothing asks for them.
            RosError: The service cannot be called.
        """
        self.begun = True
        if self.done:
            raise Refused("the client has authenticated already" if self._required else NOT_CHECKED)
        service: Any = self._shared.service_class(TYPE)
        try:
            request = service.Request(
                mac=asked.mac,
                client=asked.client,
                dest=asked.dest,
                rand=asked.rand,
                t=Time(asked.t),
                level=asked.level,
                end=Time(asked.end),
            )
        except (TypeError, ValueError, OverflowError) as problem:
            raise Refused(f"t and end are times in seconds: {problem}") from None
        seconds = self._shared.limits.call_seconds
        with self._shared.waiting(), self._shared.node.service_client(SERVICE, service) as client:
            if not client.call(request, timeout=seconds).authenticated:
                raise Refused("the credentials are not accepted")
        self.done = True
