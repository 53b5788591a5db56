"""Check bags: write and read one in a temporary folder, with each compression."""

from __future__ import annotations

import tempfile
from pathlib import Path

from rosproto.selftest.nodes import expect
from rosproto.sentence import say

_MESSAGES = 500


def check_bags() -> str:
    """Check that topics, times and values are read as they were written, in order."""
    from rosproto.bag import BagReader, BagWriter
    from rosproto.codec import message_class

    String, Imu = message_class("std_msgs/String"), message_class("sensor_msgs/Imu")
    size = 0
    with tempfile.TemporaryDirectory(prefix="rosproto-selftest-") as folder:
        for compression in ("none", "bz2", "lz4"):
            path = Path(folder, f"{compression}.bag")
            with BagWriter(path, compression=compression) as writer:
                for number in range(_MESSAGES):
                    writer.write("/words", String(data=f"第 {number}"), 1000.0 + number)
                    imu = Imu()
                    imu.linear_acceleration.x = number / 8
                    writer.write("/imu", imu, 1000.5 + number)
            with BagReader(path) as reader:
                read = list(reader.read_messages())
            words = [(t.to_sec(), message.data) for topic, message, t in read if topic == "/words"]
            expect(f"{compression}: texts", words, [(1000.0 + n, f"第 {n}") for n in range(_MESSAGES)])
            numbers = [message.linear_acceleration.x for topic, message, _ in read if topic == "/imu"]
            expect(f"{compression}: numbers", numbers, [n / 8 for n in range(_MESSAGES)])
            size += path.stat().st_size
    return say(
        "{count} messages, without compression, with bz2 and with lz4; {size} kB",
        count=2 * _MESSAGES,
        size=size // 1000,
    )
