"""Long messages in chunks: the same message as when sent whole, and no chunk that holds up other topics."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from rosproto.codec import decode, define, encode
from rosproto.gateway.chunks import CHUNK_SIZE, ChunkedMessage, chunked
from rosproto.gateway.rosbridge import png
from rosproto.gateway.rosbridge.cbor import publish_cbor_raw
from rosproto.gateway.rosbridge.protocol import publish_chunks, publish_text
from rosproto.gateway.values import to_json, to_json_parts
from rosproto.time import Time

LONG = define(
    "a/Long",
    "string name\nint8[] small\nint8[] wide\nint32[] whole\nfloat32[] real\nuint8[] octets\nbool[] flags\n"
    "string[] texts\ntime[] times\nInner[] inner\nint8 last\n"
    + "=" * 80
    + "\nMSG: a/Inner\nfloat64[] more\nstring s",
)
COUNT = 400_003


@pytest.fixture(scope="module")
def message() -> Any:
    random = np.random.default_rng(1)
    reals = random.normal(size=COUNT).astype(np.float32)
    reals[::1000], reals[1::1000], reals[2::1000] = np.nan, np.inf, -np.inf
    made = LONG(
        name="\0 mark",
        small=random.integers(-99, 101, COUNT).astype(np.int8),
        wide=random.integers(-128, 128, COUNT).astype(np.int8),
        whole=random.integers(-(2**31), 2**31, COUNT).astype(np.int32),
        real=reals,
        octets=random.integers(0, 256, COUNT).astype(np.uint8),
        flags=[True, False] * 15_000,
        texts=["ö\0"] * 30_000,
        last=7,
    )
    made.times = [Time(1, 2)] * 3
    made.inner = [type(made)._binding.class_for("a/Inner")(more=[0.5] * 30_000, s=str(i)) for i in range(3)]
    return decode(LONG, encode(made))


def test_json_in_chunks(message: Any) -> None:
    """The same text; also where long arrays are inside others, and texts hold the mark for them."""
    whole = to_json(message)
    assert json.loads(whole)["inner"][2] == {"more": [0.5] * 30_000, "s": "2"}
    parts = to_json_parts(message)
    assert "".join(parts) == whole
    sent = publish_chunks("/t", parts)
    assert sent.text() == publish_text("/t", whole)
    assert len(sent) == len(sent.text())
    assert max(map(len, sent.chunks)) <= CHUNK_SIZE
    assert len(sent.chunks) < 2 * len(sent) / CHUNK_SIZE + 2


@pytest.mark.whole
def test_a_picture_of_chunks(message: Any) -> None:
    """The text is in its pixels."""
    sent = publish_chunks("/t", to_json_parts(message))
    assert png.unpack(png.pack(sent), 1 << 30).rstrip("\n") == sent.text()


@pytest.mark.parametrize("size", [0, 23, 24, 255, 256, 70_000, CHUNK_SIZE, 3 * CHUNK_SIZE + 1])
def test_raw_bytes_in_chunks(size: int) -> None:
    """The same bytes, of which the robot's are not copied."""
    cbor2 = pytest.importorskip("cbor2", reason='cbor2 is not installed: pip install ".[bridge]"')
    data = bytes(range(256)) * (size // 256 + 1)
    data = data[:size]
    sent = publish_cbor_raw("/t", 1, 2, data)
    chunks = sent.chunks if isinstance(sent, ChunkedMessage) else (sent,)
    message = {"secs": 1, "nsecs": 2, "bytes": data}
    assert b"".join(chunks) == cbor2.dumps({"op": "publish", "topic": "/t", "msg": message})  # type: ignore[arg-type]
    assert len(chunks) > 1 or size < 1 << 16
    assert all(chunk.obj is data for chunk in chunks[1:])  # type: ignore[union-attr]


def test_short_texts_are_joined() -> None:
    """A chunk is worth its frame."""
    assert chunked(["a"] * 10 + ["b" * (CHUNK_SIZE + 1), "c"]).chunks == (
        "a" * 10,
        "b" * CHUNK_SIZE,
        "b",
        "c",
    )
    assert repr(ChunkedMessage([b"ab", b"c"])) == "<ChunkedMessage: 3 in 2>"
