"""A node's slave API and TCPROS server, on one address; they move when the address changes.

The TCPROS server has one listening socket for publishers and services. The connection header of a subscriber
has a `topic`, that of a service client a `service`. Each connection has its own thread, which reads the
header within a deadline, so a silent peer does not delay others (rospy reads it in the accept loop and hangs:
docs/wire.md, 9).

Source: wiki.ros.org/ROS/TCPROS.

Both servers listen only on the address chosen by `rosproto/transport/own_address.py`; rospy and roscpp listen
on every interface.
"""

from __future__ import annotations

import socket
from collections.abc import Callable, Collection

from rosproto.errors import ConnectionLost, RosError, RosTimeout, TooLarge
from rosproto.logs import PeerLog, get_logger
from rosproto.protocol.handshake import error_header
from rosproto.protocol.wire_limits import Limits
from rosproto.transport.deadline import Deadline
from rosproto.transport.own_address import choose_own_address, local_address_towards
from rosproto.transport.tcp import read_header, write_all, write_header
from rosproto.transport.tcp_server import TcpServer
from rosproto.transport.uri import make_uri
from rosproto.transport.xmlrpc_server import Dispatch, XmlRpcServer

_log = get_logger("rosproto.node")

# The first four bytes of HTTP requests, read as the length of a header.
_HTTP = frozenset(int.from_bytes(verb, "little") for verb in (b"POST", b"GET ", b"HEAD", b"PUT "))
_NOT_FOUND = b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"

OnConnection = Callable[[socket.socket, dict[str, str], tuple[str, int]], None]


class TcprosServer(TcpServer):
    """Reads the header of each connection, and passes the socket to `on_topic` or `on_service`.

    Attributes:
        on_topic: Called with (socket, header fields, peer) for a subscriber. It owns the socket from then on.
        on_service: The same for a service client; it returns when the connection ends.
    """

    def __init__(
        self,
        host: str,
        *,
        limits: Limits,
        on_topic: OnConnection,
        allow: Collection[str] | None = None,
        name: str = "tcpros",
        port: int = 0,
    ) -> None:
        self.on_topic = on_topic
        self.on_service: OnConnection | None = None
        self._said = PeerLog("rosproto.node")
        super().__init__(host, port, self._greet, limits=limits, allow=allow, name=name)

    def _greet(self, sock: socket.socket, peer: tuple[str, int]) -> None:
        deadline = Deadline(self._limits.handshake_seconds)
        try:
            fields = read_header(sock, self._limits, deadline)
        except (ConnectionLost, RosTimeout) as error:
            # No warning: tools probe a port by connecting and closing (wire.md, fact 8).
            _log.debug("! %s:%s sent no connection header: %s", *peer[:2], error)
            sock.close()
            return
        except RosError as error:
            if isinstance(error, TooLarge) and error.size in _HTTP:
                _answer_http(sock, peer)
            else:
                self._refuse(sock, peer, str(error))
            return
        if "service" in fields and self.on_service is not None:
            self.established(sock)
            self.on_service(sock, fields, peer)
        elif "topic" in fields:
            self.hand_over(sock)  # a subscriber's link has no thread of its own
            self.on_topic(_CountedSocket(sock, self), fields, peer)
        else:
            self._refuse(sock, peer, "the connection header names neither a topic nor a service of this node")

    def _refuse(self, sock: socket.socket, peer: tuple[str, int], why: str) -> None:
        self._said.warning(peer[0], "connection from %s:%s refused: %s", *peer[:2], why[:500])
        refuse(sock, why)


def _answer_http(sock: socket.socket, peer: tuple[str, int]) -> None:
    """Answer a call for a slave API that had this port before: masters still call dead nodes.

    No warning, since the user cannot prevent these calls.
    """
    _log.debug("! %s:%s sent an HTTP request for the previous user of this port; answered 404", *peer[:2])
    try:
        sock.settimeout(0.5)
        sock.recv(1 << 16)  # closing with unread bytes would reset the connection and lose the answer
        write_all(sock, _NOT_FOUND, Deadline(1.0))
    except (RosError, OSError):
        pass  # the peer is gone
    sock.close()


class _CountedSocket(socket.socket):
    """A subscriber's connection: it counts against `limits.connections` until it is closed."""

    __slots__ = ("_release",)

    def __init__(self, accepted: socket.socket, server: TcpServer) -> None:
        super().__init__(fileno=accepted.detach())
        self._release: Callable[[], None] | None = lambda: server.released(accepted)

    def close(self) -> None:
        super().close()
        release, self._release = self._release, None
        if release is not None:
            release()


def refuse(sock: socket.socket, why: str) -> None:
    """Send the reason in an error header, then close; never raises."""
    try:
        write_header(sock, error_header(why), Deadline(1.0))
    except (RosError, OSError):
        pass  # the peer is gone
    sock.close()


class Endpoints:
    """Both servers of a node, opened together and closed together.

    Attributes:
        host: The announced host.
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
        """Stop listening and end the connections, within `timeout` seconds for each server."""
        self.slave.close(timeout)
        self.tcpros.close(timeout)


def open_endpoints(host: str, bind: str, master: tuple[str, int], **options: object) -> Endpoints:
    """Open `Endpoints` on `bind`; if it is not our address (NAT), on the one that routes to the master.

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


REBIND_SECONDS = 1.0  # for ending the connections of the old address

Listen = Callable[[str, str], Endpoints]
"""`(host to announce, address to listen on)`: opens the node's servers."""


class Listening:
    """The present servers of one node; they move when this computer gets another address.

    Args:
        given: Address or name that the program gave; None to use the address that routes to the master.

    Attributes:
        given: As above.
        listen: Opens the servers; set before `open`.
        endpoints: The open servers; replaced after each change of address.
    """

    listen: Listen
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

    def open(self, master: tuple[str, int], timeout: float) -> None:
        """Choose the address and open the servers.

        Raises:
            RosError: There is no route to the master, or nothing can be listened on.
        """
        announced, bind = choose_own_address(self.given, master, timeout)
        self.endpoints = self.listen(announced, bind)

    def follow(self, find_address: Callable[[], str], moved: Callable[[str], None]) -> bool:
        """Listen on our present address towards the master; True when it has changed.

        `moved` is called with the old URI, before the old servers are closed.

        Raises:
            RosError: There is no route to the master at present, or nothing can be listened on.
        """
        if self.given is not None:
            return False
        address = find_address()
        old = self.endpoints
        if address == old.host:
            return False
        new = self.listen(address, address)
        new.tcpros.on_service = old.tcpros.on_service
        self.endpoints = new
        moved(old.uri)
        old.close(REBIND_SECONDS)
        return True
