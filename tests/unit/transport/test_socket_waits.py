"""Time-outs on sockets that are not Python's own."""

from __future__ import annotations

import socket
from typing import Any

import pytest

from rosproto.transport.tcp import limit_waits


class GreenSocket:
    """As gevent puts it in the place of `socket.socket`: never blocks in the kernel, keeps time-outs itself."""

    def __init__(self) -> None:
        self.calls: list[tuple[str, Any]] = []

    def settimeout(self, seconds: float | None) -> None:
        self.calls.append(("settimeout", seconds))


@pytest.mark.parametrize("seconds", [0.5, None])
def test_a_socket_that_never_waits_in_the_kernel_is_told_itself(seconds: float | None) -> None:
    """The kernel's SO_RCVTIMEO would never end its wait: a service call would have had no time limit."""
    sock = GreenSocket()
    limit_waits(sock, seconds)  # type: ignore[arg-type]
    assert sock.calls == [("settimeout", seconds)]


def test_a_wait_of_the_systems_own_socket_ends_in_time() -> None:
    one, other = socket.socketpair()
    with one, other:
        limit_waits(one, 0.02)
        with pytest.raises((BlockingIOError, TimeoutError)):
            one.recv(1)
