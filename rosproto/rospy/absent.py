"""Modules of ROS that programs import and that cannot be provided: why, and what to use instead."""

from __future__ import annotations

import sys

_BRING = "it is pure Python; put its folder %s on PYTHONPATH"
_CPP = "it is a front end to C++ code of a ROS installation; "
_GUI = "it is one of ROS's windows; use matplotlib or a web page, or run that part on a computer with ROS"
_REMOTE = _CPP + "run that part on a computer with ROS and talk to it by topics, services and actions"

_ABSENT = {
    "camera_info_manager": _BRING % "src/camera_info_manager (of camera_info_manager_py)",
    "catkin": "nothing is built here: run the program's file itself",
    "interactive_markers": _BRING % "src/interactive_markers",
    "moveit_commander": _REMOTE,
    "nodelet": "nodelets are C++; run the node's stand-alone executable on a computer with ROS",
    "pcl": _CPP + "sensor_msgs.point_cloud2 gives the points; numpy or open3d work on them",
    "python_qt_binding": _GUI,
    "qt_gui": _GUI,
    "rclpy": "that is ROS 2; this layer speaks ROS 1 (import rospy)",
    "resource_retriever": "read the file by open(); rospkg.RosPack().get_path() gives a package's folder",
    "ros_numpy": _BRING % "src/ros_numpy",
    "roslaunch": (
        "launch files and the processes they start are not served: start the programs one by one "
        "(rosproto run FILE), or from Python by subprocess; `rosproto param load` loads YAML files"
    ),
    "rosmaster": "the master is rosproto's: rosproto.Master(), or the command `rosproto master`",
    "rosout": "rosproto.Node and `rosproto log echo` read /rosout",
    "rqt_gui": _GUI,
    "rqt_gui_py": _GUI,
    "rviz": _GUI,
    "smach": _BRING % "src/smach (of executive_smach)",
    "smach_ros": _BRING % "src/smach_ros (of executive_smach)",
    "tf2_kdl": "tf2_geometry_msgs moves messages between frames, tf_conversions.posemath makes PyKDL frames",
    "urdf_parser_py": "it is pure Python: pip install urdf-parser-py",
}
_DEFINITIONS = (
    "it is no package of this computer, and its definitions are not bundled. Give the folder that holds "
    "%s/msg/*.msg (rosproto run --msg-path FOLDER, or ROSPROTO_MSG_PATH), or put its generated code on "
    "PYTHONPATH"
)
_WITH_DEFINITIONS = frozenset({"beginner_tutorials", "roscpp_tutorials", "rospy_tutorials", "turtlesim"})


NOT_OVER_THIS = frozenset({"roslaunch", "rosmaster"})
"""Modules of a ROS installation that use parts of ROS modules that ours do not have."""


def absence(name: str) -> str | None:
    """Return the error text for a ROS module that was not found; None for other modules."""
    why = _ABSENT.get(name)
    if why is None and (name.endswith(("_msgs", "_srvs", "_interfaces")) or name in _WITH_DEFINITIONS):
        why = _DEFINITIONS % name
    return None if why is None else f"No module named {name!r}: {why}"


def is_imported() -> bool:
    """True when the calling finder was called by an import, not by importlib.util.find_spec."""
    frame = sys._getframe(2).f_back  # the finder's caller: importlib's _find_spec
    return frame is not None and frame.f_code.co_name == "_find_and_load_unlocked"
