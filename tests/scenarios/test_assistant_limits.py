"""An assistant's random goals at the limits of `woosh mcp`: the robot stays inside.

`python -m tests.support.assistant_goals 1000` sends more.
"""

from __future__ import annotations

import pytest

from tests.support.extras import needs

needs("mcp")

from tests.support.assistant_goals import MAX_DISTANCE, run  # noqa: E402 (after the skip)

pytestmark = [pytest.mark.slow, pytest.mark.timeout(300)]
SLACK = 0.8
"""m: at twelve times real time, the robot drives half a metre between two looks at it."""


@pytest.mark.promise("outside the limits of `woosh mcp`")
def test_random_goals_stay_inside() -> None:
    """Poses, steps and marks: what leads outside is refused, and the centre of the robot never is outside."""
    goals = run(20, seed=45)
    assert goals.wrong == []
    assert goals.outside < SLACK
    assert goals.farthest < MAX_DISTANCE + SLACK
    assert goals.outcomes["refused"] > 3
    assert goals.outcomes["reached"] > 1, goals.outcomes
