"""Names that a chassis has, without further documentation; none is a row of the interface.

A matching type of the vendor's message package is given as a guess only. `chassis.feed("/IO_output")` learns
type and definition from the robot, as for every topic without a row.
"""

from __future__ import annotations

from typing import Literal, NamedTuple


class ListedName(NamedTuple):
    """One name.

    Attributes:
        name: Resolved ROS name, of an action without `/goal`.
        likely_type: Matching "package/Type", "" if none. With the source "seen" it comes from the graph.
        source: "screenshot" (in the output of `rostopic list | head` on the vendor's page) or "seen" (in the
            graph of a real chassis, used by no other node).
        meaning: Meaning suggested by the name, or "not known".
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
"""Sorted by source, then in the listed order."""
