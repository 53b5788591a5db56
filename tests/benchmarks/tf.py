"""Lookups of transforms beside tf2's buffer of Debian (C++, with its Python binding), on one interpreter, interleaved.

    PYTHONPATH=.:<site-packages with numpy> /usr/bin/python3 -m tests.benchmarks tf [--frames 2,10,50] [--rounds N]

Each frame of a chain moves below the next one, and has a pose every 10 ms for a second. Microseconds of a lookup
from the last frame to the first, the median of the rounds:

* again: the newest transform once more; nothing has changed.
* moved: the newest transform, after the last frame has got a new pose (setting it is not counted).
* times: at a past time between two poses, each time another one.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from typing import Any

from rosproto.tf import Transform, TransformBuffer

BEGIN, STEP, POSES = 1_000_000_000_000, 10_000_000, 100  # ns
LOOKUPS = 300  # of a round
IDLE = (0.0, 0.0, 0.0, 1.0)
Set = Callable[[str, str, int], object]
Look = Callable[[str, str, int], object]


def run(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="tests.benchmarks tf")
    parser.add_argument("--frames", default="2,10,50")
    parser.add_argument("--rounds", type=int, default=7)
    args = parser.parse_args(arguments)
    print("| frames | lookup | ours, us | tf2, us | tf2's time over ours |\n" + "|---" * 5 + "|")
    for frames in map(int, args.frames.split(",")):
        peers = {"ours": ours(), "tf2": tf2()}
        for place, _ in peers.values():
            fill(place, frames)
        for case in ("again", "moved", "times"):
            found: dict[str, list[float]] = {name: [] for name in peers}
            for number in range(args.rounds):
                for name, (place, look) in peers.items():
                    found[name].append(clock(case, frames, number, place, look))
            mine, theirs = (statistics.median(found[name]) for name in peers)
            print(f"| {frames} | {case} | {mine:.1f} | {theirs:.1f} | {theirs / mine:.2f} |", flush=True)


def ours() -> tuple[Set, Look]:
    buffer = TransformBuffer()

    def place(parent: str, child: str, stamp: int) -> None:
        buffer.set_transform(Transform(parent, child, (0.1, 0.0, 0.0), IDLE, stamp))

    return place, lambda target, source, stamp: buffer.lookup(target, source, stamp / 1e9 if stamp else None)


def tf2() -> tuple[Set, Look]:
    import rospy
    import tf2_py
    from geometry_msgs.msg import TransformStamped

    buffer: Any = tf2_py.BufferCore(rospy.Duration(10))

    def place(parent: str, child: str, stamp: int) -> None:
        message = TransformStamped()
        message.header.frame_id, message.child_frame_id = parent, child
        message.header.stamp = rospy.Time(*divmod(stamp, 10**9))
        message.transform.translation.x, message.transform.rotation.w = 0.1, 1.0
        buffer.set_transform(message, "benchmark")

    def look(target: str, source: str, stamp: int) -> object:
        return buffer.lookup_transform_core(target, source, rospy.Time(*divmod(stamp, 10**9)))

    return place, look


def fill(place: Set, frames: int) -> None:
    for n in range(POSES):
        for frame in range(1, frames):
            place(f"f{frame - 1}", f"f{frame}", BEGIN + n * STEP)


def clock(case: str, frames: int, number: int, place: Set, look: Look) -> float:
    """Microseconds of a lookup, the median: other programs interrupt a few."""
    target, source, each = "f0", f"f{frames - 1}", []
    for n in range(LOOKUPS):
        if case == "moved":  # all frames are known for another second
            place(f"f{frames - 2}", source, BEGIN + POSES * STEP + number * LOOKUPS + n)
        past = BEGIN + (n * 7 % (POSES - 1)) * STEP + STEP // 3 + number * LOOKUPS + n
        stamp = past if case == "times" else 0
        began = time.perf_counter()
        look(target, source, stamp)
        each.append(time.perf_counter() - began)
    return 1e6 * statistics.median(each)
