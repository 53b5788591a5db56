"""One thing that the master knows about a node: how it is told, and taken back.

Source: wiki.ros.org/ROS/Master_API.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

from rosproto.node.graph.master_client import MasterClient


class Registration(Protocol):
    """One thing the master knows about us.

    Both calls must be repeatable: they read the node's present URIs each time, because after a change of
    address the same registration is made again under another one.

    Attributes:
        kind: "publisher", "subscriber", "service" or "parameter".
        name: Resolved name of the topic, service or parameter.
    """

    @property
    def kind(self) -> str: ...

    @property
    def name(self) -> str: ...

    def register(self, master: MasterClient) -> None:
        """Tell the master; raise what the call raises."""

    def unregister(self, master: MasterClient) -> None:
        """Take it back; raise what the call raises."""


class Announcement(NamedTuple):
    """The call that registers something, to be made beside others.

    Attributes:
        method: Of the master.
        params: Its parameters, without our name.
        heard: Takes the value of the answer; TypeError when it is none.
    """

    method: str
    params: tuple[object, ...]
    heard: Callable[[object], object]


class Together(Registration, Protocol):
    """A registration that can be made in one request with others."""

    def announce(self) -> Announcement:
        """What to tell the master now; repeatable."""
