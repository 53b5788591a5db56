"""Who asks the master and other nodes: what a single question needs to know of the one who asks."""

from __future__ import annotations

from typing import Protocol

from rosproto.node.graph.master_client import MasterClient
from rosproto.protocol.wire_limits import Limits
from rosproto.transport.robot_host_names import HostNames


class CallerIdentity(Protocol):
    """A `Node`, or the `Context` of one.

    Attributes:
        name: Its name, the caller id.
        limits: Bounds for the answers.
        hosts: Host names that this computer may not know.
        master: Its master.
    """

    @property
    def name(self) -> str: ...

    @property
    def limits(self) -> Limits: ...

    @property
    def hosts(self) -> HostNames: ...

    @property
    def master(self) -> MasterClient: ...
