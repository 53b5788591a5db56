"""A JSON text as a picture, and what a client sends for one."""

from __future__ import annotations

import base64
import json
import struct
import zlib

import numpy as np
import pytest

from rosproto.gateway.rosbridge.png import MAX_PICTURE_BYTES, PngError, pack, publish_png, unpack
from rosproto.numeric.pngfile import SIGNATURE, encode_png
from tests.support.memory import peak_of
from tests.support.png import read_png


@pytest.mark.parametrize(
    "text", ["{}", "", "a", "abcd", "Wüste", "x" * 10_000, '{"data": [' + "1, " * 5000 + "2]}"]
)
def test_round_trip(text: str) -> None:
    """Newlines fill the rest, which JSON ignores."""
    assert unpack(pack(text)).rstrip("\n") == text
    assert json.loads(publish_png(text)) == {"op": "png", "data": pack(text)}


def test_the_picture() -> None:
    """About square, RGB, the bytes row by row."""
    pixels = read_png(base64.b64decode(pack("abc" * 101)))
    assert pixels.shape == (11, 10, 3)
    assert pixels.tobytes() == b"abc" * 101 + b"\n" * 27


def chunk(kind: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def picture(width: int, height: int, raw: bytes, *, kind: int = 2, depth: int = 8) -> str:
    header = struct.pack(">IIBBBBB", width, height, depth, kind, 0, 0, 0)
    parts = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(raw, 9)) + chunk(b"IEND", b"")
    return base64.b64encode(SIGNATURE + parts).decode()


@pytest.mark.promise("The size of a picture is checked before it is unpacked")
@pytest.mark.parametrize(
    ("data", "why"),
    [
        ("%%%", "not a PNG picture in base64"),
        ("AAAAA", "not a PNG picture in base64"),
        ("", "not a PNG picture in base64: not a PNG picture"),
        ("Ä", "not a PNG picture in base64"),
        (picture(60_000, 60_000, b"\0" * 1000), "60000 x 60000 pixels; expected 1 to"),
        (picture(1, 5000, b"\0\0\0\0" * 5000), "5000 rows of pixels; expected at most 4096"),
        (picture(10, 10, b"\0" * 5), "cut short"),
        (picture(2, 1, b"\0\xff\xff\xff\xff\xff\xff"), "the picture's bytes are not UTF-8"),
        (picture(2, 1, b"\0\0\0", kind=0), "1 channels; expected red, green and blue"),
        (base64.b64encode(encode_png(np.zeros((2, 2, 4), np.uint8))).decode(), "4 channels"),
        ("A" * (MAX_PICTURE_BYTES * 4 // 3 + 5), "more than the limit of 262144 bytes"),
    ],
)
def test_what_is_no_such_picture(data: str, why: str) -> None:
    """A sentence each, also for the sizes of a bomb."""
    with pytest.raises(PngError, match=why):
        unpack(data)


@pytest.mark.promise("The size of a picture is checked before it is unpacked")
def test_a_bomb_takes_no_memory() -> None:
    """A kilobyte that would become a gigabyte, behind a header that is small."""
    bomb = picture(20, 20, b"\0" * (100 << 20))
    assert peak_of(lambda: unpack(bomb)) < 2 << 20


def test_a_picture_of_many_chunks() -> None:
    """Each is taken once: a picture with a chunk for every byte is read as one."""
    body = zlib.compress(b"\0abc")
    parts = b"".join(chunk(b"IDAT", body[at : at + 1]) for at in range(len(body)))
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 2, 0, 0, 0))
    assert unpack(base64.b64encode(SIGNATURE + header + parts).decode()) == "abc"
