"""Columns that are cut out of the chunks are those that decoding gives."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest

from rosproto.bag import BagReader, BagWriter, columns
from rosproto.codec import define, message_class
from rosproto.time import Duration, Time

Odometry = message_class("nav_msgs/Odometry")
Mixed = define(
    "my_msgs/Mixed",
    """bool yes
byte small
char letter
uint16[3] three
float32[] any
string name
string[] names
time when
duration long
duration[2] longs
int64 large
geometry_msgs/Point[] points
std_msgs/String[2] said
float64 last
"""
    + "=" * 80 + "\nMSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n"
    + "=" * 80 + "\nMSG: std_msgs/String\nstring data\n",
)  # fmt: skip
PATHS = ["yes", "small", "letter", "three", "any", "when", "long", "large", "last"]


def mixed(i: int, *, name: str = "same", count: int = 4) -> Any:
    message = Mixed()
    message.yes, message.small, message.letter = bool(i % 2), -i % 100, i % 200
    message.three = np.arange(i, i + 3, dtype=np.uint16)
    message.any = np.arange(i, i + count, dtype=np.float32)
    message.name, message.names = name, ["a", "bc"]
    message.when, message.long = Time(i, 500), Duration(-i, 7)
    message.longs = [Duration(1, 2), Duration(3, 4)]
    message.large, message.last = i << 40, i / 7
    message.points = [message_class("geometry_msgs/Point")() for _ in range(2)]
    return message


def bag_of(messages: list[Any], compression: str = "none") -> BagReader:
    file = io.BytesIO()
    with BagWriter(file, compression, 3000) as writer:
        for i, message in enumerate(messages):
            writer.write("/x", message, 100 + i)
    return BagReader(file)


def both(bag: BagReader, paths: list[str], monkeypatch: pytest.MonkeyPatch) -> tuple[dict[str, Any], bool]:
    """What `to_numpy` gives, compared with decoding; and whether it was cut out."""
    found = bag.to_numpy("/x", paths)
    was_cut = columns._cut_out(bag, "/x", paths) is not None
    with monkeypatch.context() as patched:
        patched.setattr(columns, "_cut_out", lambda *_: None)
        decoded = bag.to_numpy("/x", paths)
    assert found.keys() == decoded.keys()
    for path, column in found.items():
        assert column.dtype == decoded[path].dtype, path
        assert column.shape == decoded[path].shape, path
        np.testing.assert_array_equal(column, decoded[path], path)
    return found, was_cut


@pytest.mark.parametrize("compression", ["none", "lz4"])
def test_every_kind_of_field(monkeypatch, compression):
    bag = bag_of([mixed(i) for i in range(100)], compression)
    found, was_cut = both(bag, PATHS, monkeypatch)
    assert was_cut
    assert found["large"].tolist() == [i << 40 for i in range(100)]
    assert found["three"].dtype == np.uint16
    assert found["any"].shape == (100, 4)
    assert found["when"][3] == pytest.approx(3.0000005)
    assert found["receive_time"].tolist() == [100.0 + i for i in range(100)]


def test_an_odometry_with_texts_in_its_header(monkeypatch):
    messages = [Odometry() for _ in range(50)]
    for i, message in enumerate(messages):
        message.header.frame_id, message.child_frame_id = "odom", "base_link"
        message.pose.pose.position.x = i / 2
    paths = ["pose.pose.position.x", "pose.covariance", "header.seq", "header.stamp"]
    found, was_cut = both(bag_of(messages), paths, monkeypatch)
    assert was_cut
    assert found["pose.pose.position.x"][7] == 3.5
    assert found["pose.covariance"].shape == (50, 36)


@pytest.mark.parametrize(
    "odd",
    [mixed(7, name="other!"), mixed(7, name="sa", count=4), mixed(7, count=5), mixed(7, name="", count=5)],
    ids=["longer text", "shorter text", "longer array", "same size, built differently"],
)
def test_one_message_built_differently_is_noticed(monkeypatch, odd):
    """Its fields lie elsewhere, also where its size happens to be the same."""
    messages = [mixed(i) for i in range(30)]
    messages[17] = odd
    found, was_cut = both(bag_of(messages), ["last", "large"], monkeypatch)
    assert not was_cut
    assert found["last"][17] == odd.last


def test_what_cannot_be_cut_out_is_decoded(monkeypatch):
    """Texts, lists of messages, elements, and messages with long lists before the field."""
    many = mixed(1)
    many.points = [message_class("geometry_msgs/Point")() for _ in range(40)]
    assert not both(bag_of([many] * 3), ["last"], monkeypatch)[1]
    assert bag_of([mixed(i) for i in range(3)]).to_numpy("/x", ["name"])["name"].tolist() == ["same"] * 3


def test_empty_arrays_and_overlapping_chunks(monkeypatch):
    found, was_cut = both(bag_of([mixed(i, count=0) for i in range(5)]), ["any"], monkeypatch)
    assert was_cut
    assert found["any"].shape == (5, 0)
    file = io.BytesIO()
    with BagWriter(file, chunk_bytes=3000) as writer:
        for i in range(100):
            writer.write("/x", mixed(i), (i * 37) % 100)
    found, was_cut = both(BagReader(file), ["last"], monkeypatch)
    assert not was_cut
    assert len(found["last"]) == 100


def test_several_publishers_of_one_topic(monkeypatch):
    """Each may have its own texts: decoded."""
    file = io.BytesIO()
    with BagWriter(file) as writer:
        for i in range(6):
            writer.write("/x", mixed(i, name="ab" * (i % 2)), i, header={"callerid": f"/{i % 2}"})
    assert BagReader(file).to_numpy("/x", ["last"])["last"].tolist() == [i / 7 for i in range(6)]


def test_a_topic_of_which_nothing_is_whole():
    """Left out where that was asked for: columns without rows."""
    file = io.BytesIO()
    with BagWriter(file, "lz4") as writer:
        for i in range(50):
            writer.write("/x", mixed(i), i)
    data = bytearray(file.getvalue())
    with BagReader(file) as sound:
        at = sound.chunks[0].pos
    data[at + 60 : at + 260] = b"\xff" * 200
    bag = BagReader(io.BytesIO(bytes(data)), skip_damaged=True)
    found = bag.to_numpy("/x", ["last"])
    assert {name: len(column) for name, column in found.items()} == {"receive_time": 0, "last": 0}
    assert bag.damage
