"""A master, a robot and a Foxglove server's node, for the tests of that server."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

from rosproto.gateway.foxglove import Foxglove
from rosproto.master import Master
from rosproto.node import Node
from tests.support.viewer import Viewer

__all__ = ["Ground", "until"]


class Ground:
    """A master, a robot's node and the node of a server."""

    def __init__(self) -> None:
        self.master = Master()
        self.robot = Node("/robot", master_uri=self.master.uri, rosout=False, intraprocess=False)
        self.node = Node("/gateway", master_uri=self.master.uri, rosout=False, intraprocess=False)
        self.servers: list[Foxglove] = []
        self.viewers: list[Viewer] = []

    def serve(self, **options: Any) -> Foxglove:
        self.servers.append(Foxglove(self.node, port=0, **options))
        return self.servers[-1]

    def view(self, server: Foxglove, **options: Any) -> Viewer:
        self.viewers.append(Viewer(server.url, **options))
        return self.viewers[-1]

    def subscribers(self, topic: str) -> list[str]:
        return self.robot.master.get_system_state().subscribers.get(topic, [])

    def publishers(self, topic: str) -> list[str]:
        return self.robot.master.get_system_state().publishers.get(topic, [])

    def close(self) -> None:
        for viewer in self.viewers:
            viewer.close()
        for server in self.servers:
            server.close()
        self.node.close()
        self.robot.close()
        self.master.close()


def until(condition: Callable[[], object], what: str, seconds: float = 10.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, what
        threading.Event().wait(0.01)
