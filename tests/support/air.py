"""A wire between two computers, in user space, that delays, loses, limits and filters packets.

Two TUN devices, one in the network namespace of each computer (hosts.py), are joined by a thread that reads
packets from one and writes them to the other. This needs no traffic control of the kernel, and a test sets the
network's behaviour in one line: `air.there.open = False`.
"""

from __future__ import annotations

import heapq
import itertools
import os
import random
import selectors
import struct
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field

__all__ = ["Air", "Way", "is_tcp_opening", "open_tun"]

MTU = 1500
_TUNSETIFF = 0x400454CA
_IFF_TUN, _IFF_NO_PI = 0x0001, 0x1000


def open_tun(name: str) -> int:
    """Make a TUN device in the caller's network namespace; its file descriptor. It vanishes when that is closed.

    Raises:
        OSError: There is no /dev/net/tun, or no permission.
    """
    import fcntl  # imported here: on other systems, the tests are collected and skipped

    fd = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        fcntl.ioctl(fd, _TUNSETIFF, struct.pack("16sH22x", name.encode(), _IFF_TUN | _IFF_NO_PI))
    except OSError:
        os.close(fd)
        raise
    return fd


def is_tcp_opening(packet: bytes) -> bool:
    """Whether this is the first packet of a TCP connection (SYN without ACK), which firewalls filter."""
    version = packet[0] >> 4
    protocol, head = (packet[9], 4 * (packet[0] & 15)) if version == 4 else (packet[6], 40)
    return protocol == 6 and len(packet) > head + 13 and packet[head + 13] & 0x12 == 0x02


@dataclass
class Way:
    """One direction of the wire.

    Attributes:
        open: False drops all packets silently.
        delay: Seconds each packet is under way.
        loss: Fraction of lost packets, 0 to 1.
        rate: Bytes per second; 0 for no limit.
        queue: Bytes that wait at a limited rate before packets are dropped.
        passes: A firewall: packets for which it is False are lost.
        carried, lost: Packets so far.
    """

    open: bool = True
    delay: float = 0.0
    loss: float = 0.0
    rate: float = 0.0
    queue: int = 64 * MTU
    passes: Callable[[bytes], bool] | None = None
    carried: int = 0
    lost: int = 0
    _free_at: float = 0.0
    _random: random.Random = field(default_factory=lambda: random.Random(1))

    def arrival(self, packet: bytes, now: float) -> float | None:
        """When a packet sent now arrives; None when it never does."""
        if (
            not self.open
            or (self.loss and self._random.random() < self.loss)
            or (self.passes is not None and not self.passes(packet))
        ):
            self.lost += 1
            return None
        at = now
        if self.rate:
            begin = max(now, self._free_at)
            if (begin - now) * self.rate > self.queue:
                self.lost += 1
                return None
            at = self._free_at = begin + len(packet) / self.rate
        self.carried += 1
        return at + self.delay


class Air:
    """The thread between two TUN devices.

    Args:
        one, other: Their file descriptors; the Air closes them.

    Attributes:
        there: From one to the other.
        back: From the other to one.
    """

    def __init__(self, one: int, other: int) -> None:
        self.there = Way()
        self.back = Way()
        self._ends = {one: (other, self.there), other: (one, self.back)}
        self._due: list[tuple[float, int, int, bytes]] = []  # arrival, order, to whom, packet
        self._count = itertools.count()
        self._closing = False
        self._thread = threading.Thread(target=self._run, name="test:air", daemon=True)
        self._thread.start()

    def silence(self) -> None:
        """Drop all packets, in both directions, also those in transit."""
        self.there.open = self.back.open = False

    def clear(self) -> None:
        """Packets pass again."""
        self.there.open = self.back.open = True

    def close(self) -> None:
        """End the thread and with it the devices."""
        self._closing = True
        self._thread.join(5.0)
        for fd in self._ends:
            os.close(fd)

    def _run(self) -> None:
        with selectors.DefaultSelector() as selector:
            for fd in self._ends:
                selector.register(fd, selectors.EVENT_READ)
            while not self._closing:
                left = self._due[0][0] - time.monotonic() if self._due else 0.05
                for key, _ in selector.select(max(0.0, min(left, 0.05))):
                    self._read(key.fd)
                self._deliver()

    def _read(self, fd: int) -> None:
        to, way = self._ends[fd]
        for _ in range(64):
            try:
                packet = os.read(fd, MTU + 100)
            except BlockingIOError:
                return
            except OSError:  # the device is down just now
                time.sleep(0.001)
                return
            at = way.arrival(packet, time.monotonic())
            if at is not None:
                heapq.heappush(self._due, (at, next(self._count), to, packet))

    def _deliver(self) -> None:
        now = time.monotonic()
        while self._due and self._due[0][0] <= now:
            _, _, to, packet = heapq.heappop(self._due)
            if self._way_to(to).open:
                try:
                    os.write(to, packet)
                except OSError:
                    pass  # the device is down, or the packet is invalid: lost, as on any network

    def _way_to(self, fd: int) -> Way:
        return next(way for to, way in self._ends.values() if to == fd)
