"""Limits on what a peer may send. Every length from the wire is checked before memory is allocated."""

from __future__ import annotations

from typing import NamedTuple


class Limits(NamedTuple):
    """Limits of one node, master or server; the defaults fit a robot.

    Attributes:
        header_bytes: A TCPROS connection header (it contains full definition texts).
        message_bytes: A TCPROS message; roscpp's own limit.
        xml_body_bytes: An XML-RPC request or response body.
        xml_depth: Nesting of arrays and structs in XML-RPC.
        http_head_bytes: Request or status line and headers of an HTTP message.
        pending_handshakes: Accepted connections whose TCPROS header or XML-RPC request has not arrived yet.
        connections: Open connections of one server (TCPROS and XML-RPC counted separately).
        publishers: Publishers of one topic that a subscriber connects to; each costs a thread, and anybody
            can register at a master.
        revisions: Other definitions than ours that the subscribers of one topic may have at a time; each
            costs `publish()` a conversion.
        handshake_seconds: Time to send a complete connection header or HTTP head.
        idle_seconds: An idle keep-alive HTTP connection is closed after this time.
    """

    header_bytes: int = 1 << 20
    message_bytes: int = 1_000_000_000
    xml_body_bytes: int = 16 << 20
    xml_depth: int = 64
    http_head_bytes: int = 16 << 10
    pending_handshakes: int = 256
    connections: int = 4096
    publishers: int = 1000
    revisions: int = 16
    handshake_seconds: float = 10.0
    idle_seconds: float = 60.0
