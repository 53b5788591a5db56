"""The topics of the interface that are recorded by default."""

from __future__ import annotations

import re

from rosproto.recording import TopicSelection
from woosh_pure.interface.table import find
from woosh_pure.interface.table import topics as rows

ALWAYS = ("pose", "battery")
"""Feeds that are in every recording, to show where the robot was and in which state."""
BEYOND_TABLE = ("/tf", "/tf_static", "/diagnostics", "/rosout", "/map", "/map_metadata")
GOALS = r"/[^/]+(?:/[^/]+)*/(?:goal|cancel|status|feedback|result)"
"""The topics of actions, the chassis's own and others."""
HEAVY = frozenset({"sensor_msgs/Image", "sensor_msgs/CompressedImage", "sensor_msgs/PointCloud2"})


def selection_of(
    topics: list[str] = [],  # noqa: B006  (never changed)
    *,
    camera: bool = False,
    all: bool = False,
    exclude: list[str] = [],  # noqa: B006
) -> TopicSelection:
    """What is recorded: pose and battery in any case, then the table's topics as they appear.

    Args:
        topics: More topics, in any case.
        camera: Images and point clouds too.
        all: Everything there is, also what is not the chassis's.
        exclude: Regular expressions for whole names; pose and battery stay.
    """
    named = [name for feed in ALWAYS for name in (find(feed).name, *find(feed).aliases)]
    known = [name for row in rows() if camera or row.type not in HEAVY for name in (row.name, *row.aliases)]
    patterns = [re.escape(name) for name in (*known, *BEYOND_TABLE)]
    return TopicSelection(
        [*named, *("/" + topic.lstrip("/") for topic in topics)],
        patterns=[*patterns, GOALS],
        exclude=exclude,
        all=all,
    )
