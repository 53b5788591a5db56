"""`Rosbridge`: the server, as a program uses it."""

from __future__ import annotations

import ssl
from collections.abc import Sequence
from dataclasses import dataclass
from weakref import WeakValueDictionary

from rosproto.gateway.access import Access
from rosproto.gateway.client_channel import ClientChannel, ClientSession
from rosproto.gateway.client_limits import GatewayLimits
from rosproto.gateway.gateway_server import GatewayServer
from rosproto.gateway.handshake import HandshakeRules
from rosproto.gateway.rosbridge.server_state import ServerState
from rosproto.gateway.rosbridge.session import RosbridgeSession
from rosproto.gateway.websocket_server import WebSocketServer
from rosproto.node import Node
from rosproto.watchdog import Watchdog


@dataclass(frozen=True, slots=True)
class RosbridgeClient:
    """One client, at one moment.

    Attributes:
        peer: Its address.
        since: When it connected, by the monotonic clock.
        subscriptions: Its topics, in its spelling.
        sent: Messages sent to it.
        received: Messages that it sent.
        dropped: Messages dropped because it was too slow.
        waiting_bytes: Bytes that wait for it.
    """

    peer: str
    since: float
    subscriptions: tuple[str, ...]
    sent: int
    received: int
    dropped: int
    waiting_bytes: int


@dataclass(frozen=True, slots=True)
class RosbridgeStats:
    """Counters since the start.

    Attributes:
        clients: Connected now.
        accepted: Clients so far.
        refused: Refused connections, by reason: "token", "origin", "host", "connections", ...
        topics: Subscribed at the robot now.
        zeros: Zero velocities sent after clients that left or fell silent.
    """

    clients: int
    accepted: int
    refused: dict[str, int]
    topics: tuple[str, ...]
    zeros: int


class Rosbridge(GatewayServer):
    """Serves rosbridge until it is closed, or the node is. Close it, or use it in a `with` block.

    Clients may read what `access` shows, and write only what its `write` patterns allow. If a client that
    drives leaves or sends nothing for half a second, zero is sent. A node may have several servers.

    Args:
        node: Subscribes, publishes and calls for the clients.
        host: Address to listen on; others than 127.0.0.1 and ::1 need a token.
        port: Port, 0 for a free one.
        access: What clients may see and write.
        limits: Bounds for a client.
        tls: Certificate and key: `wss://`.
        origins: Origins of web pages that may connect: `("https://studio.example", "http://localhost:8080")`;
            "*" for all.
        hosts: Names under which this server may be reached, besides localhost and IP addresses.
        token: The secret that clients must send, at least 8 characters, as `?token=...` or in a header
            `Authorization: Bearer ...`.
        rosapi: Answer the services of /rosapi here.
        authenticate: Serve a client only after the service `authenticate` (rosauth/Authentication) has
            accepted the credentials of its `auth`.
        watchdog: Sends zero where a client drives when this process is killed or hangs.

    Raises:
        LocalProtocolError: The package `websockets` is missing.
        ValueError: Others can reach the address, and there is no token; or it is too short.
        ConnectionLost: The address cannot be listened on.
    """

    def __init__(
        self,
        node: Node,
        *,
        host: str = "127.0.0.1",
        port: int = 9090,
        access: Access | None = None,
        limits: GatewayLimits | None = None,
        tls: ssl.SSLContext | None = None,
        origins: Sequence[str] = (),
        hosts: Sequence[str] = (),
        token: str | None = None,
        rosapi: bool = True,
        authenticate: bool = False,
        watchdog: Watchdog | None = None,
    ) -> None:
        self._state = ServerState(
            node,
            access or Access(),
            limits or GatewayLimits(),
            watchdog,
            rosapi=rosapi,
            authenticate=authenticate,
        )
        self._sessions: WeakValueDictionary[ClientChannel, RosbridgeSession] = WeakValueDictionary()
        super().__init__(
            self._state,
            lambda: WebSocketServer(
                self._open_session,
                HandshakeRules(host, origins, token, hosts=hosts),
                port=port,
                limits=self._state.limits,
                tls=tls,
                name="rosbridge",
            ),
        )

    def _open_session(self, channel: ClientChannel) -> ClientSession:
        session = self._sessions[channel] = RosbridgeSession(self._state, channel)
        return session

    @property
    def clients(self) -> tuple[RosbridgeClient, ...]:
        """The connected clients."""
        found = []
        for channel in self._server.channels:
            session = self._sessions.get(channel)
            found.append(
                RosbridgeClient(
                    peer=channel.peer,
                    since=channel.since,
                    subscriptions=tuple(s.topic for s in session.subscriptions) if session else (),
                    sent=channel.sent,
                    received=channel.received,
                    dropped=sum(channel.outbox.dropped.values()),
                    waiting_bytes=channel.outbox.bytes,
                )
            )
        return tuple(found)

    def stats(self) -> RosbridgeStats:
        """The counters now."""
        return RosbridgeStats(
            clients=len(self._server.channels),
            accepted=self._server.accepted,
            refused=dict(self._server.refused),
            topics=self._state.shared_subscriptions.topics,
            zeros=self._state.velocity_watchdog.zeros,
        )
