"""Small bags for the tests, and what they hold."""

from __future__ import annotations

import io
from typing import Any

from rosproto.bag import BagReader, BagWriter
from rosproto.codec import message_class
from rosproto.time import Time

String = message_class("std_msgs/String")
Twist = message_class("geometry_msgs/Twist")
PoseArray = message_class("geometry_msgs/PoseArray")
Float32MultiArray = message_class("std_msgs/Float32MultiArray")

COMPRESSIONS = ["none", "bz2", "lz4"]

Entry = tuple[str, Any, Time]


def entries(count: int) -> list[Entry]:
    """`count` messages on three topics, in the order of time, 0.1 s apart."""
    made: list[Entry] = []
    for i in range(count):
        stamp = Time(100 + i // 10, i % 10 * 100_000_000)
        if i % 5 == 4:
            made.append(("/data", Float32MultiArray(data=[float(i)] * (i % 40)), stamp))
        elif i % 2:
            made.append(("/chatter", String(data=f"hello {i}"), stamp))
        else:
            twist = Twist()
            twist.linear.x = float(i)
            made.append(("/cmd_vel", twist, stamp))
    return made


def bag_bytes(
    what: list[Entry], compression: str = "none", chunk_bytes: int = 1500, *, close: bool = True
) -> bytes:
    """A bag with these messages; without `close` what a writer that died leaves."""
    file = io.BytesIO()
    writer = BagWriter(file, compression, chunk_bytes)
    for topic, message, stamp in what:
        writer.write(topic, message, stamp)
    writer._chunks.drain()  # a recorder lives longer than a chunk is compressed
    if close:
        writer.close()
    return file.getvalue()


def read(data: bytes, **options: Any) -> BagReader:
    """A reader over bytes."""
    return BagReader(io.BytesIO(data), **options)


def plain(messages: Any) -> list[tuple[str, bytes, Time]]:
    """Comparable form of what a raw read gives."""
    return [(topic, raw.data, stamp) for topic, raw, stamp in messages]


def encoded(what: list[Entry]) -> list[tuple[str, bytes, Time]]:
    """The same of messages not written yet."""
    from rosproto.codec import encode

    return [(topic, encode(message), stamp) for topic, message, stamp in what]
