"""Where a node listens: its slave API and its TCPROS server, on one address.

The address is the one given, or the one that routes to the master, and nothing else is listened on
(rospy and roscpp listen on every interface). A host *name* that resolves to loopback, as Debian's
/etc/hosts has it for the computer's own name, would be unreachable for others: then the address towards the
master is listened on, and the name announced.
"""

from __future__ import annotations

from collections.abc import Collection

from rosproto.errors import ConnectionLost, RosError
from rosproto.node.graph.tcpros_server import OnConnection, TcprosServer
from rosproto.protocol.limits import Limits
from rosproto.transport.address import is_loopback, local_address_towards, make_uri, resolve
from rosproto.transport.xmlrpc_server import Dispatch, XmlRpcServer


class Endpoints:
    """Both servers of a node, opened together and closed together.

    Attributes:
        host: What is announced.
        uri: XML-RPC URI of the slave API.
        rosrpc_uri: URI under which services are registered.
        slave, tcpros: The servers.
    """

    def __init__(
        self,
        host: str,
        bind: str,
        *,
        port: int,
        tcpros_port: int,
        limits: Limits,
        allow: Collection[str] | None,
        name: str,
        dispatch: Dispatch,
        on_topic: OnConnection,
    ) -> None:
        self.host = host
        self.tcpros = TcprosServer(
            bind, limits=limits, on_topic=on_topic, allow=allow, name=f"tcpros {name}", port=tcpros_port
        )
        try:
            self.slave = XmlRpcServer(
                bind,
                port,
                dispatch,
                limits=limits,
                allow=allow,
                name=f"slave {name}",
                advertise=host,
            )
        except BaseException:
            self.tcpros.close()
            raise
        self.uri = self.slave.uri
        self.rosrpc_uri = make_uri(host, self.tcpros.port, "rosrpc").rstrip("/")

    def close(self, timeout: float) -> None:
        """Stop listening, end what runs; bounded."""
        self.slave.close(timeout)
        self.tcpros.close(timeout)


def listening_address(host: str | None, master: tuple[str, int], timeout: float) -> tuple[str, str]:
    """(host to announce, address to listen on).

    Args:
        host: As the caller gave it; None: the address that routes to the master.
        master: The master's host and port.
        timeout: Seconds for looking up names.

    Raises:
        ConnectionLost: There is no route to the master, or a name is unknown.
    """
    if host is None:
        address = local_address_towards(*master, timeout)
        return address, address
    addresses = resolve(host)
    if is_loopback(addresses[0]) and not is_loopback(host):
        return host, local_address_towards(*master, timeout)
    return host, addresses[0]


def open_endpoints(host: str, bind: str, master: tuple[str, int], **options: object) -> Endpoints:
    """`Endpoints`, listening towards the master when `bind` is not ours (an address behind NAT).

    Raises:
        ConnectionLost: The port is taken, or no address can be listened on.
    """
    try:
        return Endpoints(host, bind, **options)  # type: ignore[arg-type]
    except ConnectionLost as error:
        try:
            other = local_address_towards(*master, 2.0)
        except RosError:
            raise error from None
        if other == bind:
            raise
        return Endpoints(host, other, **options)  # type: ignore[arg-type]
