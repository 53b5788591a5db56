"""The transform buffer: lookups over edges and time, and the errors."""

from __future__ import annotations

import math
import random
import threading
import tracemalloc

import pytest

from rosproto.errors import RosTimeout
from rosproto.tf import (
    ExtrapolationError,
    NotConnected,
    Transform,
    TransformBuffer,
    TransformError,
    UnknownFrame,
)
from rosproto.tf.tree import MAX_KEPT, FrameTree, History, Sample


def edge(parent: str, child: str, x: float, stamp: float = 0.0, yaw: float = 0.0) -> Transform:
    return Transform.planar(parent, child, x, 0.0, yaw, stamp=stamp)


def robot() -> TransformBuffer:
    """map -> odom at 1, 2, 3 s; odom -> base at 1, 2 s; base -> laser static."""
    buffer = TransformBuffer()
    for stamp in (1.0, 2.0, 3.0):
        buffer.set_transform(edge("map", "odom", 10 * stamp, stamp))
    for stamp in (1.0, 2.0):
        buffer.set_transform(edge("odom", "base", stamp, stamp))
    buffer.set_transform(edge("base", "laser", 0.1), static=True)
    return buffer


def test_a_chain_is_composed_at_one_time():
    assert robot().lookup("map", "laser", 2.0).translation == pytest.approx((22.1, 0, 0))


def test_the_latest_time_is_the_newest_that_all_moving_edges_share():
    found = robot().lookup("map", "laser")
    assert found.stamp_ns == 2_000_000_000
    assert found.translation == pytest.approx((22.1, 0, 0))


def test_between_two_samples_it_is_interpolated():
    assert robot().lookup("map", "base", 1.5).translation == pytest.approx((16.5, 0, 0))


def test_rotation_is_interpolated_on_the_shorter_arc():
    buffer = TransformBuffer()
    buffer.set_transform(edge("a", "b", 0, 1.0, yaw=math.radians(170)))
    buffer.set_transform(edge("a", "b", 0, 2.0, yaw=math.radians(-170)))
    assert abs(buffer.lookup("a", "b", 1.5).yaw) == pytest.approx(math.pi)


def test_the_way_down_is_the_inverse_of_the_way_up():
    buffer = robot()
    up, down = buffer.lookup("map", "laser", 1.5), buffer.lookup("laser", "map", 1.5)
    assert (up @ down).translation == pytest.approx((0, 0, 0))


def test_siblings_meet_at_their_common_ancestor_only():
    buffer = robot()
    buffer.set_transform(edge("base", "camera", 0.4), static=True)
    found = buffer.lookup("camera", "laser", 9999.0)  # what moves above does not matter
    assert found.translation == pytest.approx((-0.3, 0, 0))


def test_only_static_edges_hold_at_any_time_and_their_latest_time_is_zero():
    buffer = robot()
    assert buffer.lookup("base", "laser").stamp_ns == 0
    assert buffer.lookup("base", "laser", 12345.0).translation == pytest.approx((0.1, 0, 0))


def test_a_frame_to_itself_is_the_identity():
    assert robot().lookup("base", "base", 1.0).translation == (0, 0, 0)


def test_a_leading_slash_is_nothing():
    assert robot().lookup("/map", "/laser", 2.0).target == "map"


def test_an_unknown_frame_is_named_with_its_neighbours():
    with pytest.raises(UnknownFrame, match=r"'base_lin' is unknown; known are base") as caught:
        robot().lookup("map", "base_lin")
    assert caught.value.frame == "base_lin"


def test_two_trees_are_told_with_their_roots():
    buffer = robot()
    buffer.set_transform(edge("island", "palm", 1.0, 1.0))
    for time in (None, 1.0):
        with pytest.raises(NotConnected) as caught:
            buffer.lookup("map", "palm", time)
        assert (caught.value.target_root, caught.value.source_root) == ("map", "island")


def test_the_future_is_refused_naming_the_edge_and_the_times():
    with pytest.raises(
        ExtrapolationError, match=r"odom -> base is known from 1\.0.* to 2\.0.*0\.5 s in the future"
    ) as caught:
        robot().lookup("map", "laser", 2.5)
    error = caught.value
    assert (error.parent, error.child) == ("odom", "base")
    assert (error.requested, error.earliest, error.latest) == (2.5, 1.0, 2.0)


def test_the_past_is_refused():
    with pytest.raises(ExtrapolationError, match="in the past"):
        robot().lookup("map", "base", 0.5)


def test_every_refusal_is_a_transform_error():
    with pytest.raises(TransformError):
        robot().lookup("map", "nowhere")


def test_what_is_older_than_the_cache_is_forgotten():
    buffer = TransformBuffer(cache_time=10.0)
    for stamp in range(1, 31):
        buffer.set_transform(edge("a", "b", stamp, float(stamp)))
    assert buffer.frames()["b"]["earliest"] == 20.0
    assert not buffer.set_transform(edge("a", "b", 0, 5.0))
    with pytest.raises(ExtrapolationError):
        buffer.lookup("a", "b", 19.0)


def test_samples_may_come_out_of_order_but_a_stamp_once_only():
    buffer = TransformBuffer()
    for stamp, x in ((1.0, 1), (3.0, 3), (2.0, 7)):
        assert buffer.set_transform(edge("a", "b", x, stamp))
    assert not buffer.set_transform(edge("a", "b", 99, 2.0))
    assert buffer.lookup("a", "b", 2.0).translation[0] == 7


def test_a_frame_that_changes_its_parent_keeps_the_old_pose_until_then():
    buffer = TransformBuffer()
    buffer.set_transform(edge("map", "table", 5, 1.0))
    buffer.set_transform(edge("map", "hand", 1, 1.0))
    buffer.set_transform(edge("map", "hand", 1, 2.0))
    buffer.set_transform(edge("table", "cup", 1, 1.0))
    buffer.set_transform(edge("hand", "cup", 0, 2.0))
    buffer.set_transform(edge("map", "table", 5, 2.0))
    assert buffer.lookup("map", "cup", 1.5).translation[0] == pytest.approx(6)
    assert buffer.lookup("map", "cup", 2.0).translation[0] == pytest.approx(1)


def test_different_times_meet_in_a_fixed_frame():
    buffer = robot()
    # base was at 11 (t=1) and is at 22 (t=2) in map
    moved = buffer.lookup_full("base", 2.0, "base", 1.0, "map")
    assert moved.translation == pytest.approx((-11, 0, 0))
    assert moved.stamp_ns == 2_000_000_000


@pytest.mark.parametrize(
    "wrong",
    [
        Transform("a", "a"),
        Transform("", "b"),
        Transform("/", "b"),
        Transform("a", "b", (math.nan, 0, 0)),
        Transform("a", "b", (0, 0, 0), (0, 0, 0, 0)),
        Transform("a", "b", (0, 0, 0), (0, 0, 0, 1.1)),
    ],
)
def test_nonsense_is_refused(wrong):
    buffer = TransformBuffer()
    with pytest.raises(ValueError):
        buffer.set_transform(wrong)
    assert buffer.frames() == {}


def test_a_loop_of_frames_ends_in_an_error():
    buffer = TransformBuffer()
    buffer.set_transform(edge("a", "b", 1, 1.0))
    buffer.set_transform(edge("b", "a", 1, 1.0))
    buffer.set_transform(edge("x", "y", 1, 1.0))
    for time in (None, 1.0):
        with pytest.raises(NotConnected):
            buffer.lookup("a", "y", time)


@pytest.mark.promise(
    "A transform buffer takes 10,000 frames, 50,000 poses of each, and names of 1000 characters"
)
def test_the_number_of_frames_and_samples_is_bounded():
    buffer = TransformBuffer(max_frames=3, max_samples=5)
    for i in range(20):
        buffer.set_transform(edge(f"parent{i}", "c", 1, 1 + i / 100))
    assert buffer.frames()["c"]["samples"] == 5
    buffer.set_transform(edge("a", "d", 1, 1.0))
    buffer.set_transform(edge("a", "e", 1, 1.0))
    with pytest.raises(ValueError, match="which is the limit"):
        buffer.set_transform(edge("a", "f", 1, 1.0))
    assert len(known(buffer, [*"acdef", *(f"parent{i}" for i in range(20))])) <= 6


def known(buffer: TransformBuffer, frames: list[str]) -> set[str]:
    """The frames of these that the buffer does not call unknown."""
    found = set(frames)
    for frame in frames:
        try:
            buffer.lookup(frame, "no such frame")
        except UnknownFrame as error:
            found -= {error.frame}
    return found


def test_waiting_ends_as_soon_as_the_transform_comes():
    buffer = TransformBuffer()
    asked = threading.Event()

    def later():
        asked.wait(20)
        buffer.set_transform(edge("a", "b", 4, 1.0))

    thread = threading.Thread(target=later)
    thread.start()
    asked.set()
    assert buffer.lookup("a", "b", timeout=20).translation[0] == 4
    thread.join()


def test_waiting_in_vain_says_what_is_missing():
    with pytest.raises(RosTimeout, match="frame 'a' is unknown"):
        TransformBuffer().wait("a", "b", timeout=0.01)


def test_clearing_forgets_what_moves():
    buffer = robot()
    buffer.clear()
    assert list(buffer.frames()) == ["laser"]
    assert not buffer.can_lookup("map", "laser")


@pytest.mark.promise(
    "A transform buffer takes 10,000 frames, 50,000 poses of each, and names of 1000 characters"
)
def test_names_of_frames_are_bounded_in_number_and_length():
    """New parents, new children, and one that is longer than any name; what is known stays."""
    buffer = TransformBuffer(max_frames=10)
    for i in range(200):
        buffer.set_transform(edge(f"parent{i}", f"c{i % 10}", 1, 1 + i / 100))
        if i % 20 == 0 or i > 195:
            assert len(known(buffer, [f"parent{j}" for j in range(i + 1)])) <= 25 - 10
    assert buffer.can_lookup("parent199", "c9")
    for child, parent in (("x" * 1001, "a"), ("a", "x" * 1001)):
        with pytest.raises(ValueError, match="1001 characters"):
            buffer.set_transform(edge(parent, child, 1, 1.0))
    assert buffer.frames()["c9"]["parent"] == "parent199"


def test_former_parents_are_dropped_seldom(monkeypatch):
    """Each clean-up goes through all frames: also when every frame has a new parent."""
    tree, count = FrameTree(100), []
    original = FrameTree.drop_former_parents
    monkeypatch.setattr(FrameTree, "drop_former_parents", lambda self: count.append(original(self)))
    for i in range(100):
        tree.edges[f"c{i}"] = History(10)
        tree.edges[f"c{i}"].add(Sample(0, f"p{i}", (0, 0, 0), (0, 0, 0, 1)))
    for i in range(1000):
        tree.remember_names("c0", f"new{i}")
        assert len(tree.names) <= 250
    assert len(count) <= 21


# -- what a lookup keeps for the next one --------------------------------------------------------------------


def asked(buffer: TransformBuffer, lookups: list[tuple[str, str, float | None]]) -> list[object]:
    answers: list[object] = []
    for target, source, moment in lookups:
        try:
            answers.append(buffer.lookup(target, source, moment))
        except TransformError as error:
            answers.append((type(error), str(error)))
    return answers


@pytest.mark.parametrize("seed", range(5))
def test_a_changing_tree_answers_as_one_that_was_never_asked(seed):
    """Frames move, change parents, become static, are inserted late, and are forgotten, between lookups."""
    chance = random.Random(seed)
    frames = [f"f{i}" for i in range(7)]
    lookups = [
        (chance.choice(frames), chance.choice(frames), chance.choice([None, None, 2.5, 4.0, 6.25]))
        for _ in range(15)
    ]
    changes, used = [], TransformBuffer(6.0)
    for _ in range(50):
        child = chance.randrange(1, 7)
        parent = child // 2 if chance.random() < 0.8 else chance.choice([i for i in range(7) if i != child])
        pose = Transform.planar(
            f"f{parent}", f"f{child}", chance.uniform(-5, 5), 1.0, chance.uniform(-3, 3),
            stamp=chance.choice([1, 2, 3, 4, 5, 6, 7, 12]),
        )  # fmt: skip
        static, clear = chance.random() < 0.2, chance.random() < 0.05

        def change(buffer, pose=pose, static=static, clear=clear):
            buffer.set_transform(pose, static=static)
            if clear:
                buffer.clear()

        changes.append(change)
        change(used)
        fresh = TransformBuffer(6.0)
        for one in changes:
            one(fresh)
        assert asked(used, lookups) == asked(fresh, lookups)


def test_a_static_frame_that_is_sent_again_replaces_the_old_pose():
    buffer = TransformBuffer()
    buffer.set_transform(Transform.planar("map", "base", 1.0, 0, 0, stamp=1.0))
    for x in (1.0, 2.0, 2.0):
        buffer.set_transform(Transform.planar("base", "laser", x, 0, 0), static=True)
        assert (
            buffer.lookup("map", "laser").translation[0]
            == buffer.lookup("map", "laser", 1.0).translation[0]
            == 1 + x
        )


def test_a_frame_with_another_parent_is_looked_up_there():
    buffer = TransformBuffer()
    for parent, child, x in (("map", "shelf", 5.0), ("map", "base", 1.0), ("shelf", "box", 0.5)):
        buffer.set_transform(Transform.planar(parent, child, x, 0, 0, stamp=1.0))
    assert buffer.lookup("map", "box").translation[0] == 5.5
    buffer.set_transform(Transform.planar("base", "box", 0.25, 0, 0, stamp=2.0))
    buffer.set_transform(Transform.planar("map", "base", 1.0, 0, 0, stamp=2.0))
    assert buffer.lookup("map", "box", 2.0).translation[0] == 1.25
    assert buffer.lookup("map", "box", 1.0).translation[0] == 5.5
    buffer.clear()
    with pytest.raises(TransformError):
        buffer.lookup("map", "box", 1.0)


def test_what_is_kept_for_the_next_lookup_is_bounded():
    tree = FrameTree()
    for i in range(6 * MAX_KEPT):
        tree.edges[f"f{i}"] = history = History(10**10)
        history.add(Sample(1, "map", (float(i), 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)))

    def look_up(frames: range) -> int:
        for i in frames:
            assert tree.lookup("map", f"f{i}", 0)[0][0][0] == i
            assert tree.find_path(f"f{i}", "map", 1).translation[0] == -i
        return tracemalloc.get_traced_memory()[0]

    tracemalloc.start()
    try:
        first = look_up(range(2 * MAX_KEPT))
        assert look_up(range(2 * MAX_KEPT, 6 * MAX_KEPT)) - first < 300 * MAX_KEPT  # bytes; each takes 900
    finally:
        tracemalloc.stop()
