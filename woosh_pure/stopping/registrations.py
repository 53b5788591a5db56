"""Who is registered at the master: asked once, in the background, so that a stop does not wait for it.

What nobody is registered for is reported at once, instead of being waited for.
"""

from __future__ import annotations

import threading
from collections.abc import Iterable
from typing import TYPE_CHECKING

from rosproto.errors import RosError
from rosproto.logs import get_logger
from woosh_pure.stopping.keeper import Job, begin

if TYPE_CHECKING:
    from rosproto.node import SystemState
    from woosh_pure.connection.connection import Connection

__all__ = ["Registrations"]

logger = get_logger("woosh_pure.stop")
_ANSWER = 2.0  # seconds


class Registrations:
    """Topics and services that somebody other than us has, and those that were found missing.

    While the master has not answered nothing counts as missing: links stand without it. Safe from any thread.

    Args:
        connection: Whose master is asked.

    Attributes:
        missing: Names that nobody is there for, in the order of `miss`.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._state: SystemState | None = None
        self._own_name = ""
        self._lock = threading.Lock()
        self.missing: list[str] = []
        self._asking = Job(self._ask, _ANSWER)
        begin(self._asking, "woosh:registrations")

    def _ask(self) -> None:
        try:
            node = self._connection.open_node()
            self._own_name = node.name
            self._state = node.master.get_system_state(timeout=_ANSWER)
        except (RosError, OSError, RuntimeError) as error:
            logger.debug("! who is there is not known: %s", error)

    def wait(self, timeout: float) -> bool:
        """Wait, with a bound, for the master's answer; whether it has come."""
        self._asking.join(timeout)
        return self._state is not None

    def lacks_publisher(self, topic: str) -> bool:
        """True when the master has answered, and nobody publishes the topic."""
        return self._state is not None and not self._others(self._state.publishers.get(topic, ()))

    def lacks_subscriber(self, topic: str) -> bool:
        """True when the master has answered, and nobody subscribes to the topic."""
        return self._state is not None and not self._others(self._state.subscribers.get(topic, ()))

    def lacks_service(self, name: str) -> bool:
        """True when the master has answered, and nobody offers the service."""
        return self._state is not None and name not in self._state.services

    def _others(self, nodes: Iterable[str]) -> list[str]:
        return [node for node in nodes if node != self._own_name]

    def miss(self, name: str) -> None:
        """Note that nobody is there for a topic, service or action."""
        with self._lock:
            self.missing.append(name)

    def sentence(self) -> str:
        """What was missed, in words; "" when nothing was."""
        if not self.missing:
            return ""
        master_uri = self._connection.master_uri
        return (
            f"nobody is there for {', '.join(sorted(self.missing))} at {master_uri}: no chassis "
            "runs there, or not all of it; try `woosh doctor`"
        )
