"""Messages of rosbag.Bag in other processes, and what private names of rosbag's get."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosproto.codec import decode, define, encode
from tests.support.rospy_program import output

POOL = """
import multiprocessing
import os
import sys

import rosbag
from nav_msgs.msg import Odometry
from std_msgs.msg import String


def look(message):
    return message.header.frame_id, message


def main():
    os.chdir(os.path.dirname(os.path.abspath(__file__)))
    with rosbag.Bag("run.bag", "w") as bag:
        for i in range(3):
            message = Odometry()
            message.header.frame_id, message.pose.pose.position.x = "f%d" % i, i / 3
            bag.write("/odom", message)
    with rosbag.Bag("run.bag") as bag:
        messages = [message for _, message, _ in bag]
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        found = pool.map(look, messages)
    print([frame for frame, _ in found], [message for _, message in found] == messages)
    print(type(found[0][1]) is type(messages[0]), type(messages[0]).__name__)
    with rosbag.Bag("again.bag", "w") as bag:
        for _, message in found:
            bag.write("/odom", message)


if __name__ == "__main__":
    main()
"""


def test_messages_of_a_bag_go_to_a_process_and_back(tmp_path: Path) -> None:
    """They are pickled by type, md5sum and definition text, of which the other process makes the class."""
    assert output(POOL, tmp_path).splitlines() == ["['f0', 'f1', 'f2'] True", "True _nav_msgs__Odometry"]


def test_private_names_that_only_rosbag_uses_are_refused_in_words(tmp_path: Path) -> None:
    """The sentence says what reads messages instead; encryption is refused as not supported."""
    code = """
        import os
        import rosbag
        os.chdir(os.path.dirname(os.path.abspath(__file__)))
        with rosbag.Bag("run.bag", "w") as bag:
            for wrong in (lambda: bag._chunk_headers, lambda: bag.set_encryptor("rosbag/AesCbcEncryptor")):
                try:
                    wrong()
                except (AttributeError, rosbag.ROSBagEncryptNotSupportedException) as error:
                    print(error)
    """
    first, second = output(code, tmp_path).splitlines()
    assert "no attribute '_chunk_headers'" in first
    assert "_get_entries" in first
    assert "rosbag encrypt" in second


@pytest.mark.parametrize("style", ["numpy", "rospy"])
def test_a_field_may_be_named_cls(style: str) -> None:
    """By keyword, by position and on the wire."""
    cls = define("my_pkg/Named", "int32 cls\nint32 args\nint32 data\n", value_style=style)
    message = cls(cls=3, args=4)
    assert (message.cls, message.args, message.data) == (3, 4, 0)
    assert decode(cls, encode(message)) == message == cls(3, 4, 0)
