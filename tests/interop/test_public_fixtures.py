"""The recordings that the public MCAP and rosbag repositories test their readers with, message by message.

None of them is here. ROSPROTO_FIXTURES names a folder with checkouts, or whatever else has recordings in it; without
it they are looked for in the cache of the tests (`fixtures`). Of foxglove/mcap it is tests/conformance/data (in Git LFS,
and made anew, to the same bytes, by generate-inputs.ts beside it), of cruise-automation/rosbag.js it is fixtures.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

from rosproto.bag import open_bag
from rosproto.errors import BagError
from tests.support.watched.plugin import CACHE

pytestmark = pytest.mark.slow
Seen = list[tuple[str, int, bytes]]


def recordings() -> list[Path]:
    cache = os.environ.get(CACHE) or os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    folder = Path(os.environ.get("ROSPROTO_FIXTURES") or Path(cache) / "rosproto-tests" / "fixtures")
    found = [path for path in folder.rglob("*") if path.suffix in (".bag", ".mcap") and path.is_file()]
    if not found:
        pytest.skip("no public fixtures: ROSPROTO_FIXTURES names no folder with recordings")
    return sorted(path for path in found if not is_pointer(path))


def is_pointer(path: Path) -> bool:
    """What Git LFS leaves in place of a file."""
    with open(path, "rb") as file:
        return file.read(18) == b"version https://gi"


def by_mcap(path: Path) -> Seen:
    reader: Any = pytest.importorskip("mcap.reader", reason="mcap is not installed (extra mcap)")
    with open(path, "rb") as file:
        messages = reader.NonSeekingReader(file).iter_messages(log_time_order=False)
        return [(channel.topic, message.log_time, message.data) for _, channel, message in messages]


def by_rosbags(path: Path) -> Seen:
    rosbag1: Any = pytest.importorskip("rosbags.rosbag1", reason="rosbags is not installed")
    with rosbag1.Reader(path) as bag:
        return [(connection.topic, stamp, bytes(data)) for connection, stamp, data in bag.messages()]


def by_us(path: Path) -> Seen:
    with open_bag(path) as bag:
        assert not bag.damage
        return [(topic, stamp.to_nsec(), raw.data) for topic, raw, stamp in bag.read_messages(raw=True)]


def test_they_agree_message_by_message() -> None:
    """With the readers of their makers; what those refuse is a sentence here."""
    counts = {".bag": 0, ".mcap": 0}
    for path in recordings():
        theirs: Any
        try:
            theirs = by_mcap(path) if path.suffix == ".mcap" else by_rosbags(path)
        except Exception as problem:  # of whatever kind
            theirs = problem
        if isinstance(theirs, Exception):
            with pytest.raises(BagError) as caught:
                by_us(path)
            assert path.name in str(caught.value)
            continue
        # In the order of time; of one time, in that of the file.
        assert by_us(path) == sorted(theirs, key=lambda seen: seen[1]), path
        counts[path.suffix] += 1
    assert sum(counts.values()), "nothing could be compared"
    print(counts)
