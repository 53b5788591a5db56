"""Many threads use one class from its first moment."""

from __future__ import annotations

import gc
import threading
from collections.abc import Callable
from typing import Any

from rosproto.codec import decode, define, encode, message_class
from rosproto.msg import bundled


def together(work: Callable[[], Any], count: int = 8) -> list[Any]:
    """Run `work` in threads that start at one moment; their results."""
    barrier = threading.Barrier(count)
    results: list[Any] = []

    def run() -> None:
        barrier.wait(10)
        results.append(work())

    threads = [threading.Thread(target=run, daemon=True) for _ in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(30)
    assert len(results) == count
    return results


def test_a_class_is_made_once() -> None:
    """However many ask at the same time."""
    library = bundled().fork()
    assert len(set(together(lambda: message_class("nav_msgs/Odometry", library)))) == 1
    assert len(set(together(lambda: define("a/Thread", "float64 x")))) == 1


def test_functions_are_generated_under_fire() -> None:
    """The first encode and decode of a class may come from several threads."""
    library = bundled().fork()
    cls = message_class("nav_msgs/Path", library)
    pose = message_class("geometry_msgs/PoseStamped", library)

    def work() -> bytes:
        message = cls(poses=[pose() for _ in range(400)])
        message.poses[3].header.frame_id = "map"
        data = encode(message)
        assert decode(cls, data) == message
        return data

    assert len(set(together(work))) == 1
    assert gc.isenabled()
