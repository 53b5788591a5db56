"""Additions of `woosh foxglove` for a chassis: an overlay in the 3-D view, the map, and a layout.

In a program, with its own server:

    with Chassis() as chassis, ChassisTopics(chassis) as topics:
        with Foxglove(chassis.node, topics=topics.all) as server: ...
"""

from __future__ import annotations

from woosh_pure.foxglove.chassis_topics import ChassisTopics
from woosh_pure.foxglove.layout import chassis_layout, write_layout
from woosh_pure.foxglove.overlay import Overlay, OverlayState

__all__ = ["ChassisTopics", "Overlay", "OverlayState", "chassis_layout", "write_layout"]
