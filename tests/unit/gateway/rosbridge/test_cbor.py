"""Messages as CBOR; tests/interop/test_rosbridge_values.py holds them to the original."""

from __future__ import annotations

import math
import struct
import sys
from typing import Any

import numpy as np
import pytest

from rosproto.codec import decode, encode, message_class
from rosproto.errors import CodecError, RosError
from rosproto.gateway.rosbridge.cbor import MissingLibrary, dumps, publish_cbor, publish_cbor_raw, to_cbor
from rosproto.gateway.values import from_values
from tests.unit.gateway.rosbridge.test_values import EVERYTHING, VALUES

cbor2 = pytest.importorskip("cbor2", reason='the extra bridge is not installed: pip install ".[bridge]"')


def test_every_kind_of_field() -> None:
    """Arrays of numbers are typed arrays, also those of a fixed length; octets are bytes; the rest are lists."""
    message = decode(EVERYTHING, encode(from_values(EVERYTHING, VALUES)))
    seen = cbor2.loads(publish_cbor("/t", message))
    assert (seen["op"], seen["topic"]) == ("publish", "/t")
    values = seen["msg"]
    arrays = {
        "integers": cbor2.CBORTag(78, struct.pack("<3i", 1, -2, 3)),
        "singles": cbor2.CBORTag(85, struct.pack("<2f", 0.25, 1e10)),
        "pair": cbor2.CBORTag(86, struct.pack("<2d", 1.0, 2.0)),
        "signed": cbor2.CBORTag(72, struct.pack("<2b", -1, 127)),
        "octets": b"\0\xff",
        "three": b"abc",
    }
    assert values == {**VALUES, **arrays}


def test_not_a_number_stays_one() -> None:
    """CBOR has words for what JSON has none for."""
    point = message_class("geometry_msgs/Point")(x=math.nan, y=math.inf, z=-math.inf)
    seen = cbor2.loads(dumps(to_cbor(point)))
    assert math.isnan(seen["x"])
    assert (seen["y"], seen["z"]) == (math.inf, -math.inf)


def test_what_a_program_put_in() -> None:
    """Lists for arrays, and texts that are not UTF-8."""
    message = EVERYTHING(singles=[1, 2], octets=[1, 2], text="a\udcff", texts=["\udcff"], flags=[1, 0])
    seen = cbor2.loads(dumps(to_cbor(message)))
    assert seen["singles"] == cbor2.CBORTag(85, struct.pack("<2f", 1, 2))
    assert seen["octets"] == b"\x01\x02"
    assert (seen["text"], seen["texts"], seen["flags"]) == ("a?", ["?"], [True, False])


@pytest.mark.parametrize(
    "octets", [b"\1\2", bytearray(b"\1\2"), [1, 2], (1, 2), np.array([1, 2]), np.array([1, 9, 2], "u1")[::2]]
)
def test_octets_of_every_kind(octets: Any) -> None:
    """Whatever the codec takes for bytes comes as these bytes."""
    assert to_cbor(EVERYTHING(octets=octets))["octets"] == b"\1\2"


def test_what_does_not_belong_there() -> None:
    """A field that holds nothing of its kind is an error that names it."""
    with pytest.raises(CodecError, match="singles"):
        to_cbor(EVERYTHING(singles=["no number"]))


@pytest.mark.parametrize("kind", [bytes, bytearray, memoryview])
def test_raw(kind: type) -> None:
    """ROS's own bytes with the time, from any buffer."""
    seen = cbor2.loads(publish_cbor_raw("/t", 1, 2, kind(b"\x03\x04")))
    assert seen == {"op": "publish", "topic": "/t", "msg": {"secs": 1, "nsecs": 2, "bytes": b"\x03\x04"}}


def test_without_the_package(monkeypatch: pytest.MonkeyPatch) -> None:
    """The error names the extra, and is a RosError and an ImportError."""
    assert issubclass(MissingLibrary, RosError)
    assert issubclass(MissingLibrary, ImportError)
    monkeypatch.setitem(sys.modules, "cbor2", None)
    with pytest.raises(MissingLibrary, match=r'cbor2: pip install "\.\[bridge\]"'):
        publish_cbor_raw("/t", 1, 2, b"")
