"""The levels of rosgraph_msgs/Log, of `logging`, and their names in roscpp/SetLoggerLevel, side by side.

`logging` is not imported for its constants.
"""

from __future__ import annotations

_TABLE = (
    # name, rosgraph_msgs/Log, logging
    ("debug", 1, 10),
    ("info", 2, 20),
    ("warn", 4, 30),
    ("error", 8, 40),
    ("fatal", 16, 50),
)

LEVELS = {name: python for name, _, python in _TABLE}
"""Name -> level of `logging`."""


def ros_level(levelno: int) -> int:
    """The level of rosgraph_msgs/Log for one of `logging`: the highest that is not above it."""
    return next((ros for _, ros, python in reversed(_TABLE) if levelno >= python), 1)


def python_level(level: int) -> int:
    """The level of `logging` for one of rosgraph_msgs/Log."""
    return next((python for _, ros, python in reversed(_TABLE) if level >= ros), 10)


def level_name(levelno: int) -> str:
    """ROS's name of a level of `logging`: the highest one that is not above it ("debug" below all)."""
    return next((name for name, _, python in reversed(_TABLE) if levelno >= python), "debug")
