"""Records: fields and values to bytes and back; cut or garbled headers are a BagError."""

from __future__ import annotations

import pytest

from rosproto.bag.records import (
    ChunkHeader,
    ChunkInfo,
    Connection,
    FileHeader,
    connection_from_fields,
    decode_fields,
    decode_text_fields,
    encode_contents,
    encode_fields,
    encode_index,
    index_header,
    message_header,
    op_of,
    total_counts,
)
from rosproto.errors import BagError

FIELDS = {"op": b"\x02", "conn": b"\x01\0\0\0", "topic": b"/a=b", "empty": b""}
CONNECTION = Connection(
    3, "/t", "std_msgs/String", "992c", "string data\n", {"callerid": "/me", "latching": "1"}
)


def header_of(record: bytes) -> tuple[dict[str, bytes], bytes]:
    size = int.from_bytes(record[:4], "little")
    return decode_fields(record, 4, 4 + size), record[4 + size + 4 :]


def test_fields_round_trip_and_split_at_the_first_equals_sign():
    data = encode_fields(FIELDS)
    assert int.from_bytes(data[:4], "little") == len(data) - 4
    assert decode_fields(data, 4, len(data)) == FIELDS


@pytest.mark.parametrize("cut", range(1, 40))
def test_a_cut_header_is_a_bag_error_or_fewer_fields(cut):
    data = encode_fields(FIELDS)
    try:
        fields = decode_fields(data, 4, len(data) - cut)
    except BagError:
        return
    assert fields.items() < FIELDS.items()


def test_a_field_without_equals_sign_is_a_bag_error():
    with pytest.raises(BagError, match="without '='"):
        decode_fields(b"\x02\0\0\0ab", 0, 6)


def test_the_file_header_takes_the_same_space_whatever_it_says():
    empty, full = FileHeader().encode(), FileHeader(1 << 60, 1 << 31, 1 << 31).encode()
    assert len(empty) == len(full) == 4096 + 8
    fields, _ = header_of(full)
    assert op_of(fields) == 3
    assert FileHeader.from_fields(fields) == FileHeader(1 << 60, 1 << 31, 1 << 31)


def test_connection_record_round_trips_with_its_publishers_header():
    fields, data = header_of(CONNECTION.encode())
    again = connection_from_fields(fields, decode_text_fields(data, 0, len(data)))
    assert (again.id, again.topic, again.type, again.definition) == (
        3,
        "/t",
        "std_msgs/String",
        "string data\n",
    )
    assert again.callerid == "/me"
    assert again.latching


def test_a_definition_that_is_not_utf8_stays_byte_identical():
    _, data = header_of(CONNECTION.encode())
    odd = data.replace(b"string data", b"string d\xff\xfea"[:11])
    text = decode_text_fields(odd, 0, len(odd))
    again = Connection(3, "/t", text["type"], text["md5sum"], text["message_definition"], text)
    assert header_of(again.encode())[1] == odd


@pytest.mark.promise("The topic a message was published under may")
def test_the_topic_published_under_may_differ_from_the_topic_stored_under():
    renamed = Connection(0, "/new", "a/B", "m", "", {"topic": "/old"})
    fields, data = header_of(renamed.encode())
    assert fields["topic"] == b"/new"
    assert decode_text_fields(data, 0, len(data))["topic"] == "/old"


@pytest.mark.parametrize("lost", ["type", "md5sum"])
def test_a_connection_without_type_or_md5sum_is_a_bag_error(lost):
    header = {"type": "a/B", "md5sum": "m"}
    del header[lost]
    with pytest.raises(BagError, match=lost):
        connection_from_fields({"conn": b"\0\0\0\0", "topic": b"/t"}, header)


def test_a_connection_without_a_topic_is_a_bag_error():
    with pytest.raises(BagError, match="names no topic"):
        connection_from_fields({"conn": bytes(4)}, {"type": "a/B", "md5sum": "m"})


@pytest.mark.parametrize("times", [{}, {"start_time": b"seven b"}])
def test_chunk_info_without_its_times_is_a_bag_error(times):
    fields, data = header_of(ChunkInfo(1, 0, 0, {0: 7}).encode())
    del fields["start_time"]
    with pytest.raises(BagError, match="'start_time'"):
        ChunkInfo.from_record(fields | times, data)


@pytest.mark.parametrize("time", [{}, {"time": b"seven b"}])
def test_a_message_without_its_time_is_a_bag_error(time):
    assert message_header({"conn": b"\x05\0\0\0", "time": b"\x01\0\0\0\x02\0\0\0"}) == (5, 1, 2)
    with pytest.raises(BagError, match="'time'"):
        message_header({"conn": bytes(4)} | time)


@pytest.mark.parametrize("number", [{}, {"conn": b"odd"}])
def test_a_message_without_its_connection_is_a_bag_error(number):
    with pytest.raises(BagError, match="'conn'"):
        message_header({"time": bytes(8)} | number)


def test_counts_of_chunks_are_added_for_each_connection():
    assert total_counts([ChunkInfo(1, 0, 0, {0: 7, 3: 1}), ChunkInfo(2, 0, 0, {0: 2})]) == {0: 9, 3: 1}


def test_chunk_info_round_trips():
    info = ChunkInfo(4117, 100_000_000_000, 101_999_999_999, {0: 7, 3: 1})
    fields, data = header_of(info.encode())
    assert ChunkInfo.from_record(fields, data) == info


def test_chunk_info_with_fewer_counts_than_it_says_is_a_bag_error():
    fields, data = header_of(ChunkInfo(1, 0, 0, {0: 7, 3: 1}).encode())
    with pytest.raises(BagError, match="says 2 connections"):
        ChunkInfo.from_record(fields, data[:-1])


def test_chunk_header_and_index_headers_round_trip():
    fields, _ = header_of(ChunkHeader("lz4", 7).encode(3))
    assert ChunkHeader.from_fields(fields) == ChunkHeader("lz4", 7)
    with pytest.raises(BagError, match="names no compression"):
        ChunkHeader.from_fields({"size": fields["size"]})
    fields, data = header_of(encode_index(5, bytes(24)))
    assert index_header(fields) == (5, 2)
    assert data == bytes(24)


def test_an_index_of_another_version_is_refused():
    with pytest.raises(BagError, match="version 2"):
        index_header({"ver": b"\x02\0\0\0", "conn": bytes(4), "count": bytes(4)})


def test_contents_list_connections_by_id():
    other = Connection(1, "/u", "a/B", "m", "")
    assert encode_contents([CONNECTION, other], []).index(b"/u") < encode_contents(
        [CONNECTION, other], []
    ).index(b"/t")
