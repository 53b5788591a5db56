"""rosbag.Bag over damaged bags: the usual repair, and no error but rosbag's; in a process."""

from __future__ import annotations

from pathlib import Path

from tests.support.rospy_program import output

MADE = """
import io
import os
import struct
import rosbag
from genpy import Time
from std_msgs.msg import String

os.chdir(os.path.dirname(os.path.abspath(__file__)))
with rosbag.Bag("whole.bag", "w", chunk_threshold=200) as bag:
    for i in range(30):
        bag.write("/a", String("x%d" % i), Time(10 + i))
whole = open("whole.bag", "rb").read()
at = whole.index(b"index_pos=") + len("index_pos=")
index = struct.unpack_from("<Q", whole, at)[0]
unclosed = whole[:at] + bytes(8) + whole[at + 8 : index]

def put(data):
    with open("test.bag", "wb") as file:
        file.write(data)

def told(file="test.bag"):
    with rosbag.Bag(file) as bag:
        return bag.get_message_count(), [message.data for _, message, _ in bag][-1]

def attempt(function, *args, **kwds):
    try:
        print(function(*args, **kwds))
    except rosbag.ROSBagException as error:
        print(type(error).__name__)
"""


def lines(code: str, tmp_path: Path) -> list[str]:
    return output(MADE + code, tmp_path).splitlines()


def test_the_usual_repair(tmp_path: Path) -> None:
    """Never closed, or cut off in the last chunk: everything that is whole is there again, also to append to."""
    code = """
for data in (unclosed, unclosed[:-30], unclosed[:-100]):
    put(data)
    attempt(rosbag.Bag, "test.bag", "a")
    with rosbag.Bag("test.bag", "a", allow_unindexed=True) as bag:
        steps = []
        for position in bag.reindex():
            steps.append(position)
    print(len(steps), told())
    with rosbag.Bag("test.bag", "a") as bag:
        bag.write("/b", String("more"), Time(1000))
    print(told())
"""
    assert lines(code, tmp_path) == [
        "ROSBagUnindexedException",
        "9 (30, 'x29')",
        "(31, 'more')",
    ] * 2 + ["ROSBagUnindexedException", "8 (29, 'x28')", "(30, 'more')"]


def test_without_reindex_nothing_is_lost(tmp_path: Path) -> None:
    """Writing to an unindexed bag mends it first; closing it leaves it as it is."""
    code = """
put(unclosed)
rosbag.Bag("test.bag", "a", allow_unindexed=True).close()
print(open("test.bag", "rb").read() == unclosed)
with rosbag.Bag("test.bag", "a", allow_unindexed=True) as bag:
    print(bag.get_message_count(), len(list(bag)))
    bag.write("/b", String("more"), Time(1000))
print(told())
stream = io.BytesIO(unclosed)
with rosbag.Bag(stream, "a", allow_unindexed=True) as bag:
    print(len(list(bag.reindex())))
    bag.write("/b", String("more"), Time(1000))
stream.seek(0)
print(told(stream))
"""
    assert lines(code, tmp_path) == ["True", "30 30", "(31, 'more')", "9", "(31, 'more')"]


def test_no_error_but_rosbags(tmp_path: Path) -> None:
    """Whatever is wrong with the file, `except rosbag.ROSBagException` catches it, and is told why."""
    code = """
header = struct.unpack_from("<I", whole, 13)[0]
fields = whole[17 : 17 + header] + struct.pack("<I", 21) + b"encryptor=rosbag/AesC"
padding = 4096 - len(fields)
encrypted = whole[:13] + struct.pack("<I", len(fields)) + fields + struct.pack("<I", padding) + bytes(padding)
middle = unclosed[:4600] + b"\\xff" * 300 + unclosed[4900:]

def repaired(file="test.bag"):
    with rosbag.Bag(file, "a", allow_unindexed=True) as bag:
        for _ in bag.reindex():
            pass

def written():
    with rosbag.Bag("test.bag", "a", allow_unindexed=True) as bag:
        bag.write("/b", String("more"), Time(1000))

for data in (encrypted, middle, whole[:20], b"#ROSBAG V1.2\\n" + whole[13:]):
    put(data)
    for mode in "ra":
        attempt(lambda: str(rosbag.Bag("test.bag", mode, allow_unindexed=True)) and None)
    attempt(repaired)
    attempt(written)
put(whole[:4500] + b"\\xff" * 100 + whole[4600:])
bag = rosbag.Bag("test.bag")
attempt(lambda: list(bag))
bag.close()
put(b"")
attempt(bag.get_message_count)
"""
    assert lines(code, tmp_path) == [
        *["ROSBagEncryptNotSupportedException"] * 4,
        *["None"] * 2,
        *["ROSBagFormatException"] * 2,
        *["None"] * 2,
        *["ROSBagFormatException"] * 2,
        "ROSBagFormatException",
        *["ROSBagException"] * 3,
        "ROSBagFormatException",
        "ROSBagFormatException",
    ]
