"""Names and arguments that programs reach beside the common ones; each test in a process."""

from __future__ import annotations

from pathlib import Path

from rosproto.master import Master
from tests.support.rospy_program import output

REACHED = """
    rospy.core.ROSInitException rospy.core.ROSInterruptException rospy.core.ns_join rospy.core.ParameterInvalid
    rospy.client.logwarn rospy.client.loginfo rospy.names.ns_join rospy.core._in_shutdown
    roslib.message.check_type roslib.packages.ROSPkgException rosnode._succeed
    tf2_ros.TFMessage tf2_ros.TransformStamped tf2_ros.BufferClient
    tf2_ros.transform_listener.TransformListener tf2_ros.transform_broadcaster.TransformBroadcaster
    tf2_ros.static_transform_broadcaster.StaticTransformBroadcaster tf2_ros.buffer_interface.TypeException
    actionlib.simple_action_client.GoalStatus genpy.message.check_type
""".split()


def test_names_of_modules_inside_are_reached_as_attributes(tmp_path: Path) -> None:
    """As programs and the packages beside them write them."""
    code = f"""
        import actionlib, genpy, roslib.message, roslib.packages, rosnode, rospy, tf2_ros
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
