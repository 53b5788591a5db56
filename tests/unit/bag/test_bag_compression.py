"""Chunk compression: what comes out is what went in, damage is noticed, and LZ4 frames are what rosbag reads."""

from __future__ import annotations

import random

import pytest

from rosproto.bag.compression import compressor, decompress, decompress_prefix
from rosproto.errors import BagError

DATA = bytes(range(256)) * 5000


@pytest.mark.parametrize("name", ["none", "bz2", "lz4"])
@pytest.mark.parametrize("data", [b"", b"x", DATA], ids=["empty", "one", "long"])
def test_round_trip(name, data):
    assert decompress(name, compressor(name)(data), len(data)) == data


@pytest.mark.parametrize("name", ["bz2", "lz4"])
def test_a_size_that_differs_from_the_headers_is_a_bag_error(name):
    packed = compressor(name)(DATA)
    for size in (len(DATA) - 1, len(DATA) + 1, 0):
        with pytest.raises(BagError, match="its header says"):
            decompress(name, packed, size)


@pytest.mark.parametrize("name", ["bz2", "lz4"])
def test_a_flipped_byte_is_noticed(name):
    packed = bytearray(compressor(name)(DATA))
    for at in range(0, len(packed), max(len(packed) // 20, 1)):
        packed[at] ^= 0x10
        with pytest.raises(BagError):
            decompress(name, bytes(packed), len(DATA))
        packed[at] ^= 0x10


@pytest.mark.parametrize("name", ["bz2", "lz4"])
def test_of_a_cut_chunk_a_true_prefix_is_given(name):
    data = random.Random(name).randbytes(1_500_000).translate(bytes(i & 15 for i in range(256)))
    packed = compressor(name)(data)
    plain, complete = decompress_prefix(name, packed[: len(packed) * 3 // 4], len(data))
    assert not complete
    assert data.startswith(plain)
    assert len(plain) > len(data) // 4


@pytest.mark.parametrize("name", ["bz2", "lz4"])
def test_a_bomb_gives_no_more_than_the_size_it_claims(name):
    packed = compressor(name)(bytes(10_000_000))
    plain, complete = decompress_prefix(name, packed, 1000)
    assert len(plain) <= 1000
    assert not complete


@pytest.mark.promise("rosbag reads only LZ4 frames with independent blocks")
def test_lz4_frames_have_the_profile_that_rosbag_reads():
    packed = compressor("lz4")(DATA)
    assert packed[:4] == b"\x04\x22\x4d\x18"
    flags, block = packed[4], packed[5]
    assert flags >> 6 == 1, "version"
    assert flags & 0x20, "independent blocks"
    assert not flags & 0x10, "no block checksum"
    assert not flags & 0x08, "no content size"
    assert flags & 0x04, "content checksum"
    assert not flags & 0x03, "no dictionary"
    assert 4 <= block >> 4 <= 7, "block size id"


def test_unknown_compression():
    with pytest.raises(ValueError, match="none, bz2, lz4"):
        compressor("zstd")
    with pytest.raises(BagError, match="none, bz2, lz4"):
        decompress("zstd", b"", 0)
