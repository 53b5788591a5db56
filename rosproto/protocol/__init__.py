"""Protocol objects: bytes in, events out, no I/O (wiki.ros.org/ROS/TCPROS, Master_API, Slave_API)."""

from __future__ import annotations

from rosproto.protocol.framing import FrameDecoder, frame
from rosproto.protocol.handshake import (
    HandshakeRefused,
    PublisherReply,
    ServiceReply,
    ServiceRequest,
    SubscriberRequest,
    check_publisher_header,
    check_service_client_header,
    check_service_server_header,
    check_subscriber_header,
    error_header,
    publisher_header,
    service_client_header,
    service_server_header,
    subscriber_header,
)
from rosproto.protocol.header import decode_header, encode_header
from rosproto.protocol.limits import Limits
from rosproto.protocol.xmlrpc import (
    DateTime,
    Fault,
    decode_call,
    decode_response,
    encode_call,
    encode_fault,
    encode_response,
)

__all__ = [
    "DateTime",
    "Fault",
    "FrameDecoder",
    "HandshakeRefused",
    "Limits",
    "PublisherReply",
    "ServiceReply",
    "ServiceRequest",
    "SubscriberRequest",
    "check_publisher_header",
    "check_service_client_header",
    "check_service_server_header",
    "check_subscriber_header",
    "decode_call",
    "decode_header",
    "decode_response",
    "encode_call",
    "encode_fault",
    "encode_header",
    "encode_response",
    "error_header",
    "frame",
    "publisher_header",
    "service_client_header",
    "service_server_header",
    "subscriber_header",
]
