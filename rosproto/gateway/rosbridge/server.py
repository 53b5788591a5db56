"""`Rosbridge`: the server, as a program uses it."""

from __future__ import annotations

import ssl
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from weakref import WeakValueDictionary

from rosproto.gateway.access import Access
from rosproto.gateway.client_channel import ClientChannel, ClientSession
from rosproto.gateway.client_limits import GatewayLimits
from rosproto.gateway.client_publications import ClientPublications
from rosproto.gateway.json_text import JsonReader
from rosproto.gateway.rosbridge.server_state import ServerState
from rosproto.gateway.rosbridge.session import RosbridgeSession
from rosproto.gateway.shared_subscriptions import SharedSubscriptions
from rosproto.gateway.velocity_watchdog import VelocityWatchdog
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


class Rosbridge:
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
        origins: Origins of web pages that may connect, besides those of this computer:
            `("https://studio.example",)`; "*" for all.
        token: The secret that clients must send, as `?token=...` or in a header
            `Authorization: Bearer ...`.
        rosapi: Answer the services of /rosapi here.
        authenticate: Serve a client only after the service `authenticate` (rosauth/Authentication) has
            accepted the credentials of its `auth`.
        watchdog: Sends zero where a client drives when this process is killed or hangs.

    Raises:
        LocalProtocolError: The package `websockets` is missing.
        ValueError: Others can reach the address, and there is no token.
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
        token: str | None = None,
        rosapi: bool = True,
        authenticate: bool = False,
        watchdog: Watchdog | None = None,
    ) -> None:
        self.access = access or Access()
        self.limits = limits or GatewayLimits()
        self._node = node
        self._velocity_watchdog = VelocityWatchdog(node.clock.now)
        self._shared_subscriptions = SharedSubscriptions(node, self.limits)
        self._publications = ClientPublications(node, self._velocity_watchdog, watchdog=watchdog)
        self._sessions: WeakValueDictionary[ClientChannel, RosbridgeSession] = WeakValueDictionary()
        self._lock = threading.Lock()
        self._closed = False
        self._state: ServerState | None = None
        self._rosapi = rosapi
        self._authenticate = authenticate
        self._server = WebSocketServer(
            self._open_session,
            host=host,
            port=port,
            limits=self.limits,
            tls=tls,
            origins=origins,
            token=token,
            name="rosbridge",
        )
        node.before_close(self._stop_driving)
        node.add_closer(self.close)

    def _open_session(self, channel: ClientChannel) -> ClientSession:
        session = RosbridgeSession(self._parts(), channel, self._server.peer_log)
        self._sessions[channel] = session
        return session

    def _parts(self) -> ServerState:
        """The state, made for the first client, in the loop's thread."""
        if self._state is None:
            from rosproto.gateway.rosbridge.rosapi import Rosapi
            from rosproto.gateway.rosbridge.tf_on_demand import TfOnDemand

            self._state = ServerState(
                node=self._node,
                access=self.access,
                limits=self.limits,
                shared_subscriptions=self._shared_subscriptions,
                publications=self._publications,
                rosapi=Rosapi(self._node, self.access) if self._rosapi else None,
                pool=self._server.pool,
                tf=TfOnDemand(self._node, self.access),
                json=JsonReader(self.limits.message_values, self.limits.nesting),
                authenticate=self._authenticate,
            )
        return self._state

    @property
    def port(self) -> int:
        """The port it listens on."""
        return self._server.port

    @property
    def host(self) -> str:
        """The address it listens on."""
        return self._server.host

    @property
    def url(self) -> str:
        """The address for clients: "ws://127.0.0.1:9090"."""
        return self._server.url

    @property
    def closed(self) -> bool:
        """True once `close` was called."""
        return self._closed

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
                    dropped=channel.dropped,
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
            topics=self._shared_subscriptions.topics,
            zeros=self._velocity_watchdog.zeros,
        )

    def _stop_driving(self, reason: str) -> None:
        """Send zeros before the node closes."""
        self._velocity_watchdog.close()

    def close(self, timeout: float = 5.0) -> None:
        """Send zeros where a client drives, then end all connections in bounded time. May be repeated."""
        with self._lock:
            closed, self._closed = self._closed, True
        if closed:
            return
        self._node.remove_closer(self.close)
        self._velocity_watchdog.close()
        try:
            self._server.close(timeout)
        finally:
            if self._state is not None:
                self._state.tf.close()
            self._publications.close()
            self._shared_subscriptions.close()

    def __enter__(self) -> Rosbridge:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    def __repr__(self) -> str:
        state = "closed" if self._closed else f"{len(self._server.channels)} clients"
        return f"<Rosbridge {self.url}, {state}>"
