"""UDPROS: requestTopic's parameters, cutting messages, reassembly with loss and reordering."""

from __future__ import annotations

import random
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosproto.errors import LocalProtocolError, RemoteProtocolError, TooLarge
from rosproto.protocol import udpros
from rosproto.protocol.udpros import DatagramAnswer, DatagramRequest, Reassembly, datagrams

HEADER = {"callerid": "/a", "md5sum": "*", "topic": "/t", "type": "*"}


def frame(body: bytes) -> bytes:
    return struct.pack("<I", len(body)) + body


def received(reassembly: Reassembly, parts: list[bytes]) -> list[bytes]:
    return [body for part in parts if (body := reassembly.add(part)) is not None]


def test_a_request_and_its_answer_are_what_roscpp_writes() -> None:
    request = DatagramRequest(HEADER, "10.0.0.7", 4000, 1500)
    name, header, *rest = request.as_protocol()
    assert (name, rest) == ("UDPROS", ["10.0.0.7", 4000, 1500])
    assert isinstance(header, bytes)
    assert header.startswith(b"\x0b\0\0\0callerid=/a")  # without a length of its own
    assert DatagramRequest.parse(request.as_protocol()) == request
    answer = DatagramAnswer("10.0.0.8", 5000, 3, 1500, HEADER)
    assert DatagramAnswer.parse(answer.as_answer()) == answer
    assert answer.as_answer()[:5] == ["UDPROS", "10.0.0.8", 5000, 3, 1500]


@pytest.mark.parametrize(
    "change",
    [
        slice(0, 4),
        (1, "no bytes"),
        (1, b"\xff\xff\xff\xff"),
        (2, 7),
        (2, ""),
        (3, 0),
        (3, 65536),
        (3, "x"),
        (4, 8),
        (4, 70000),
    ],
    ids=str,
)
def test_a_request_that_is_none(change: object) -> None:
    protocol = DatagramRequest(HEADER, "10.0.0.7", 4000, 1500).as_protocol()
    if isinstance(change, slice):
        protocol = protocol[change]
    elif isinstance(change, tuple):
        protocol[change[0]] = change[1]
    with pytest.raises(RemoteProtocolError):
        DatagramRequest.parse(protocol)


def test_an_answer_that_is_none() -> None:
    with pytest.raises(RemoteProtocolError, match="not \\['UDPROS', 'h'\\]"):
        DatagramAnswer.parse(["UDPROS", "h"])


def test_the_bytes_of_the_datagrams() -> None:
    """Connection, opcode, number, block; 8 bytes in all."""
    parts = list(datagrams(frame(b"abcdefgh"), 0x01020304, 5, 12 + 3))
    assert parts == [
        b"\x04\x03\x02\x01\x00\x05\x02\x00" + b"\x08\0\0\0abc",
        b"\x04\x03\x02\x01\x01\x05\x01\x00" + b"defgh",
    ]


def test_a_message_may_be_too_long_for_its_blocks() -> None:
    with pytest.raises(LocalProtocolError, match="TCPROS"):
        next(datagrams(bytes(9 * 65535 + 1), 1, 1, 8 + 9))


@given(st.lists(st.binary(max_size=60), min_size=1, max_size=20), st.integers(9, 30), st.randoms())
def test_what_is_cut_comes_back_whole_in_any_order(
    bodies: list[bytes], size: int, chance: random.Random
) -> None:
    """Blocks of one message shuffled and doubled; messages one after the other."""
    reassembly = Reassembly(7, 1000)
    came = []
    for number, body in enumerate(bodies, 1):
        parts = list(datagrams(frame(body), 7, number, size))
        parts += chance.sample(parts, len(parts) // 2)
        chance.shuffle(parts)
        came += received(reassembly, parts)
    assert came == bodies
    assert reassembly.lost == 0


@given(st.lists(st.booleans(), min_size=1, max_size=100), st.integers(1, 255))
def test_what_is_lost_is_counted(arrives: list[bool], first: int) -> None:
    """Each message in two datagrams, of which the second may be lost."""
    reassembly = Reassembly(7, 1000)
    came, sent = [], []
    for index, whole in enumerate([True, *arrives, True]):
        number = (first + index - 1) % udpros.LAST_NUMBER + 1
        body = bytes([index])
        parts = list(datagrams(frame(body), 7, number, 8 + 4))
        came += received(reassembly, parts if whole else parts[:1])
        sent += [body] if whole else []
    assert came == sent
    assert reassembly.lost == arrives.count(False)


def test_a_message_that_was_overtaken_is_given_up() -> None:
    reassembly = Reassembly(7, 1000)
    first, second = (list(datagrams(frame(bytes([n])), 7, n, 8 + 4)) for n in (1, 2))
    assert received(reassembly, [first[0], *second, first[1]]) == [b"\x02"]


def test_who_counts_zero_is_understood_too() -> None:
    """goroslib numbers messages 0 to 255."""
    reassembly = Reassembly(7, 1000)
    parts = [part for n in range(600) for part in datagrams(frame(b"x"), 7, n % 256)]
    assert len(received(reassembly, parts)) == 600
    assert reassembly.lost == 0


def test_memory_is_bounded() -> None:
    """By the limit for one message, and by few messages at a time."""
    reassembly = Reassembly(7, 100)
    with pytest.raises(TooLarge):
        received(reassembly, list(datagrams(frame(bytes(200)), 7, 1, 8 + 30)))
    begun = {number: datagrams(frame(bytes(90)), 7, number, 8 + 30) for number in range(2, 100)}
    for pieces in begun.values():
        reassembly.add(next(pieces))
    newest = range(100 - udpros.IN_PROGRESS, 100)
    # The rest of the one before is as the begin of another, which takes the place of the oldest of them.
    assert received(reassembly, list(begun[newest[0] - 1])) == []
    rest = [piece for number in newest[1:] for piece in begun[number]]
    assert len(received(reassembly, rest)) == udpros.IN_PROGRESS - 1


@pytest.mark.parametrize(
    "datagram",
    [
        b"",
        b"\x07\0\0\0\0\x01\x01",
        b"\x08\0\0\0\0\x01\x01\0" + frame(b"x"),  # another connection
        b"\x07\0\0\0\x02\x01\x01\0",  # a ping
        b"\x07\0\0\0\0\x01\0\0" + frame(b"x"),  # a message in no blocks
        b"\x07\0\0\0\x01\x01\0\0" + frame(b"x"),  # the first block, where it is none
        b"\x07\0\0\0\0\x01\x01\0" + b"\x09\0\0\0x",  # a length that is wrong
        b"\x07\0\0\0\0\x01\x01\0" + b"\x09",  # no length
    ],
)
def test_strays_are_passed_over(datagram: bytes) -> None:
    reassembly = Reassembly(7, 100)
    assert reassembly.add(datagram) is None
    assert reassembly.lost == 0


@given(st.lists(st.binary(max_size=40).map(lambda tail: b"\x07\0\0\0" + tail), max_size=50))
def test_no_bytes_are_too_strange(datagrams: list[bytes]) -> None:
    reassembly = Reassembly(7, 100)
    for datagram in datagrams:
        reassembly.add(datagram)
