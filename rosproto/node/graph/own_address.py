"""The address at which other nodes reach this node now, and its move when the network gives another one."""

from __future__ import annotations

from collections.abc import Callable

from rosproto.node.graph.endpoints import Endpoints, listening_address

REBIND_SECONDS = 1.0  # for looking up names, and for ending what used the old address

Listen = Callable[[str, str], Endpoints]
"""Opens the servers of the node: the host to announce, the address to listen on."""


class OwnAddress:
    """Where one node listens.

    Args:
        given: Address or name that the program gave; None to use the address that routes to the master.

    Attributes:
        given: As above.
        endpoints: The open servers; another object after each change of address.
    """

    endpoints: Endpoints

    def __init__(self, given: str | None) -> None:
        self.given = given

    @property
    def uri(self) -> str:
        """XML-RPC URI of the slave API."""
        return self.endpoints.uri

    @property
    def host(self) -> str:
        """The host that is announced."""
        return self.endpoints.host

    def open(self, listen: Listen, master: tuple[str, int], timeout: float) -> None:
        """Choose the address and open the servers.

        Raises:
            RosError: There is no route to the master, or nothing can be listened on.
        """
        announced, bind = listening_address(self.given, master, timeout)
        self.endpoints = listen(announced, bind)

    def follow(self, listen: Listen, master: tuple[str, int], moved: Callable[[str], None]) -> bool:
        """Listen on our present address towards the master; True when it has changed.

        `moved` is called with the old URI, before the old servers are closed.

        Raises:
            RosError: There is no route to the master at present, or nothing can be listened on.
        """
        if self.given is not None:
            return False
        announced, bind = listening_address(None, master, REBIND_SECONDS)
        old = self.endpoints
        if announced == old.host:
            return False
        new = listen(announced, bind)
        new.tcpros.on_service = old.tcpros.on_service
        self.endpoints = new
        moved(old.uri)
        old.close(REBIND_SECONDS)
        return True
