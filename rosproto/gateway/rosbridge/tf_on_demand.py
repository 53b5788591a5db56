"""`TfOnDemand`: starts the tf republisher when a client first uses it, unless another node provides one."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from typing import TYPE_CHECKING

from rosproto.errors import MasterError
from rosproto.gateway.access import Access
from rosproto.gateway.rosbridge.tf_names import ACTION, KINDS, SERVICE
from rosproto.node import Node

if TYPE_CHECKING:
    from rosproto.gateway.rosbridge.tf_republisher import TfRepublisher


class TfOnDemand:
    """Allows writes to the republisher's names, and starts it. Sessions call it before they check a write.

    Args:
        node: Provides the action and the service.
        access: Whether clients may read /tf.
    """

    def __init__(self, node: Node, access: Access) -> None:
        self._node = node
        self._access = access
        self._lock = threading.Lock()
        self._republisher: TfRepublisher | None = None
        self._closed = False

    def opens(self, name: str) -> bool:
        """True for a name of the republisher, which may be written to without a pattern; starts it if needed.

        Calls the master at the first such name.

        Args:
            name: Resolved name of a topic, service or action.

        Raises:
            MasterError, ConnectionLost, RosTimeout: The master does not answer, or refuses the registration.
        """
        kind = KINDS.get(name)
        if kind is None or self._access.may_read(kind, name) is not None:
            return False
        if self._access.may_read("topic", "/tf") is not None:
            return False
        from rosproto.gateway.rosbridge.tf_republisher import TfRepublisher

        with self._lock:
            if self._republisher is None and not self._closed and not self._is_provided():
                self._republisher = TfRepublisher(self._node)
        return True

    def _is_provided(self) -> bool:
        """Whether another node (tf2_web_republisher, another bridge) provides it."""
        if self._node.master.get_system_state().publishers.get(f"{ACTION}/status"):
            return True
        try:
            self._node.master.lookup_service(SERVICE)
        except MasterError as error:
            if error.code != -1:
                raise
            return False
        return True

    def publishes(self, client: object, name: str, message: object) -> None:
        """Called before a client's message is published on a topic."""
        republisher = self._republisher
        if republisher is None or name != f"{ACTION}/goal" or not isinstance(message, Mapping):
            return
        goal_id = message.get("goal_id")
        if isinstance(goal_id, Mapping) and isinstance(goal_id.get("id"), str):
            republisher.sent(client, goal_id["id"])

    def gone(self, client: object) -> None:
        """Called when a client has left."""
        if self._republisher is not None:
            self._republisher.gone(client)

    def close(self) -> None:
        """End it; may be called again."""
        with self._lock:
            self._closed = True
            republisher, self._republisher = self._republisher, None
        if republisher is not None:
            republisher.close()
