"""What is left of a way, and the line that says how far a goal has come."""

from __future__ import annotations

import pytest

from woosh_pure.geometry import Pose2D
from woosh_pure.motion import Progress
from woosh_pure.motion.progress import length_left

WAY = [Pose2D(0.0, 0.0), Pose2D(4.0, 0.0), Pose2D(4.0, 3.0)]


@pytest.mark.parametrize(
    ("here", "left"),
    [((0.0, 0.0), 7.0), ((1.0, 0.0), 6.0), ((3.0, 0.0), 4.0), ((4.0, 1.0), 2.0), ((4.0, 3.0), 0.0)],
)
def test_what_is_left_of_a_path(here: tuple[float, float], left: float) -> None:
    assert length_left(WAY, Pose2D(*here)) == pytest.approx(left)
    assert length_left([], Pose2D(*here)) is None


HERE = Pose2D(1.5, 0.0)


@pytest.mark.parametrize(
    ("progress", "line"),
    [
        (Progress(None, None, 0.4, None), "0 s"),
        (Progress(None, None, 3.0, HERE), "3 s   at x 1.50 m, y 0.00 m, 0°"),
        (Progress(0.0, 2.0, 0.0, None), "0 s   0 %, 2.0 m left"),
        (Progress(25.0, 1.5, 3.0, HERE), "3 s   25 %, 1.5 m left, about 9 s   at x 1.50 m, y 0.00 m, 0°"),
        (Progress(50.0, 0.0, 4.0, None), "4 s   50 %, about 4 s"),  # a turn has no metres
        (Progress(100.0, 0.0, 8.0, None), "8 s   100 %"),
    ],
)
def test_the_line_has_what_is_known(progress: Progress, line: str) -> None:
    """The rest takes as long as the part that is done; a robot that stands at the beginning has no estimate."""
    assert str(progress) == progress.sentence("en") == line


def test_the_line_is_chinese_where_the_user_is() -> None:
    line = Progress(25.0, 1.5, 3.0, HERE).sentence("zh")
    assert line == "3 秒   25 %，还剩 1.5 米，约 9 秒   位于 x 1.50 米，y 0.00 米，0°"
