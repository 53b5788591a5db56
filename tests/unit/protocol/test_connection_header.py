"""The TCPROS connection header."""

from __future__ import annotations

import struct

import pytest

from rosproto.errors import LocalProtocolError, RemoteProtocolError
from rosproto.protocol.handshake import MAX_FIELDS, decode_header, encode_header

# rosgraph.network.encode_ros_handshake_header({"topic": "/t", "callerid": "/a", "type": "std_msgs/String"})
# on Debian's 1.15.15, with the fields in its (sorted) order.
GOLDEN = bytes.fromhex(
    "33000000"  # 51 bytes follow
    "0b000000"
    + b"callerid=/a".hex()
    + "08000000"
    + b"topic=/t".hex()
    + "14000000"
    + b"type=std_msgs/String".hex()
)


def field(data: bytes) -> bytes:
    return struct.pack("<I", len(data)) + data


def test_the_bytes_are_those_of_rosgraph() -> None:
    assert encode_header({"topic": "/t", "callerid": "/a", "type": "std_msgs/String"}) == GOLDEN


def test_no_fields_are_a_length_of_zero() -> None:
    assert encode_header({}) == b"\0\0\0\0"
    assert decode_header(b"") == {}


@pytest.mark.promise("Fields come in any order, unknown keys")
def test_fields_are_sorted_and_read_back_in_any_order() -> None:
    assert encode_header({"b": "2", "a": "1"}) == encode_header({"a": "1", "b": "2"})
    assert decode_header(field(b"z=1") + field(b"a=2")) == {"z": "1", "a": "2"}


def test_a_field_is_split_at_the_first_equals_sign() -> None:
    definition = "string FOO=a=b\n" + "=" * 80 + "\nMSG: x/Y\n"
    fields = {"message_definition": definition}
    assert decode_header(encode_header(fields)[4:]) == fields


def test_white_space_around_keys_is_dropped_and_around_values_kept() -> None:
    assert decode_header(field(b" topic = /t ")) == {"topic": " /t "}


def test_the_last_of_two_equal_keys_counts() -> None:
    assert decode_header(field(b"a=1") + field(b"a=2")) == {"a": "2"}


def test_bytes_that_are_not_utf8_survive_a_round_trip() -> None:
    body = field(b"message_definition=# gr\xfc\xdfe\nint32 x\n")
    assert encode_header(decode_header(body))[4:] == body


def test_views_and_bytearrays_are_read_too() -> None:
    body = bytearray(field(b"a=1"))
    assert decode_header(body) == decode_header(memoryview(body)) == {"a": "1"}


@pytest.mark.parametrize(
    "body",
    [
        pytest.param(b"\x01", id="stray bytes"),
        pytest.param(field(b"a=1") + b"\0\0\0", id="stray bytes at the end"),
        pytest.param(struct.pack("<I", 100) + b"a=1", id="field longer than the header"),
        pytest.param(b"\xff\xff\xff\xff", id="field of 4 GiB"),
        pytest.param(field(b"novalue"), id="no equals sign"),
        pytest.param(field(b""), id="empty field"),
        pytest.param(field(b"=x"), id="empty key"),
        pytest.param(field(b"  =x"), id="blank key"),
    ],
)
def test_nonsense_is_the_peers_error(body: bytes) -> None:
    with pytest.raises(RemoteProtocolError, match="connection header"):
        decode_header(body)


@pytest.mark.parametrize("fields", [{"": "x"}, {"a=b": "x"}, {"a": 1}, {1: "a"}, {"a": "\ud800"}])
def test_what_cannot_be_sent_is_our_error(fields: dict[str, str]) -> None:
    with pytest.raises(LocalProtocolError, match="connection header"):
        encode_header(fields)


def test_more_fields_than_anybody_needs_are_refused() -> None:
    """95,000 of them fit into a megabyte, and take a tenth of a second to decode."""
    field = struct.pack("<I", 3) + b"a=b"
    assert decode_header(field * MAX_FIELDS) == {"a": "b"}
    with pytest.raises(RemoteProtocolError, match="more than 1000 fields"):
        decode_header(field * (MAX_FIELDS + 1))
