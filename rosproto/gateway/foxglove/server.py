"""`Foxglove`: the server, as a program uses it."""

from __future__ import annotations

import os
import ssl
import time
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING
from urllib.parse import quote

from rosproto.errors import RosTimeout
from rosproto.gateway.access import Access, require_token_off_loopback
from rosproto.gateway.foxglove import handshake
from rosproto.gateway.foxglove.assets import Assets
from rosproto.gateway.foxglove.local_topic import LocalTopic
from rosproto.gateway.foxglove.proxy import Proxy
from rosproto.gateway.foxglove.sdk import sdk
from rosproto.gateway.foxglove.shared import Shared
from rosproto.gateway.limits import GatewayLimits
from rosproto.logs import get_logger
from rosproto.records import NamedTuple

if TYPE_CHECKING:
    from rosproto.gateway.foxglove.session import Session
    from rosproto.node import Node

__all__ = ["ClientFacts", "Foxglove", "FoxgloveStats"]

_log = get_logger("rosproto.gateway")


class ClientFacts(NamedTuple):
    """One client, at one moment.

    Attributes:
        peer: "host:port".
        subscriptions: Topics it follows.
        sent, sent_bytes: Messages it was sent.
        dropped: Messages it was not sent because it did not read, by topic.
        published: Messages it has published.
        since: When it came, seconds since 1970.
    """

    peer: str
    subscriptions: tuple[str, ...]
    sent: int
    sent_bytes: int
    dropped: dict[str, int]
    published: int
    since: float


class FoxgloveStats(NamedTuple):
    """How a server stands.

    Attributes:
        clients: Connected now.
        accepted, refused: Connections so far.
        stalled: Connections cut off because nothing was read.
        refusals: Writes that were not allowed.
        topics: Followed at the robot now.
        zeros: Zero velocities sent after clients that drove.
    """

    clients: int
    accepted: int
    refused: int
    stalled: int
    refusals: int
    topics: tuple[str, ...]
    zeros: int


class Foxglove:
    """Shows the graph of a node in Foxglove and Lichtblick, until it is closed.

    A topic is subscribed at the robot when the first viewer wants it. Viewers read; publishing, calling
    services and setting parameters is open only where `access` says so.

    Args:
        node: Whose graph.
        host: Address to listen on. Others than this computer's own need a `token`.
        port: 0 is a free one.
        access: What is open; None: everything may be read, nothing written.
        limits: Bounds.
        tls: For wss://.
        origins: Of pages elsewhere that may connect: `("https://app.foxglove.dev",)`.
        token: Clients give it in the address: `ws://...?token=T`.
        name: What viewers show.
        topics: Topics of this program's own, for the viewers alone.
        assets: Folders with packages, for `package://` addresses of meshes and textures.

    Raises:
        ImportError: foxglove-sdk is not installed.
        ConnectionLost: It cannot listen there.
        ValueError: An address that others reach, without a token.
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
        token: str | None = None,
        name: str | None = None,
        topics: Iterable[LocalTopic] = (),
        assets: Iterable[str | os.PathLike[str]] = (),
    ) -> None:
        sdk()
        require_token_off_loopback(host, token)
        if isinstance(origins, str):
            raise ValueError(f"origins are a list of texts; for one alone write [{origins!r}]")
        self.node = node
        self.host = host
        self.access = access or Access()
        self.limits = limits or GatewayLimits()
        self._tls, self._token = tls is not None, token
        self._origins = tuple(origins)
        self._closed = False
        self._shared = Shared(
            node,
            name=name or f"rosproto {node.name}",
            access=self.access,
            limits=self.limits,
            topics=topics,
            assets=Assets(assets),
        )
        try:
            self._proxy = Proxy(
                host, port, tls=tls, check=self._check, make_session=self._shared.new_session,
                limits=self.limits, prepare=self._prepare,
            )  # fmt: skip
        except BaseException:
            self._shared.close(1.0)
            raise
        node.add_closer(self.close)
        _log.info("= foxglove: serving %s at %s", node.name, self.url)

    def _prepare(self, proxy: Proxy) -> None:
        self._shared.pool = proxy.pool
        self._shared.later = lambda seconds, call: proxy.call(proxy.loop.call_later, seconds, call)

    def _check(self, request: handshake.Request) -> str:
        return handshake.check_request(request, bound=self.host, origins=self._origins, token=self._token)

    # -- facts ----------------------------------------------------------------------------------------------

    @property
    def port(self) -> int:
        """Where it listens."""
        return self._proxy.port

    @property
    def url(self) -> str:
        """Address to give to a viewer; without the token."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{'wss' if self._tls else 'ws'}://{host}:{self.port}"

    @property
    def app_url(self) -> str:
        """Page that opens Foxglove with this server; it has to be among the `origins`. Without the token."""
        return f"https://app.foxglove.dev/?ds=foxglove-websocket&ds.url={quote(self.url, safe='')}"

    @property
    def clients(self) -> tuple[ClientFacts, ...]:
        """Who is connected."""
        return tuple(_facts(session) for session in self._shared.sessions)

    def stats(self) -> FoxgloveStats:
        """How it stands now."""
        shared, proxy = self._shared, self._proxy
        return FoxgloveStats(
            clients=len(shared.sessions),
            accepted=proxy.accepted,
            refused=proxy.refused,
            stalled=proxy.stalled,
            refusals=shared.refusals,
            topics=shared.taps.topics,
            zeros=shared.guard.zeros,
        )

    def __repr__(self) -> str:
        state = "closed" if self._closed else f"{len(self._shared.sessions)} clients"
        return f"<Foxglove {self.url}, {state}>"

    # -- the end --------------------------------------------------------------------------------------------

    def close(self, timeout: float = 5.0) -> None:
        """Zeros where clients drove, then every connection ends. Twice is fine.

        Raises:
            RosTimeout: It was not done in time; what is left ends by itself.
        """
        if self._closed:
            return
        self._closed = True
        self.node.remove_closer(self.close)
        end = time.monotonic() + timeout
        self._shared.guard.close()
        self._shared.stop()
        self._proxy.close(max(0.1, end - time.monotonic()))
        self._shared.close(max(0.1, end - time.monotonic()))
        if time.monotonic() > end + 1.0:
            raise RosTimeout(f"closing the Foxglove server took longer than {timeout:g} s")

    def __enter__(self) -> Foxglove:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()


def _facts(session: Session) -> ClientFacts:
    sender = session.sender
    return ClientFacts(
        session.peer,
        session.topics,
        sender.sent,
        sender.sent_bytes,
        sender.dropped,
        session.publications.published,
        session.since,
    )
