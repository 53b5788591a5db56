"""The frame tree alone: the history of an edge, the path between two frames, and why there is none."""

from __future__ import annotations

import pytest

from rosproto.tf.tree import OLD, REPEATED, FrameLoop, FrameTree, History, PoseUnknown, Sample, SeparateTrees

NOT_TURNED = (0.0, 0.0, 0.0, 1.0)


def sample(parent: str, x: float, stamp: int) -> Sample:
    return Sample(stamp, parent, (x, 0.0, 0.0), NOT_TURNED)


def tree(*edges: tuple[str, str, float, int]) -> FrameTree:
    """Of (child, parent, x, stamp); a stamp below zero is a frame that does not move."""
    made = FrameTree()
    for child, parent, x, stamp in edges:
        edge = made.edges.setdefault(child, History(10_000, static=stamp < 0))
        assert edge.add(sample(parent, x, max(stamp, 0))) is None
        made.names.update({child: None, parent: None})
    return made


def test_the_frames_of_a_way_are_told_on_either_side_of_where_they_meet() -> None:
    made = tree(
        ("odom", "map", 1, 5), ("base", "odom", 2, 5), ("laser", "base", 3, -1), ("mark", "map", 4, 5)
    )
    way = made.find_path("mark", "laser", 5)
    assert (way.source_side, way.target_side) == (["laser", "base", "odom"], ["mark"])
    assert way.translation == (2.0, 0.0, 0.0)


def test_a_gap_above_the_meeting_point_does_not_matter() -> None:
    made = tree(("base", "map", 1, 5), ("laser", "base", 3, -1), ("camera", "base", 1, -1))
    assert made.find_path("camera", "laser", 99).translation == (2.0, 0.0, 0.0)
    with pytest.raises(PoseUnknown) as gap:
        made.find_path("map", "laser", 99)
    assert (gap.value.child, gap.value.stamp) == ("base", 99)


def test_two_trees_are_told_by_their_roots() -> None:
    made = tree(("base", "map", 1, 5), ("palm", "island", 1, 5))
    for ask in (lambda: made.find_path("base", "palm", 5), lambda: made.latest_common_time("base", "palm")):
        with pytest.raises(SeparateTrees) as apart:
            ask()
        assert (apart.value.source_root, apart.value.target_root) == ("island", "map")


def test_a_loop_ends() -> None:
    made = tree(("a", "b", 1, 5), ("b", "a", 1, 5), ("x", "y", 1, 5))
    for target, source in (("x", "a"), ("a", "x")):
        with pytest.raises(FrameLoop):
            made.find_path(target, source, 5)
        with pytest.raises(FrameLoop):
            made.latest_common_time(target, source)


def test_the_latest_common_time_is_that_of_what_moves_below_the_meeting_point() -> None:
    made = tree(
        ("odom", "map", 1, 3), ("base", "odom", 1, 5), ("arm", "base", 1, 7), ("laser", "base", 1, -1)
    )
    assert made.latest_common_time("laser", "arm") == made.latest_common_time("arm", "laser") == 7
    assert made.latest_common_time("laser", "map") == made.latest_common_time("map", "arm") == 3
    assert made.latest_common_time("laser", "base") == made.latest_common_time("laser", "laser") == 0
    assert made.latest_common_time("arm", "arm") == 7


def test_what_an_edge_refuses_and_forgets() -> None:
    edge = History(10)
    assert [edge.add(sample("map", stamp, stamp)) for stamp in (20, 25, 25, 14, 31)] == [
        None,
        None,
        REPEATED,
        OLD,
        None,
    ]
    assert (len(edge), edge.earliest, edge.newest.stamp) == (2, 25, 31)
    assert edge.at(0) == edge.newest
    assert edge.at(24) is edge.at(32) is None
    assert edge.at(28).translation == (28.0, 0.0, 0.0)
    edge.clear()
    assert (len(edge), edge.at(0), edge.at(28)) == (0, None, None)


def test_of_what_does_not_move_the_last_pose_holds_for_ever() -> None:
    edge = History(10, static=True)
    assert [edge.add(sample("map", x, stamp)) for x, stamp in ((1.0, 50), (2.0, 5))] == [None, None]
    edge.clear()
    assert edge.at(10**18) == edge.at(0) == sample("map", 2.0, 5)
