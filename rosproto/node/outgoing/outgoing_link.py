"""What a publication asks of the link to one subscriber, whatever carries the messages."""

from __future__ import annotations

from typing import Protocol

from rosproto.node.outgoing.frames import LargeFrame
from rosproto.node.stats import LinkStats

Frame = bytes | LargeFrame


class OutgoingLink(Protocol):
    """A subscriber, over TCP, in datagrams, or in this process."""

    id: int
    caller_id: str
    queue_size: int
    transport: str

    def start(self) -> None: ...

    def set_linger(self, linger: bool) -> None: ...

    def send(self, frame: bytes) -> None: ...

    def send_soon(self, frame: bytes, now: float) -> bool: ...

    def send_large(self, frame: LargeFrame) -> None: ...

    def wait_empty(self, timeout: float) -> None: ...

    def has_arrived(self) -> bool | None:
        """Whether the subscriber's computer has all that was sent; None where the system does not tell."""

    def close(self, *, deliver: bool = True) -> None: ...

    def stats(self) -> LinkStats: ...


def send_frame(link: OutgoingLink, frame: Frame) -> None:
    """Send now, whatever its size."""
    if isinstance(frame, bytes):
        link.send(frame)
    else:
        link.send_large(frame)
