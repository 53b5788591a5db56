"""`GatewayLimits`: bounds on what one client of a gateway may use. Each is checked before memory is taken."""

from __future__ import annotations

from typing import NamedTuple

from rosproto.admission import MAX_CLIENTS
from rosproto.json_text import JsonReader

READER_BYTES = 64 << 10
"""The longest message, in bytes, where nothing may be written."""

MAX_THREADS = 256


class GatewayLimits(NamedTuple):
    """Bounds for one gateway; the defaults fit a robot and a few dozen viewers.

    Attributes:
        connections: Simultaneous clients.
        pending_handshakes: Further connections that have not finished the WebSocket handshake (TLS included),
            or were refused and are not closed yet.
        handshake_seconds: Time for the handshake, TLS included.
        silence_seconds: Seconds between two pings of a client; without a pong for as long again it is
            disconnected.
        close_seconds: Longest time for closing a connection.
        message_bytes: Longest message of a client, after joining its fragments.
        message_values: Values and keys of JSON in it. Decoding blocks all other threads, up to a microsecond
            for each value.
        nesting: Depth of nested arrays and objects in a message.
        text_length: Characters of a name, type or id.
        subscriptions_per_client: Topics that one client subscribes to.
        advertised_per_client: Topics that one client advertises, and as many services.
        calls_per_client: Service calls of one client that have not been answered.
        goals_per_client: Action goals of one client that have not ended.
        call_seconds: Longest time for a service call, even if the client asks for more.
        outbox_bytes: Bytes waiting for one client; beyond it the oldest messages of topics are dropped. The
            newest message of a topic is always kept.
        outbox_messages: Messages of one topic waiting for one client.
        topic_bytes: Bytes of one topic waiting for one client; the newest message is always kept.
        answer_bytes: Bytes of answers waiting for one client; answers are never dropped, and beyond this the
            connection is closed.
        linger_seconds: Time that a topic stays subscribed after its last client has left.
    """

    connections: int = MAX_CLIENTS
    pending_handshakes: int = 64
    handshake_seconds: float = 10.0
    silence_seconds: float = 20.0
    close_seconds: float = 2.0
    message_bytes: int = 1 << 20
    message_values: int = 100_000
    nesting: int = 64
    text_length: int = 1024
    subscriptions_per_client: int = 200
    advertised_per_client: int = 100
    calls_per_client: int = 64
    goals_per_client: int = 64
    call_seconds: float = 60.0
    outbox_bytes: int = 32 << 20
    outbox_messages: int = 100
    topic_bytes: int = 8 << 20
    answer_bytes: int = 32 << 20
    linger_seconds: float = 1.0

    @property
    def threads(self) -> int:
        """Most threads of one kind: with more clients, work that waits takes turns."""
        return min(MAX_THREADS, 4 * self.connections)

    def json_reader(self) -> JsonReader:
        """Make the reader of the messages of all clients."""
        remedy = "a gateway started with a larger --message-bytes accepts one for every ten bytes of it"
        return JsonReader(self.message_values, self.nesting, remedy)
