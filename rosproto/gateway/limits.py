"""How much a client of a gateway may ask. Compared before memory is taken, and before a robot is troubled."""

from __future__ import annotations

from rosproto.records import NamedTuple

__all__ = ["GatewayLimits"]


class GatewayLimits(NamedTuple):
    """Bounds for one gateway; the defaults fit a robot and some dozen people who watch it.

    Attributes:
        connections: Clients at a time.
        pending_handshakes: Connections that have not finished the WebSocket handshake, beside those.
        handshake_seconds: Time for it, TLS included.
        silence_seconds: A client is asked for a sign of life this often, and given up when it sends none for
            as long again.
        close_seconds: Time that a connection may take to be closed.
        message_bytes: One message of a client, fragments put together.
        nesting: Arrays and objects inside one another in it.
        text_length: Characters of a name, type or id.
        subscriptions_per_client: Topics that one client subscribes.
        advertised_per_client: Topics, and again services, that one client advertises.
        calls_per_client: Service calls of one client that have not been answered.
        goals_per_client: Action goals of one client that have not ended.
        call_seconds: Longest time for a service call; also where a client asks for more.
        outbox_bytes: What waits for one client; beyond it the oldest messages of topics are dropped. The
            newest message of a topic is kept whatever its size.
        outbox_messages: Messages of one topic that wait for one client, at most.
        topic_bytes: Of the messages of one topic that wait for one client; the newest is kept in any case.
        answer_bytes: Answers (never dropped) that wait for one client; beyond it the connection ends.
        linger_seconds: A topic stays subscribed for so long after its last client has left.
    """

    connections: int = 64
    pending_handshakes: int = 64
    handshake_seconds: float = 5.0
    silence_seconds: float = 20.0
    close_seconds: float = 2.0
    message_bytes: int = 16 << 20
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
