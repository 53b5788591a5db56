"""`CallerIdentity`: the name, master, limits and host names with which a node calls another one."""

from __future__ import annotations

from typing import Protocol

from rosproto.node.graph.master_client import MasterClient
from rosproto.protocol.wire_limits import Limits
from rosproto.transport.robot_host_names import HostNames


class CallerIdentity(Protocol):
    """A `Node` or `Context`.

    Attributes:
        name: The node name, sent as caller id.
        limits: Bounds for the answers.
        hosts: Host names that this computer may not know.
        master: The client of the master.
    """

    @property
    def name(self) -> str: ...

    @property
    def limits(self) -> Limits: ...

    @property
    def hosts(self) -> HostNames: ...

    @property
    def master(self) -> MasterClient: ...
