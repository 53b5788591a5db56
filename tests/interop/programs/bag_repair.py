"""Bags that were cut off or never closed: what opening, mending and appending do with them, and other versions."""

import io
import os
import struct
import tempfile

import rosbag
from genpy import Time
from std_msgs.msg import String

os.chdir(tempfile.mkdtemp())
with rosbag.Bag("whole.bag", "w", chunk_threshold=200) as bag:
    for i in range(30):
        bag.write("/a", String("x%d" % i), Time(10 + i))
with rosbag.Bag("empty.bag", "w"):
    pass
with open("whole.bag", "rb") as file:
    whole = file.read()
with open("empty.bag", "rb") as file:
    empty = file.read()
at = whole.index(b"index_pos=") + len("index_pos=")
index = struct.unpack_from("<Q", whole, at)[0]


def unclosed(data):
    return data[:at] + bytes(8) + data[at + 8 :]


def put(data):
    with open("test.bag", "wb") as file:
        file.write(data)


def attempt(what, function, *args, **kwds):
    try:
        print(what, function(*args, **kwds))
    except (rosbag.ROSBagException, io.UnsupportedOperation) as error:
        named = type(error), type(error).__name__
        text = str(error) if named[0] in (rosbag.ROSBagException, rosbag.ROSBagUnindexedException) else ""
        print(what, type(error).__module__, named[1], text)


def opened(mode, **options):
    with rosbag.Bag("test.bag", mode, **options) as bag:
        return bag.mode


def told():
    with rosbag.Bag("test.bag") as bag:
        return bag.version, bag.get_message_count(), [message.data for _, message, _ in bag][-2:]


def mended():
    with rosbag.Bag("test.bag", "a", allow_unindexed=True) as bag:
        steps = list(bag.reindex())
        print(len(steps), steps == sorted(steps), all(0 < step < index for step in steps))
    return told()


def continued():
    with rosbag.Bag("test.bag", "a", allow_unindexed=True) as bag:
        for _ in bag.reindex():
            pass
        bag.write("/a", String("more"), Time(1000))
        bag.write("/b", String("other"), Time(1001))
    return told()


CUTS = (0, 3, 12, 13, 20, 4000, 4116, 4117, 4118, len(whole) // 2, len(whole) - 1)
for cut in CUTS:
    for mode in "ra":
        for allow in (False, True):
            put(whole[:cut])
            where = CUTS.index(cut)
            attempt("%d %s %s" % (where, mode, allow), opened, mode, allow_unindexed=allow)
for version in (b"2.1", b"2.9", b"3.0", b"x"):
    for mode in "ra":
        put(whole.replace(b"V2.0", b"V" + version, 1))
        attempt(version.decode() + mode, opened, mode)
        if mode == "r" and version.startswith(b"2"):
            print(told())
for name, data in (
    ("sound", whole),
    ("without index", unclosed(whole[:index])),
    ("no messages", empty),
    ("nothing but a header", unclosed(empty)),
):
    put(data)
    attempt(name, opened, "r")
    attempt(name, mended)
    put(data)
    attempt(name, continued)
for name in ("ROSBagEncryptException", "ROSBagEncryptNotSupportedException"):
    error = getattr(rosbag.bag, name)
    print(error.__module__, error.__name__, error.__mro__[1].__name__, error("why"))
