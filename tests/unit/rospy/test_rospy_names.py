"""Names and arguments that programs reach beside the common ones; each test in a process."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from rosproto.master import Master
from tests.support.rospy_program import ROOT, output, run

REACHED = """
    rospy.core.ROSInitException rospy.core.ROSInterruptException rospy.core.ns_join rospy.core.ParameterInvalid
    rospy.client.logwarn rospy.client.loginfo rospy.names.ns_join rospy.core._in_shutdown
    rospy.core.global_name rospy.core.is_topic rospy.client._Unspecified rospy.service.logger rospy.service.rospyerr
    rosgraph.roslogging.RospyLogger.findCaller rostopic._get_topic_type
    roslib.message.check_type roslib.packages.ROSPkgException rosnode._succeed
    tf2_ros.TFMessage tf2_ros.TransformStamped tf2_ros.BufferClient
    tf2_ros.transform_listener.TransformListener tf2_ros.transform_broadcaster.TransformBroadcaster
    tf2_ros.static_transform_broadcaster.StaticTransformBroadcaster tf2_ros.buffer_interface.TypeException
    tf2_ros.tf2.LookupException tf2_ros.GoalStatus tf.listener.xyz_to_mat44 tf.listener.xyzw_to_mat44
    tf.listener.transformations.quaternion_matrix sensor_msgs.point_cloud2._get_struct_fmt
    actionlib.simple_action_client.GoalStatus genpy.message.check_type
""".split()


def test_names_of_modules_inside_are_reached_as_attributes(tmp_path: Path) -> None:
    """As programs and the packages beside them write them."""
    code = f"""
        import actionlib, genpy, rosgraph.roslogging, roslib.message, roslib.packages, rosnode, rospy, rostopic
        import sensor_msgs.point_cloud2, tf, tf2_ros
        for name in {REACHED}:
            eval(name)
        print(tf2_ros.TransformListener.__module__)
    """
    assert output(code, tmp_path) == "tf2_ros.transform_listener\n"


def test_the_master_takes_its_arguments_by_name(tmp_path: Path) -> None:
    """rosgraph's names for them; a wrong one is a TypeError."""
    code = """
        import rosgraph
        master = rosgraph.Master(caller_id="/me")
        master.setParam(key="/a", value=3)
        print(master.getParam(key="/a"), master.hasParam("/a"), master.getPublishedTopics(subgraph=""))
        for wrong in (lambda: master.getParam(name="/a"), lambda: master.getParam(), lambda: master.getPid(1)):
            try:
                wrong()
            except TypeError as error:
                print(error)
    """
    with Master() as master:
        assert output(code, tmp_path, uri=master.uri).splitlines() == [
            "3 True []",
            "getParam() takes these arguments: key",
            "getParam() takes these arguments: key",
            "getPid() takes these arguments: none",
        ]


def test_a_node_may_have_any_name_and_namespace(tmp_path: Path) -> None:
    """As rospy, which warns of the name; a service whose name no master takes is not available."""
    code = """
        import rospy
        from std_srvs.srv import Empty
        rospy.init_node("my-node")
        print(rospy.get_name())
        try:
            rospy.ServiceProxy("not:a:name", Empty)()
        except rospy.ServiceException as error:
            print(error)
    """
    with Master() as master:
        done = run(code, tmp_path, uri=master.uri, ROS_NAMESPACE="robot.1")
    assert done.stdout.splitlines() == ["/robot.1/my-node", "service [/robot.1/not:a:name] unavailable"]
    assert "'my-node' is not a legal ROS base name. This may cause problems" in done.stderr


def test_packages_of_the_package_path(tmp_path: Path) -> None:
    """Found, listed and looked into; one that is not there is told with the path."""
    robot = tmp_path / "src" / "robot"
    (robot / "maps").mkdir(parents=True)
    (robot / "package.xml").touch()
    (robot / "maps" / "hall.yaml").touch()
    code = """
        from importlib.util import module_from_spec
        from rosproto.rospy.finder import FallbackFinder
        spec = FallbackFinder().find_spec("rospkg", None)  # ours also where another one is installed
        rospkg = module_from_spec(spec)
        spec.loader.exec_module(rospkg)
        import roslib.packages
        pack = rospkg.RosPack()
        print(pack.list(), pack.get_path("robot") == roslib.packages.get_pkg_dir("robot"))
        print(roslib.packages.find_resource("robot", "hall.yaml")[0][-16:].replace("\\\\", "/"))
        print(roslib.packages.get_pkg_subdir("robot", "maps")[-4:])
        try:
            pack.get_path("other")
        except rospkg.ResourceNotFound as error:
            print(str(error).splitlines()[0], error.ros_paths == pack.get_ros_paths())
    """
    assert output(code, tmp_path, ROS_PACKAGE_PATH=str(tmp_path / "src")).splitlines() == [
        "['robot'] True",
        "t/maps/hall.yaml",
        "maps",
        "other True",
    ]


def test_synchronisers_forget_when_simulated_time_jumps_back(tmp_path: Path) -> None:
    """With `reset`, a message of before the jump is not put together with one of after it."""
    code = """
        import rospy, rospy.rostime
        from message_filters import SimpleFilter, TimeSynchronizer
        from std_msgs.msg import Header

        class Stamped:
            def __init__(self, stamp, name):
                self.header, self.name = Header(stamp=rospy.Time(stamp)), name

        rospy.rostime.set_rostime_initialized(True)
        filters = [SimpleFilter(), SimpleFilter()]
        together = TimeSynchronizer(filters, 5, reset=True)
        together.registerCallback(lambda *found: print([one.name for one in found]))
        for now, index, name in (
            (100, 0, "a"), (100, 1, "b"), (101, 0, "old"), (101, 1, "far"), (50, 1, "new"), (50, 0, "newer"),
        ):
            rospy.rostime._set_rostime(rospy.Time(now))
            stamp = 7 if name in ("old", "new", "newer") else now
            filters[index].signalMessage(Stamped(stamp, name))
    """
    assert output(code, tmp_path).splitlines() == ["['a', 'b']", "['newer', 'new']"]


@pytest.mark.skipif(bool(sys.flags.isolated), reason="an embeddable Python takes no PYTHONPATH")
@pytest.mark.parametrize("name", ["roslaunch", "rosmaster"])
def test_what_a_ros_installation_builds_on_its_own_modules_says_why(tmp_path: Path, name: str) -> None:
    """Where real ROS is visible it was found, and failed for a module inside; the user's own is left alone."""
    for folder, package in [("ros", "rospy"), ("ros", name), ("own", name)]:
        (tmp_path / folder / package).mkdir(parents=True, exist_ok=True)
        text = "import rosgraph.xmlrpc\n" if folder == "ros" else "MINE = True\n"
        (tmp_path / folder / package / "__init__.py").write_text(text, "utf-8")
    code = f"""
        import importlib
        for module in ("{name}", "{name}.inside"):
            try:
                importlib.import_module(module)
            except ModuleNotFoundError as error:
                print(error.name, error)
            else:
                print(importlib.import_module(module).MINE)
                break
    """

    def told(folder: str) -> list[str]:
        path = os.pathsep.join([str(ROOT), str(tmp_path / folder)])
        return output(code, tmp_path, PYTHONPATH=path).splitlines()

    assert told("own") == ["True"]
    lines = told("ros")
    assert len(lines) == 2
    assert all(line.startswith(f"{name} No module named {name!r}: ") for line in lines)
    assert all("rosproto" in line for line in lines)


def test_a_package_has_the_modules_that_genpy_would_have_written(tmp_path: Path) -> None:
    """std_srvs has services only; a package that is nowhere is not a package."""
    own = tmp_path / "src" / "robot_bringup"
    own.mkdir(parents=True)
    (own / "package.xml").touch()
    code = """
        import importlib, os, roslib, sys
        for name in ("std_srvs.srv", "std_srvs.msg", "geometry_msgs.msg", "geometry_msgs.srv", "sensor_msgs.srv"):
            try:
                print(importlib.import_module(name).__name__)
            except ModuleNotFoundError as error:
                print(error)
        for name in ("rospy", "std_srvs", "woosh_msgs", "robot_bringup", "nowhere"):
            try:
                print(name, roslib.load_manifest(name))
            except Exception as error:
                print(type(error).__name__, str(error).splitlines()[0])
        sys.argv[0] = os.path.join(os.environ["ROS_PACKAGE_PATH"], "robot_bringup", "scripts", "drive.py")
        del os.environ["ROS_PACKAGE_PATH"]
        print(roslib.load_manifest("robot_bringup"))  # the program lies in it
    """
    assert output(code, tmp_path, ROS_PACKAGE_PATH=str(tmp_path / "src")).splitlines() == [
        "std_srvs.srv",
        "No module named 'std_srvs.msg'",
        "geometry_msgs.msg",
        "No module named 'geometry_msgs.srv'",
        "sensor_msgs.srv",
        "rospy None",
        "std_srvs None",
        "woosh_msgs None",
        "robot_bringup None",
        "ResourceNotFound nowhere",
        "None",
    ]
