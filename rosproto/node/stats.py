"""Counters of one link, and how `Node.stats()` shows them."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["LinkStats"]


@dataclass(slots=True)
class LinkStats:
    """What went over one link since it was made.

    Attributes:
        topic: Resolved topic.
        direction: "out" to a subscriber, "in" from a publisher.
        peer: The other node's name, "" before it said so.
        address: "host:port" of the connection, or the publisher's XML-RPC URI while there is none.
        transport: "TCPROS" or "INTRAPROCESS".
        connected: True while messages can flow.
        bytes: Bytes of messages, lengths included.
        messages: Messages sent, or received.
        dropped: Messages given up because a queue was full.
        reconnects: Times the connection was made again.
        queued: Messages waiting now.
        state: State of the link, in words.
        last_error: Text of the last error, "" when there was none.
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
