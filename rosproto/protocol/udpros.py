"""UDPROS: messages of a topic in datagrams. Lost messages are not repeated, so none is delayed by another.

The subscriber's `requestTopic` already contains its UDP port and its connection header; the reply has the
publisher's header and the number that every datagram of this connection carries. A message has the same bytes
as over TCP, length and body, cut into blocks:

    uint32 connection, uint8 opcode, uint8 message, uint16 block, then the bytes

Opcode DATA0 begins a message, and its `block` is the number of blocks. DATAN carries the others, and its
`block` is the index. Messages are numbered 1 to 255 and then from 1 again: roscpp treats 0 as none.

Source: wiki.ros.org/ROS/UDPROS; for the parameters of requestTopic roscpp (topic_manager.cpp,
transport_udp.cpp).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from struct import Struct
from typing import NamedTuple

from rosproto.errors import LocalProtocolError, RemoteProtocolError, TooLarge
from rosproto.protocol.handshake import decode_header, encode_header

UDPROS = "UDPROS"
DATAGRAM_BYTES = 1472
"""The payload of an Ethernet frame without IP and UDP headers (roscpp asks for 1500, which IP fragments)."""

MAX_DATAGRAM_BYTES = 65507
MAX_BLOCKS = 0xFFFF
LAST_NUMBER = 255
NUMBERS = 256
IN_PROGRESS = 4  # messages whose blocks may overtake each other
DATA0, DATAN = 0, 1  # 2 (ping) and 3 (error) are never sent

_header = Struct("<IBBH")
_length = Struct("<I")
HEADER_BYTES = _header.size


# -- requestTopic ------------------------------------------------------------------------------------------


class DatagramRequest(NamedTuple):
    """A subscriber's request.

    Attributes:
        header: Its connection header.
        host, port: Where it receives datagrams.
        datagram_bytes: The longest datagram it accepts, UDPROS's 8 bytes included.
    """

    header: dict[str, str]
    host: str
    port: int
    datagram_bytes: int

    def as_protocol(self) -> list[object]:
        """As an entry of requestTopic's `protocols`."""
        return [UDPROS, _pack_header(self.header), self.host, self.port, self.datagram_bytes]

    @classmethod
    def parse(cls, protocol: Sequence[object]) -> DatagramRequest:
        """Parse an entry of requestTopic's `protocols`.

        Raises:
            RemoteProtocolError: It is not one.
        """
        match protocol:
            case [_, bytes(header), str(host), int(port), int(size)] if 0 < port < 65536 and host:
                return cls(decode_header(header), host, port, _checked_size(size))
        raise RemoteProtocolError(
            f"a request for UDPROS is [UDPROS, header in base64, host, port, maximum bytes of a datagram],"
            f" not {str(protocol)[:100]}"
        )


class DatagramAnswer(NamedTuple):
    """A publisher's reply.

    Attributes:
        host, port: The publisher's UDP socket; roscpp sends from another one.
        connection: The number in each of its datagrams.
        datagram_bytes: Its longest datagram.
        header: The publisher's connection header.
    """

    host: str
    port: int
    connection: int
    datagram_bytes: int
    header: dict[str, str]

    def as_answer(self) -> list[object]:
        """As requestTopic's value."""
        return [UDPROS, self.host, self.port, self.connection, self.datagram_bytes, _pack_header(self.header)]

    @classmethod
    def parse(cls, answer: Sequence[object]) -> DatagramAnswer:
        """Parse requestTopic's value.

        Raises:
            RemoteProtocolError: It is not one.
        """
        match answer:
            case [_, str(host), int(port), int(connection), int(size), bytes(header)]:
                return cls(host, port, connection & 0xFFFFFFFF, _checked_size(size), decode_header(header))
        raise RemoteProtocolError(
            f"an answer for UDPROS is [UDPROS, host, port, connection, maximum bytes of a datagram, header in"
            f" base64], not {str(answer)[:100]}"
        )


def _pack_header(fields: Mapping[str, str]) -> bytes:
    return encode_header(fields)[_length.size :]  # the fields alone, as in roscpp


def _checked_size(size: int) -> int:
    if not HEADER_BYTES < size <= MAX_DATAGRAM_BYTES:
        raise RemoteProtocolError(
            f"UDPROS: datagrams of {size} bytes; expected {HEADER_BYTES + 1} to {MAX_DATAGRAM_BYTES}"
        )
    return size


# -- datagrams ---------------------------------------------------------------------------------------------


def datagrams(
    frame: bytes | memoryview, connection: int, message: int, datagram_bytes: int = DATAGRAM_BYTES
) -> Iterator[bytes]:
    """Cut one message into datagrams.

    Args:
        frame: Length and body, as over TCP.
        connection: The connection's number.
        message: The message's number, 1 to 255.
        datagram_bytes: The longest datagram.

    Raises:
        LocalProtocolError: It needs more than 65535 blocks.
    """
    room = datagram_bytes - HEADER_BYTES
    blocks = -(-len(frame) // room)
    if blocks > MAX_BLOCKS:
        raise LocalProtocolError(
            f"a message of {len(frame)} bytes does not fit into {MAX_BLOCKS} datagrams of {datagram_bytes}"
            " bytes; use TCPROS for it"
        )
    yield _header.pack(connection, DATA0, message, blocks) + frame[:room]
    for block in range(1, blocks):
        yield _header.pack(connection, DATAN, message, block) + frame[block * room : (block + 1) * room]


class _Partial:
    """An incomplete message."""

    __slots__ = ("blocks", "bytes", "total")

    def __init__(self) -> None:
        self.blocks: dict[int, bytes] = {}
        self.bytes = 0
        self.total = 0  # 0: the first block has not arrived

    def add(self, block: int, data: bytes) -> None:
        if block not in self.blocks:
            self.blocks[block] = data
            self.bytes += len(data)

    @property
    def complete(self) -> bool:
        return len(self.blocks) == self.total and max(self.blocks) < self.total


class Reassembly:
    """Reassembles the messages of one connection; datagrams that are not UDPROS are ignored.

    Blocks may arrive in any order, twice, or never. Messages keep their order: one that completes only after
    a later one is dropped, as are incomplete ones.

    Args:
        connection: Datagrams with another number are ignored.
        limit: Most bytes of a message.

    Attributes:
        lost: Number of lost messages, from gaps in the numbers.
    """

    def __init__(self, connection: int, limit: int) -> None:
        self._connection = connection
        self._limit = limit
        self._partial: dict[int, _Partial] = {}
        self._last: int | None = None
        self._counts_zero = False
        self.lost = 0

    def add(self, datagram: bytes) -> bytes | None:
        """Add a datagram; return the body of the message that it completes, or None.

        Raises:
            TooLarge: The message is longer than the limit; it is dropped.
        """
        if len(datagram) < HEADER_BYTES:
            return None
        connection, opcode, message, block = _header.unpack_from(datagram)
        if connection != self._connection or opcode > DATAN or block == 0:
            return None
        if self._last is not None and not 0 < (message - self._last) % NUMBERS < NUMBERS // 2:
            return None  # late, or a duplicate
        data = datagram[HEADER_BYTES:]
        if opcode == DATA0 and block == 1:  # by far the most frequent case: a whole message
            return self._finished(message, data)
        return self._gather(message, opcode, block, data)

    def _gather(self, message: int, opcode: int, block: int, data: bytes) -> bytes | None:
        partial = self._partial.get(message)
        if partial is None:
            partial = self._partial[message] = _Partial()
            for oldest in list(self._partial)[:-IN_PROGRESS]:
                del self._partial[oldest]
        if opcode == DATA0:
            partial.total, block = block, 0
        partial.add(block, data)
        if partial.bytes > self._limit:
            del self._partial[message]
            raise TooLarge("message_bytes", partial.bytes, self._limit)
        if not partial.complete:
            return None
        return self._finished(message, b"".join(partial.blocks[index] for index in range(partial.total)))

    def _finished(self, message: int, frame: bytes) -> bytes | None:
        """The body of a complete message; earlier incomplete ones are dropped."""
        self._count(message)
        for number in [n for n in self._partial if (message - n) % NUMBERS < NUMBERS // 2]:
            del self._partial[number]
        if len(frame) < _length.size or _length.unpack_from(frame)[0] != len(frame) - _length.size:
            return None
        return frame[_length.size :]

    def _count(self, message: int) -> None:
        last, self._last = self._last, message
        self._counts_zero |= message == 0  # goroslib does, roscpp does not
        if last is not None:
            skips_zero = message < last and not self._counts_zero
            self.lost += (message - last) % NUMBERS - 1 - skips_zero
