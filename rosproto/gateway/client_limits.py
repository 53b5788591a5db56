"""How much a client of a gateway may ask for; checked before memory is allocated or the robot is asked."""

from __future__ import annotations

from typing import NamedTuple

READER_BYTES = 64 << 10
"""Bytes of a message where nothing may be written: what could not be carried out is not read."""


class GatewayLimits(NamedTuple):
    """Bounds for one gateway; the defaults fit a robot and a few dozen people who watch it.

    Attributes:
        connections: Simultaneous clients.
        pending_handshakes: Further connections: those that have not finished the WebSocket handshake, TLS
            included, or were refused and are not closed.
        handshake_seconds: Time for the handshake, TLS included.
        silence_seconds: A client is asked for a sign of life this often, and disconnected when it sends none
            for as long again.
        close_seconds: Time that closing a connection may take.
        message_bytes: One message of a client, after joining its fragments.
        message_values: Values and keys of JSON in it. Decoding them holds up everything else in the process,
            up to a microsecond for each.
        nesting: Depth of nested arrays and objects in a message.
        text_length: Characters of a name, type or id.
        subscriptions_per_client: Topics that one client subscribes to.
        advertised_per_client: Topics that one client advertises, and as many services.
        calls_per_client: Service calls of one client that have not been answered.
        goals_per_client: Action goals of one client that have not ended.
        call_seconds: Longest time for a service call, even if the client asks for more.
        outbox_bytes: What waits for one client; beyond it the oldest messages of topics are dropped. The
            newest message of a topic is kept whatever its size.
        outbox_messages: Messages of one topic that wait for one client, at most.
        topic_bytes: Messages of one topic that wait for one client; the newest is always kept.
        answer_bytes: Answers (never dropped) that wait for one client; beyond it the connection is closed.
        linger_seconds: How long a topic stays subscribed after its last client has left.
    """

    connections: int = 64
    pending_handshakes: int = 64
    handshake_seconds: float = 5.0
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
