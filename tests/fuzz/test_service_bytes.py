"""Any bytes from a service client or provider give an answer, an end or a documented error, and nothing else."""

from __future__ import annotations

import socket
import struct

from hypothesis import given, settings
from hypothesis import strategies as st

from rosproto.errors import RosError
from rosproto.node.services.link import ServiceLink
from rosproto.node.services.server import ServiceSession
from rosproto.protocol.wire_limits import Limits
from rosproto.transport.deadline import Deadline

LIMITS = Limits(message_bytes=1000)
framed = st.binary(max_size=60).map(lambda body: struct.pack("<I", len(body)) + body)
stream = st.lists(framed | st.binary(max_size=40), max_size=6).map(b"".join)
answer = st.tuples(st.integers(0, 255), framed).map(lambda parts: bytes([parts[0]]) + parts[1])


@given(stream, st.booleans())
@settings(max_examples=200, deadline=None)
def test_a_session_ends_whatever_a_client_sends(data: bytes, persistent: bool) -> None:
    ours, theirs = socket.socketpair()
    requests: list[bytes] = []
    with ours, theirs:
        theirs.sendall(data)
        theirs.shutdown(socket.SHUT_WR)
        session = ServiceSession(
            ours,
            lambda request: requests.append(request) or b"\x01\0\0\0\0",  # type: ignore[func-returns-value]
            peer="fuzz",
            persistent=persistent,
            limits=LIMITS,
        )
        session.run()
        assert ours.fileno() == -1
    rest, expected = data, []
    while len(rest) >= 4 and (size := struct.unpack("<I", rest[:4])[0]) <= min(1000, len(rest) - 4):
        expected.append(rest[4 : size + 4])
        rest = rest[size + 4 :]
    # What the answers say is nobody's concern here: an unread answer may have reset the line before the end.
    assert requests == expected[: len(requests)]
    assert len(requests) == (len(expected) if persistent else min(1, len(expected)))


@given(answer | stream)
@settings(max_examples=200, deadline=None)
def test_a_call_ends_whatever_a_provider_answers(data: bytes) -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        theirs.sendall(data)
        theirs.shutdown(socket.SHUT_WR)
        link = ServiceLink(ours, {}, service="/fuzz", peer="fuzz", limits=LIMITS)
        try:
            body = link.call(b"request", Deadline(5.0))
        except RosError:
            return
        assert data[0] != 0
        assert data == data[:1] + struct.pack("<I", len(body)) + body
