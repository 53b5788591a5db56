"""Our transform tree and tf2's own C++ one (by its Python binding) give the same answers."""

from __future__ import annotations

import json
import random
from pathlib import Path

import pytest

from rosproto.quaternion import normalized
from rosproto.tf import (
    ExtrapolationError,
    NotConnected,
    Transform,
    TransformBuffer,
    TransformError,
    UnknownFrame,
)
from tests.support import ros

pytestmark = pytest.mark.interop

TF2 = r"""
import json, sys
import rospy, tf2_py
from geometry_msgs.msg import TransformStamped
def time(ns): return rospy.Time(ns // 10**9, ns % 10**9)
work = json.load(open(sys.argv[1]))
core = tf2_py.BufferCore(rospy.Duration(60))
for parent, child, p, q, ns, static in work["transforms"]:
    m = TransformStamped()
    m.header.frame_id, m.child_frame_id, m.header.stamp = parent, child, time(ns)
    t, r = m.transform.translation, m.transform.rotation
    t.x, t.y, t.z = p
    r.x, r.y, r.z, r.w = q
    (core.set_transform_static if static else core.set_transform)(m, "test")
answers = []
for target, source, ns in work["lookups"]:
    try:
        m = core.lookup_transform_core(target, source, time(ns))
        t, r = m.transform.translation, m.transform.rotation
        answers.append(["ok", [t.x, t.y, t.z], [r.x, r.y, r.z, r.w], m.header.stamp.to_nsec()])
    except Exception as error:
        answers.append([type(error).__name__])
json.dump(answers, sys.stdout)
"""
OUR_NAME = {
    ExtrapolationError: "ExtrapolationException",
    NotConnected: "ConnectivityException",
    UnknownFrame: "LookupException",
}


@pytest.fixture(autouse=True)
def _tf2_is_there():
    ros.require_ros("tf2_py")


def ask_tf2(transforms: list, lookups: list, tmp_path: Path) -> list:
    work = tmp_path / "work.json"
    work.write_text(json.dumps({"transforms": transforms, "lookups": lookups}))
    return json.loads(ros.run_rospy(TF2, "http://127.0.0.1:1", str(work)).stdout)


def ask_ours(transforms: list, lookups: list) -> list:
    buffer = TransformBuffer(10.0)
    for parent, child, p, q, ns, static in transforms:
        buffer.set_transform(Transform(parent, child, tuple(p), tuple(q), ns), static=static)
    answers = []
    for target, source, ns in lookups:
        try:
            found = buffer.lookup(target, source, ns / 1e9 if ns else None)
            answers.append(["ok", list(found.translation), list(found.rotation), found.stamp_ns])
        except TransformError as error:
            answers.append([OUR_NAME[type(error)]])
    return answers


def random_tree(chance: random.Random) -> list:
    """A tree of 8 frames (two of them static, one island), each moving one sampled at 2 to 30 moments."""
    transforms = []
    for child in range(1, 9):
        parent = "island" if child == 8 else f"f{chance.randrange(child)}"
        static = child in (3, 5)
        count = 1 if static else chance.randint(2, 30)
        for ns in sorted(chance.sample(range(10**9, 9 * 10**9, 10**7), count)):
            q = normalized(tuple(chance.uniform(-1, 1) for _ in range(4)))
            p = [chance.uniform(-5, 5) for _ in range(3)]
            transforms.append([parent, f"f{child}", p, list(q), ns, static])
    return transforms


def assert_same(ours: list, theirs: list, what: str) -> None:
    assert [answer[0] for answer in ours] == [answer[0] for answer in theirs], what
    for mine, reference in zip(ours, theirs, strict=True):
        if mine[0] == "ok":
            assert mine[1] == pytest.approx(reference[1], abs=1e-9), what
            dot = abs(sum(a * b for a, b in zip(mine[2], reference[2], strict=True)))
            assert dot == pytest.approx(1.0, abs=1e-9), what
            assert abs(mine[3] - reference[3]) <= 1, what


@pytest.mark.parametrize("seed", range(6))
def test_random_trees_are_looked_up_as_tf2_does(seed, tmp_path):
    chance = random.Random(seed)
    transforms = random_tree(chance)
    frames = [f"f{i}" for i in range(9)] + ["island", "nowhere"]
    lookups = [
        [
            chance.choice(frames),
            chance.choice(frames),
            chance.choice([0, chance.randrange(2 * 10**9, 8 * 10**9)]),
        ]
        for _ in range(200)
    ]
    ours, theirs = ask_ours(transforms, lookups), ask_tf2(transforms, lookups, tmp_path)
    for lookup, mine, reference in zip(lookups, ours, theirs, strict=True):
        assert_same([mine], [reference], f"{lookup}: ours {mine}, tf2 {reference}")
    assert len({answer[0] for answer in ours}) >= 3
