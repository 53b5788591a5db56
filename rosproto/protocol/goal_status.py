"""The status of one goal, as actionlib_msgs/GoalStatus numbers it.

Source: wiki.ros.org/actionlib/DetailedDescription, actionlib_msgs/msg/GoalStatus.msg.
"""

from __future__ import annotations

from collections.abc import Iterator
from enum import IntEnum


class GoalStatus(IntEnum):
    """Status of a goal as the server reports it; LOST is a client's own conclusion and never sent."""

    PENDING = 0
    ACTIVE = 1
    PREEMPTED = 2
    SUCCEEDED = 3
    ABORTED = 4
    REJECTED = 5
    PREEMPTING = 6
    RECALLING = 7
    RECALLED = 8
    LOST = 9

    @property
    def is_terminal(self) -> bool:
        """Whether the goal has ended, successfully or not."""
        return self not in _UNDER_WAY


_UNDER_WAY = frozenset((GoalStatus.PENDING, GoalStatus.ACTIVE, GoalStatus.PREEMPTING, GoalStatus.RECALLING))


def read_table(text: str) -> Iterator[tuple[str, str, str]]:
    """Yield (row, column, cell) of a table as text: the first line names the columns, each row begins with
    its name.
    """
    head, *rows = text.strip().splitlines()
    for row in rows:
        name, *cells = row.split()
        for column, cell in zip(head.split(), cells, strict=True):
            yield name, column, cell
