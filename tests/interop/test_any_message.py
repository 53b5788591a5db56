"""AnyMsg on both sides of a link, as relays and taps have it: rospy's, ours, and rospy programs run by us."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from rosproto.codec import AnyMsg
from rosproto.node import Node
from tests.support import ros
from tests.support.ros import RosProcess

ROOT = Path(__file__).resolve().parents[2]
SENT = b"\x05\0\0\0hello"
PUBLISH = """
import rospy
rospy.init_node("mouth", disable_signals=True)
publisher = rospy.Publisher("/any", rospy.AnyMsg, queue_size=10, latch=True)
message = rospy.AnyMsg()
message._buff = b"\\x05\\0\\0\\0hello"
publisher.publish(message)
print("up", flush=True)
rospy.spin()
"""
LISTEN = """
import rospy
rospy.init_node("ear", disable_signals=True)
def callback(message):
    print("got", bytes(message._buff).hex(), message._connection_header["type"], flush=True)
    rospy.signal_shutdown("done")
subscriber = rospy.Subscriber("/any", rospy.AnyMsg, callback)
print("up", flush=True)
rospy.spin()
"""


def program(kind: str, code: str, master: str, folder: Path) -> RosProcess:
    """A rospy program, by Debian's rospy or by our layer; to be used in a `with`."""
    if kind == "rospy":
        return ros.start_rospy(code, master)
    path = folder / "program.py"
    path.write_text(code)
    command = [sys.executable, "-m", "rosproto.rospy", str(path)]
    return RosProcess(command, ros.environment(master, packages=ROOT))


@contextmanager
def publishing(kind: str, master: str, folder: Path) -> Iterator[None]:
    if kind == "node":
        with Node("/mouth", master_uri=master, rosout=False) as node:
            node.publisher("/any", AnyMsg, latch=True).publish(AnyMsg(_buff=SENT))
            yield
    else:
        with program(kind, PUBLISH, master, folder) as process:
            process.wait_for("up")
            yield


def heard(kind: str, master: str, folder: Path) -> Any:
    """What a subscriber of AnyMsg gets: the bytes, and the type in the header."""
    if kind == "node":
        with Node("/ear", master_uri=master, rosout=False) as node:
            message = node.subscriber("/any", AnyMsg).next(60)
            return message._buff, message._connection_header["type"]
    with program(kind, LISTEN, master, folder) as process:
        got = process.wait_for(r"got (\S+) (\S+)\n")
        return bytes.fromhex(got[1]), got[2]


@pytest.mark.promise("A subscriber or service client may send `*`")
@pytest.mark.parametrize("subscriber", ["rospy", "node", "layer"])
@pytest.mark.parametrize("publisher", ["rospy", "node", "layer"])
def test_any_message_arrives(any_master: str, tmp_path: Path, publisher: str, subscriber: str) -> None:
    """rospy to rospy is the measure; nothing else may differ from it."""
    (tmp_path / "mouth").mkdir()
    (tmp_path / "ear").mkdir()
    with publishing(publisher, any_master, tmp_path / "mouth"):
        assert heard(subscriber, any_master, tmp_path / "ear") == (SENT, "*")
