"""`Foxglove`: the server, as a program uses it."""

from __future__ import annotations

import os
import ssl
from collections.abc import Iterable, Sequence
from functools import partial
from typing import NamedTuple
from urllib.parse import quote

from rosproto.gateway.access import Access
from rosproto.gateway.client_limits import GatewayLimits
from rosproto.gateway.foxglove.assets import Assets
from rosproto.gateway.foxglove.messages import SUBPROTOCOLS
from rosproto.gateway.foxglove.server_state import ClientFacts, ServerState
from rosproto.gateway.foxglove.session import FoxgloveSession
from rosproto.gateway.gateway_server import GatewayServer
from rosproto.gateway.handshake import HandshakeRules
from rosproto.gateway.local_topic import LocalTopic
from rosproto.gateway.websocket_server import WebSocketServer
from rosproto.logs import get_logger
from rosproto.node import Node
from rosproto.watchdog import Watchdog

_log = get_logger("rosproto.gateway")


class FoxgloveStats(NamedTuple):
    """Counters of a server.

    Attributes:
        clients: Connected now.
        accepted, refused: Connections so far.
        stalled: Clients disconnected because they read nothing.
        refusals: Writes that were refused.
        topics: Subscribed at the robot now.
        zeros: Zero velocities sent after clients that drove.
    """

    clients: int
    accepted: int
    refused: int
    stalled: int
    refusals: int
    topics: tuple[str, ...]
    zeros: int


class Foxglove(GatewayServer):
    """Shows the graph of a node in Foxglove and Lichtblick until it is closed.

    A topic is subscribed at the robot when the first viewer subscribes it. Viewers may publish, call services
    and set parameters only where `access` permits it.

    Args:
        node: Knows the graph.
        host: Address to listen on; one that other computers reach needs a `token`.
        port: Port; 0 for a free one.
        access: What clients may see and write; by default they see everything and write nothing.
        limits: Bounds for a client.
        tls: Certificate and key: `wss://`.
        origins: Origins of web pages that may connect: `("https://app.foxglove.dev",)`.
        hosts: Names under which this server may be reached, besides localhost and IP addresses.
        token: The secret that clients must send, at least 8 characters, in the address: `ws://...?token=T`.
        name: The server's name, as viewers show it.
        topics: Topics of this program that only viewers see.
        assets: Folders with packages, for `package://` addresses of meshes and textures.
        watchdog: Sends zero where a client drives when this process is killed or hangs.

    Raises:
        LocalProtocolError: The package `websockets` is missing.
        ConnectionLost: The address cannot be listened on.
        ValueError: Others can reach the address, and there is no token; or it is too short.
    """

    def __init__(
        self,
        node: Node,
        *,
        host: str = "127.0.0.1",
        port: int = 8765,
        access: Access | None = None,
        limits: GatewayLimits | None = None,
        tls: ssl.SSLContext | None = None,
        origins: Sequence[str] = (),
        hosts: Sequence[str] = (),
        token: str | None = None,
        name: str | None = None,
        topics: Iterable[LocalTopic] = (),
        assets: Iterable[str | os.PathLike[str]] = (),
        watchdog: Watchdog | None = None,
    ) -> None:
        self._state = ServerState(
            node,
            access or Access(),
            limits or GatewayLimits(),
            watchdog,
            name=name or f"rosproto {node.name}",
            topics=topics,
            assets=Assets(assets),
        )
        super().__init__(
            self._state,
            lambda: WebSocketServer(
                partial(FoxgloveSession, self._state),
                HandshakeRules(host, origins, token, SUBPROTOCOLS, hosts),
                port=port,
                limits=self._state.limits,
                tls=tls,
                name="foxglove",
            ),
        )
        _log.info("= foxglove: serving %s at %s", node.name, self.url)

    @property
    def app_url(self) -> str:
        """A link that opens Foxglove with this server, without the token; `origins` must name that page."""
        return f"https://app.foxglove.dev/?ds=foxglove-websocket&ds.url={quote(self.url, safe='')}"

    @property
    def clients(self) -> tuple[ClientFacts, ...]:
        """The connected clients."""
        return tuple(session.facts() for session in self._state.sessions)

    def stats(self) -> FoxgloveStats:
        """The counters now."""
        state, server = self._state, self._server
        return FoxgloveStats(
            clients=len(state.sessions),
            accepted=server.accepted,
            refused=sum(server.refused.values()),
            stalled=server.stalled,
            refusals=state.refusals,
            topics=state.shared_subscriptions.topics,
            zeros=state.velocity_watchdog.zeros,
        )
