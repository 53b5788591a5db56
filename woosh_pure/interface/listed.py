"""Names of which no more is known than that a chassis has them; none is a row of the interface.

A type of the vendor's message package that fits is told, and taken for nothing more: what the robot shows
counts. `chassis.feed("/IO_output")` learns type and definition from it, as for every topic without a row.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

__all__ = ["LISTED", "ListedName"]


class ListedName(NamedTuple):
    """One name.

    Attributes:
        name: Resolved ROS name, of an action without `/goal`.
        likely_type: "package/Type" that fits, "" when none does. With the source "seen" the graph told it.
        source: "screenshot" (in the output of `rostopic list | head` on the vendor's page) or "seen" (in the
            graph of a real chassis, where no other node had to do with it).
        meaning: What the name suggests, "not known" when it suggests nothing.
    """

    name: str
    likely_type: str
    source: Literal["screenshot", "seen"]
    meaning: str


LISTED = (
    ListedName(
        "/IO_module_control",
        "woosh_msgs/IOModuleControl",
        "screenshot",
        "sets lines of a module; its `mode` is not documented",
    ),
    ListedName(
        "/IO_output", "woosh_msgs/IOs", "screenshot", "digital outputs; set or shown by it: not known"
    ),
    ListedName("/alley_adjust", "", "screenshot", "not known"),
    ListedName("/altenative_plan", "", "screenshot", "another path, by its name; its type is not known"),
    ListedName("/ar_tag_list", "woosh_msgs/ArTags", "screenshot", "visual tags in view"),
    ListedName(
        "/back_pavo2/parameter_descriptions",
        "dynamic_reconfigure/ConfigDescription",
        "screenshot",
        "which settings the rear lidar has",
    ),
    ListedName(
        "/back_pavo2/parameter_updates",
        "dynamic_reconfigure/Config",
        "screenshot",
        "settings of the rear lidar",
    ),
    ListedName("/enable_follower", "std_msgs/Bool", "seen", "written by /ros_interface: following on or off"),
    ListedName(
        "/follow/remote_control_request",
        "woosh_msgs/IOs",
        "seen",
        "read by /ros_interface: keys while following",
    ),
    ListedName(
        "/follow_base/local_costmap/set_footprint",
        "geometry_msgs/Polygon",
        "seen",
        "written by /ros_interface: the footprint while following",
    ),
    ListedName(
        "/xarm_base", "woosh_msgs/Arm", "seen", "action that /ros_interface asks for: an arm on the robot"
    ),
)
"""They are sorted by source, then as they were listed."""
