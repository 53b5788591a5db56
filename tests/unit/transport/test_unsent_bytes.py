"""The system's count of unacknowledged bytes."""

from __future__ import annotations

import socket
import sys
import time

import pytest

from rosproto.transport.unsent_bytes import unsent_bytes


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells")
def test_bytes_that_do_not_fit_into_a_receiver() -> None:
    """What its system has is there, as far as we can know; what it has no room for is not."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        ours = socket.create_connection(server.getsockname())
        theirs = server.accept()[0]
    with ours, theirs:
        ours.setblocking(False)
        written = 0
        try:
            while True:
                written += ours.send(b"x" * 65536)
        except BlockingIOError:
            pass
        queue = unsent_bytes(ours)
        assert queue is not None
        assert 0 < queue.waiting <= written
        theirs.settimeout(20)
        while written:
            written -= len(theirs.recv(1 << 20))
        end = time.monotonic() + 20.0
        while (queue := unsent_bytes(ours)) is not None and queue.waiting:
            assert time.monotonic() < end
        assert queue == (0, False, False)


def test_nothing_is_known_of_a_closed_socket_or_elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    ours, theirs = socket.socketpair()
    with theirs:
        ours.close()
        assert unsent_bytes(ours) is None
        monkeypatch.setattr(sys, "platform", "win32")
        assert unsent_bytes(theirs) is None
