"""Counters of links and nodes, as values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple


class ConnectedLink(NamedTuple):
    """A connection to a publisher that is up.

    Attributes:
        node: The publisher's node.
        address: "host:port"; its XML-RPC URI where both are in one process.
        number: No other connection of our node has or had it.
    """

    node: str
    address: str
    number: int


@dataclass(slots=True)
class LinkStats:
    """Counters of one link since it was made.

    Attributes:
        topic: Resolved topic.
        direction: "out" to a subscriber, "in" from a publisher.
        peer: The other node's name; "" before the handshake.
        address: "host:port" of the connection, or the publisher's XML-RPC URI while there is none.
        transport: "TCPROS", "UDPROS" or "INTRAPROCESS".
        connected: True while messages can flow.
        bytes: Bytes of messages, lengths included.
        messages: Messages sent, or received.
        dropped: Messages dropped because a queue was full; with UDPROS also those lost by the network.
        reconnects: Number of reconnections.
        queued: Messages in the queue now.
        state: State of the link, in words.
        last_error: Text of the last error; "" if there was none.
    """

    topic: str
    direction: str
    peer: str = ""
    address: str = ""
    transport: str = "TCPROS"
    connected: bool = False
    bytes: int = 0
    messages: int = 0
    dropped: int = 0
    reconnects: int = 0
    queued: int = 0
    state: str = ""
    last_error: str = ""


@dataclass(slots=True)
class NodeStats:
    """Result of `Node.stats()`.

    Attributes:
        name: The node.
        uri: Its XML-RPC URI.
        master_uri: Its master.
        master_lost: True while the master does not answer.
        links: Every link to a publisher or subscriber.
        services: Counters of service servers and clients.
    """

    name: str
    uri: str
    master_uri: str
    master_lost: bool
    links: tuple[LinkStats, ...] = ()
    services: Mapping[str, Mapping[str, Mapping[str, int]]] = field(default_factory=dict)

    @property
    def dropped(self) -> int:
        """Dropped messages of all links."""
        return sum(link.dropped for link in self.links)

    @property
    def reconnects(self) -> int:
        """Reconnections of all links."""
        return sum(link.reconnects for link in self.links)
