"""Modules beside rospy that programs import, and what a program's last moments still do; each in a process."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import rosproto
from rosproto.master import Master
from tests.support.rospy_program import output, run


def test_a_hook_still_publishes_when_the_program_simply_ends(tmp_path: Path) -> None:
    """The zero velocity of an on_shutdown hook arrives: the node is closed after the hooks, not before."""
    code = """
        import sys
        import rospy
        from geometry_msgs.msg import Twist, Vector3
        rospy.init_node("driver")
        pub = rospy.Publisher("/cmd", Twist, queue_size=1)
        def stop():
            pub.publish(Twist())
            rospy.sleep(0.2)
        rospy.on_shutdown(stop)
        while not pub.get_num_connections():
            rospy.sleep(0.02)
        pub.publish(Twist(linear=Vector3(0.5, 0, 0)))
        sys.exit(3)
    """
    with Master() as master, rosproto.Node("/ear", master_uri=master.uri) as node:
        heard = node.subscriber("/cmd", "geometry_msgs/Twist", queue_size=10)
        assert run(code, tmp_path, uri=master.uri).returncode == 3
        assert [heard.next(20).linear.x, heard.next(20).linear.x] == [0.5, 0.0]


def test_headers_reach_the_other_side(tmp_path: Path) -> None:
    """`headers=` of a publisher is in the connection header, from the first subscriber on."""
    code = """
        import rospy
        from std_msgs.msg import String
        rospy.init_node("talker")
        pub = rospy.Publisher("/talk", String, headers={"pi": "3.14"}, latch=True, queue_size=1)
        pub.publish("x")
        rospy.wait_for_message("/over", String, 20)
    """
    with Master() as master, rosproto.Node("/ear", master_uri=master.uri) as node:
        over = node.publisher("/over", "std_msgs/String", latch=True)
        with node.subscriber("/talk", "std_msgs/String") as heard:
            from concurrent.futures import ThreadPoolExecutor

            with ThreadPoolExecutor(1) as pool:
                ended = pool.submit(run, code, tmp_path, uri=master.uri)
                message = heard.next(20)
                over.publish(data="over")
                assert ended.result().returncode == 0
    assert message._connection_header["pi"] == "3.14"


def test_point_clouds_in_another_frame(tmp_path: Path) -> None:
    """tf2_sensor_msgs: x, y, z move, the other fields stay; a quarter turn and a step."""
    code = """
        import sensor_msgs.point_cloud2 as pc2
        from geometry_msgs.msg import TransformStamped
        from sensor_msgs.msg import PointField
        from std_msgs.msg import Header
        from tf2_sensor_msgs import do_transform_cloud
        fields = [PointField(name, 4 * i, PointField.FLOAT32, 1) for i, name in enumerate("xyzi")]
        cloud = pc2.create_cloud(Header(frame_id="laser"), fields, [(1, 2, 3, 9), (0, 0, 0, 8)])
        moved = TransformStamped()
        moved.header.frame_id = "map"
        moved.transform.translation.x = 10
        moved.transform.rotation.z = moved.transform.rotation.w = 0.5 ** 0.5
        moved = do_transform_cloud(cloud, moved)
        print(moved.header.frame_id, [[round(v, 6) for v in point] for point in pc2.read_points(moved)])
    """
    assert output(code, tmp_path) == "map [[8.0, 1.0, 3.0, 9.0], [10.0, 0.0, 0.0, 8.0]]\n"


def test_modules_inside_packages_are_imported_by_their_full_names(tmp_path: Path) -> None:
    """Many programs name the module in which ROS has a function or class, and get the same one."""
    code = """
        import image_geometry, laser_geometry, tf2_geometry_msgs, tf2_sensor_msgs
        from image_geometry.cameramodels import PinholeCameraModel, StereoCameraModel
        from laser_geometry.laser_geometry import LaserProjection
        from tf2_geometry_msgs.tf2_geometry_msgs import do_transform_pose
        from tf2_sensor_msgs.tf2_sensor_msgs import do_transform_cloud
        print(PinholeCameraModel is image_geometry.PinholeCameraModel, LaserProjection is laser_geometry.LaserProjection)
        print(do_transform_pose is tf2_geometry_msgs.do_transform_pose)
        print(do_transform_cloud is tf2_sensor_msgs.do_transform_cloud)
    """
    assert output(code, tmp_path).split() == ["True"] * 4


def test_point_clouds(tmp_path: Path) -> None:
    """sensor_msgs.point_cloud2 (values as Debian's gave them)."""
    code = """
        import sensor_msgs.point_cloud2 as pc2
        from sensor_msgs.msg import PointField
        from std_msgs.msg import Header
        cloud = pc2.create_cloud_xyz32(Header(frame_id="l"), [(1, 2, 3), (4, 5, float("nan")), (7.5, 8, 9)])
        print(cloud.width, cloud.height, cloud.point_step, cloud.row_step, cloud.is_dense, cloud.data[:8])
        print(list(pc2.read_points(cloud, skip_nans=True)), list(pc2.read_points(cloud, ("x", "z"), uvs=[(2, 0)])))
        print(pc2.read_points_list(cloud)[0])
        fields = [PointField("x", 0, PointField.FLOAT32, 1), PointField("i", 8, PointField.UINT8, 2)]
        print(pc2.create_cloud(Header(), fields, [(1.0, 3, 4)]).data)
    """
    assert output(code, tmp_path).splitlines() == [
        "3 1 12 36 False b'\\x00\\x00\\x80?\\x00\\x00\\x00@'",
        "[(1.0, 2.0, 3.0), (7.5, 8.0, 9.0)] [(7.5, 9.0)]",
        "Point(x=1.0, y=2.0, z=3.0)",
        "b'\\x00\\x00\\x80?\\x00\\x00\\x00\\x00\\x03\\x04'",
    ]


def test_images_without_opencv(tmp_path: Path) -> None:
    """cv_bridge: what numpy alone can do, and the words of what makes no sense (as Debian's gave them)."""
    pytest.importorskip("numpy")
    code = """
        import numpy as np
        from cv_bridge import CvBridge, CvBridgeError
        bridge = CvBridge()
        m = bridge.cv2_to_imgmsg(np.arange(12, dtype=np.uint8).reshape(2, 2, 3), "bgr8")
        print(m.encoding, m.height, m.width, m.step, m.data)
        print(bridge.imgmsg_to_cv2(m).shape, bridge.imgmsg_to_cv2(m).flags.writeable)
        print(bridge.imgmsg_to_cv2(m, "rgb8")[0, 0].tolist())
        deep = bridge.cv2_to_imgmsg(np.array([[9364, 59454]], dtype=np.uint16), "mono16")
        print(bridge.imgmsg_to_cv2(deep, "mono8").tolist(), bridge.imgmsg_to_cv2(deep, "32FC1").dtype)
        plain = bridge.cv2_to_imgmsg(np.ones((2, 2)))
        for message, wanted in ((plain, "bgr8"), (m, "32FC1"), (m, "nonsense")):
            try:
                bridge.imgmsg_to_cv2(message, wanted)
            except CvBridgeError as e:
                print(e)
        print(bridge.encoding_to_dtype_with_channels("32FC2"), bridge.encoding_to_cvtype2("bgr8"))
    """
    assert output(code, tmp_path).splitlines() == [
        "bgr8 2 2 6 b'\\x00\\x01\\x02\\x03\\x04\\x05\\x06\\x07\\x08\\t\\n\\x0b'",
        "(2, 2, 3) False",
        "[2, 1, 0]",
        "[[36, 231]] float32",
        "[64FC1] is not a color format. but [bgr8] is. The conversion does not make sense",
        "[bgr8] is a color format but [32FC1] is not so they must have the same OpenCV type, CV_8UC3, CV16UC1 ....",
        "Unrecognized image encoding [nonsense]",
        "('float32', 2) 16",
    ]


def test_bags(tmp_path: Path) -> None:
    """rosbag.Bag writes what it reads, raw and not, and appends."""
    code = """
        import os, rosbag, rospy
        from std_msgs.msg import Int32, String
        path = os.path.join(os.environ["ROS_HOME"], "a.bag")
        with rosbag.Bag(path, "w", compression="bz2") as bag:
            for i in range(3):
                bag.write("/n", Int32(i), rospy.Time(10 + i))
            bag.write("/s", String("x"), rospy.Time(20))
            print(bag.get_message_count())
        with rosbag.Bag(path, "a") as bag:
            bag.write("/n", Int32(9), rospy.Time(30))
        with rosbag.Bag(path) as bag:
            print([(m.topic, m.message.data, m.timestamp.secs) for m in bag.read_messages("/n", rospy.Time(11))])
            info = bag.get_type_and_topic_info()
            print(info.topics["/n"].message_count, sorted(info.msg_types), bag.get_compression_info().compression)
            print([raw[0] for _, raw, _ in bag.read_messages(raw=True)], bag.get_start_time(), bag.get_end_time())
        try:
            rosbag.Bag(__file__)
        except rosbag.ROSBagException as e:
            print(e)
    """
    assert output(code, tmp_path).splitlines() == [
        "4",
        "[('/n', 1, 11), ('/n', 2, 12), ('/n', 9, 30)]",
        "4 ['std_msgs/Int32', 'std_msgs/String'] none",
        "['std_msgs/Int32', 'std_msgs/Int32', 'std_msgs/Int32', 'std_msgs/String', 'std_msgs/Int32'] 10.0 30.0",
        "This does not appear to be a bag file",
    ]


def test_old_transforms(tmp_path: Path) -> None:
    """tf: values as Debian's tf printed them, but for the last digit, which the processor and the C library decide."""
    pytest.importorskip("numpy")
    code = """
        import json
        import tf
        from tf.transformations import euler_from_quaternion, quaternion_from_euler
        q = quaternion_from_euler(0.1, 0.2, 0.3)
        turned = quaternion_from_euler(0, 0, 3.5).tolist()[3]
        print(json.dumps([*euler_from_quaternion(q), *euler_from_quaternion(q, "rxyx"), turned]))
        print(euler_from_quaternion([0, 0, 0, 1]), issubclass(tf.LookupException, tf.Exception))
    """
    numbers, rest = output(code, tmp_path).splitlines()
    assert json.loads(numbers) == pytest.approx(
        [0.1, 0.2, 0.3, 0.969566980219808, 0.3588726546765413, -0.899892860972392, -0.17824605564949209],
        rel=0.0,
        abs=1e-15,
    )
    assert rest == "(0.0, -0.0, 0.0) True"


def test_reconfiguring_this_node(tmp_path: Path) -> None:
    """dynamic_reconfigure's server and client in one node: limits, levels, conversions."""
    code = """
        import types
        import rospy
        from dynamic_reconfigure.client import Client
        from dynamic_reconfigure.server import Server
        def parameter(name, type_, level, default, low, high):
            return dict(name=name, type=type_, level=level, description="", default=default, min=low, max=high,
                        edit_method="")
        parameters = [parameter("speed", "double", 1, 0.5, 0.0, 2.0), parameter("on", "bool", 2, True, False, True)]
        kind = types.SimpleNamespace(
            config_description=dict(name="Default", type="", state=True, id=0, parent=0, groups=[], parameters=parameters),
            **{part: {one["name"]: one[part] for one in parameters} for part in ("min", "max", "level", "type")},
            defaults={one["name"]: one["default"] for one in parameters})
        rospy.init_node("tuned")
        calls = []
        def changed(config, level):
            calls.append((level, config.speed, config["on"]))
            return config
        server = Server(kind, changed)
        client = Client("/tuned", timeout=10)
        print(client.update_configuration({"speed": 7, "on": "false"}).speed, rospy.get_param("~speed"))
        print(calls)
    """
    with Master() as master:
        assert output(code, tmp_path, uri=master.uri).splitlines() == [
            "2.0 2.0",
            "[(-1, 0.5, True), (3, 2.0, False)]",
        ]


def test_what_cannot_be_served_says_why(tmp_path: Path) -> None:
    """The error names the module, the reason and another way; looking for it without importing finds nothing."""
    code = """
        import importlib, importlib.util
        import PyKDL
        for name in ("roslaunch", "smach_ros", "moveit_commander", "rviz", "rclpy", "foo_msgs", "turtlesim"):
            assert importlib.util.find_spec(name) is None, name
            for attempt in (lambda: __import__(name + ".msg"), lambda: importlib.import_module(name)):
                try:
                    attempt()
                except ModuleNotFoundError as error:
                    assert error.name == name and str(error).startswith("No module named %r: " % name), error
                    text = str(error)
            print(text.partition(": ")[2][:34])
        for code in ("from foo_msgs.msg import Thing", "import no_such", "from PyKDL import Chain"):
            try:
                exec(code)
            except ImportError as error:
                print(str(error)[:66])
        print(hasattr(PyKDL, "__wrapped__"), PyKDL.Vector(1, 2, 3).Norm() ** 2)
    """
    assert output(code, tmp_path).splitlines() == [
        "launch files and the processes the",
        "it is pure Python; put its folder ",
        "it is a front end to C++ code of a",
        "it is one of ROS's windows; use ma",
        "that is ROS 2; this layer speaks R",
        "it is not a package of this comput",
        "it is not a package of this comput",
        "No module named 'foo_msgs': it is not a package of this computer, ",
        "No module named 'no_such'",
        "PyKDL.Chain: without the real PyKDL there are only Vector, Rotatio",
        "False 14.0",
    ]


def test_feedback_that_overtakes_a_status_array_loses_no_goal(tmp_path: Path) -> None:
    """They come by two connections: an array from before the goal may be read after the goal's first feedback."""
    code = """
        import json
        import rospy
        from actionlib.action_client import CommState, CommStateMachine
        from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
        from move_base_msgs.msg import MoveBaseActionFeedback, MoveBaseActionGoal
        from std_msgs.msg import Header

        def array(stamp, *listed):
            return GoalStatusArray(header=Header(stamp=rospy.Time(stamp)), status_list=list(listed))

        def machine():
            machine = CommStateMachine(MoveBaseActionGoal(goal_id=GoalID(id="one")), None, None, None, None)
            feedback = MoveBaseActionFeedback(header=Header(stamp=rospy.Time(10)), status=active())
            machine.update_feedback(feedback)
            return machine

        def active():
            return GoalStatus(goal_id=GoalID(id="one"), status=GoalStatus.ACTIVE)

        states = []
        told = machine()
        for status in (array(9), array(10, active()), array(8)):
            told.update_status(status)
            states.append(told.latest_goal_status.status)
        restarted = machine()
        restarted.update_status(array(11))
        print(json.dumps([states, restarted.latest_goal_status.status, restarted.state == CommState.DONE]))
    """
    active, lost = 1, 9
    assert json.loads(output(code, tmp_path)) == [[active, active, lost], lost, True]


def test_a_result_lets_feedback_that_was_sent_before_it_pass(tmp_path: Path) -> None:
    """Only where somebody wants feedback: the result waits a moment, in which it is told."""
    code = """
        import rospy, rospy.rostime
        from actionlib import action_client
        from actionlib_msgs.msg import GoalID, GoalStatus
        from move_base_msgs.msg import MoveBaseAction, MoveBaseActionFeedback, MoveBaseActionResult, MoveBaseGoal

        rospy.rostime.set_rostime_initialized(True)
        rospy.get_param = lambda name, default: default
        client = action_client.ActionClient("/drive", MoveBaseAction)
        told = []
        for wanted in (lambda handle, feedback: told.append("feedback"), None):
            handle = client.manager.track_goal(MoveBaseGoal(), lambda handle: told.append(handle.get_comm_state()), wanted)
            status = GoalStatus(goal_id=GoalID(id=handle.comm_state_machine.goal_id), status=GoalStatus.ACTIVE)
            feedback = MoveBaseActionFeedback(status=status)
            waits = []
            # What comes meanwhile:
            action_client.time.sleep = lambda seconds: (waits.append(seconds), client._feedback_cb(feedback))
            ended = GoalStatus(goal_id=status.goal_id, status=GoalStatus.SUCCEEDED)
            client._result_cb(MoveBaseActionResult(status=ended))
            print("feedback" in told, told[-1] == action_client.CommState.DONE, len(waits))
            del told[:]
    """
    assert output(code, tmp_path).splitlines() == ["True True 1", "False True 0"]


def test_patterns_of_fields_that_are_wrong_are_told_and_give_none(tmp_path: Path) -> None:
    """As rostopic does: a slice gives a list, what is not there gives None and a line on stderr."""
    code = """
        import sys
        import rostopic
        from std_msgs.msg import UInt16MultiArray

        sys.stderr = sys.stdout
        message = UInt16MultiArray(data=[1, 2, 3])
        for pattern in ("/data[1:3]", "/data[-1]", "/data[9]", "/nothing", "/data[x]", "/data[", "/"):
            function = rostopic.msgevalgen(pattern)
            print(function and function(message))
    """
    assert output(code, tmp_path).splitlines() == [
        "[2, 3]",
        "3",
        "list index out of range: /data[9]",
        "None",
        "no field named nothing in /nothing",
        "None",
        "field 'data' has invalid slice argument 'x': non-integer array index step 'x'",
        "None",
        "missing closing ']' in slice spec 'data['",
        "None",
        "None",
    ]


def test_genmsg_refuses_brackets_that_do_not_close(tmp_path: Path) -> None:
    """Also the number that genmsg itself would cut short."""
    code = """
        from genmsg import InvalidMsgSpec
        from genmsg.msgs import MsgSpec, is_valid_msg_type, parse_type

        for wrong in ("a[", "string[", "a[3", "a[34", "a[]]", "a[[3]]", "a[x]"):
            for function in (parse_type, lambda type_: MsgSpec([type_], ["x"], [], "", "p/T")):
                try:
                    print(wrong, function(wrong))
                except (ValueError, InvalidMsgSpec):
                    pass
            assert not is_valid_msg_type(wrong)
        print(parse_type("a"), parse_type("a[]"), parse_type("a[34]"), is_valid_msg_type("a[34]"))
    """
    assert output(code, tmp_path) == "('a', False, None) ('a', True, None) ('a', True, 34) True\n"


@pytest.mark.promise(
    "A transform buffer takes 10,000 frames, 50,000 poses of each, and names of 1000 characters"
)
def test_frames_of_a_peer_are_bounded(tmp_path: Path) -> None:
    """BufferCore takes so many frames, so many poses of each, and no name that is longer than any; told of once."""
    code = """
        import tf2_py, rospy
        from geometry_msgs.msg import TransformStamped
        from rosproto.tf import tree
        tf2_py.MAX_SAMPLES = 5
        core = tf2_py.BufferCore()
        core._tree = tree.FrameTree(50)
        def put(parent, child, stamp=1.0):
            t = TransformStamped()
            t.header.frame_id, t.child_frame_id, t.header.stamp = parent, child, rospy.Time(stamp)
            t.transform.rotation.w = 1.0
            core.set_transform(t, "peer")
        for i in range(500):
            put("p%d" % i, "c%d" % (i % 50), 1.0 + i / 1000)
            put("map", "c%d" % i)
        put("map", "x" * 1001)
        put("x" * 1001, "c1")
        print(len(core._tree.edges), len(core._tree.names) <= 125, len(core._tree.edges["c1"]))
        print(core.can_transform_core("p499", "c49", rospy.Time(0))[0])
    """
    done = run(code, tmp_path)
    assert done.stdout.split() == ["50", "True", "5", "1"], done.stderr
    assert done.stderr.count("frames of 1000 characters at most") == 1


@pytest.mark.promise("the rospy layer keeps latched messages of connected publishers only")
def test_latched_messages_of_publishers_that_have_gone_are_forgotten(tmp_path: Path) -> None:
    """A peer that comes under another name each time leaves nothing; a late callback hears whoever is there."""
    code = """
        import rospy
        from std_msgs.msg import String
        rospy.init_node("ear")
        sub = rospy.Subscriber("/t", String, lambda m: None)
        while "/n4" not in sub.impl._latched:
            rospy.sleep(0.01)
        print(len(sub.impl._latched) <= 2)  # the one before may be about to go
        heard = []
        rospy.Subscriber("/t", String, lambda m: heard.append(m.data))
        print(heard[-1])
    """
    from concurrent.futures import ThreadPoolExecutor

    with Master() as master, ThreadPoolExecutor(1) as pool:
        ended = pool.submit(output, code, tmp_path, uri=master.uri)
        for i in range(5):
            with (
                rosproto.Node(f"/n{i}", master_uri=master.uri, rosout=False) as peer,
                peer.publisher("/t", "std_msgs/String", latch=True) as publisher,
            ):
                publisher.publish(data=f"{i}")
                publisher.wait_for_connection(20)
                if i == 4:
                    assert ended.result().split() == ["True", "4"]


def test_messages_from_before_a_jump_of_the_clock_are_not_grouped_with_later_ones(tmp_path: Path) -> None:
    """As in message_filters: an approximate synchronizer drops what it has, and the new message, at a jump back."""
    code = """
        from types import SimpleNamespace as Some
        import message_filters
        import rospy
        rospy.rostime.set_rostime_initialized(True)
        left, right = message_filters.SimpleFilter(), message_filters.SimpleFilter()
        both = message_filters.ApproximateTimeSynchronizer([left, right], 10, 0.1)
        both.registerCallback(lambda a, b: print(a.number, b.number))
        def send(side, number, clock):
            rospy.rostime._set_rostime(rospy.Time(clock))
            side.signalMessage(Some(number=number, header=Some(stamp=rospy.Time(5))))
        send(left, 1, 20)
        send(left, 2, 10)
        print([len(queue) for queue in both.queues])
        send(right, 3, 10)
        send(left, 4, 10)
    """
    assert output(code, tmp_path) == "[0, 0]\n4 3\n"


def test_all_stamps_that_are_complete_are_grouped(tmp_path: Path) -> None:
    """With reset, those that had to wait until the other topics' clocks had jumped, too."""
    code = """
        from types import SimpleNamespace as Some
        import message_filters
        import rospy
        rospy.rostime.set_rostime_initialized(True)
        left, right = message_filters.SimpleFilter(), message_filters.SimpleFilter()
        both = message_filters.TimeSynchronizer([left, right], 10, reset=True)
        both.registerCallback(lambda a, b: print(a.header.stamp.secs, b.header.stamp.secs))
        def send(side, stamp, clock):
            rospy.rostime._set_rostime(rospy.Time(clock))
            side.signalMessage(Some(header=Some(stamp=rospy.Time(stamp))))
        send(right, 0, 20)
        send(left, 2, 10)
        send(left, 1, 11)
        send(right, 2, 9)
        send(right, 1, 10)
        print("waits")
        send(left, 3, 12)
    """
    assert output(code, tmp_path) == "waits\n1 1\n2 2\n"


def test_threads_that_receive_at_once_see_no_jump_of_the_clock(tmp_path: Path) -> None:
    """tf2_ros.TransformListener read the time before its lock, and cleared the buffer by a false jump back."""
    code = """
        import sys
        import threading
        import rospy
        import tf2_ros
        rospy.init_node("many", disable_signals=True)
        cleared = []
        class Counted(tf2_ros.Buffer):
            def clear(self):
                cleared.append(1)
        listener = tf2_ros.TransformListener(Counted(debug=False))
        sys.setswitchinterval(1e-6)
        def receive():
            for _ in range(3000):
                listener.check_for_reset()
        threads = [threading.Thread(target=receive) for _ in range(6)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        print(len(cleared))
        rospy.signal_shutdown("done")
    """
    with Master() as master:
        assert output(code, tmp_path, uri=master.uri) == "0\n"
