"""ROS packages in programs of the layer: tf, cv_bridge, dynamic_reconfigure, message packages and others."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosproto.master import Master
from tests.support.rospy_program import output


def test_euler_angles_in_all_orders(tmp_path: Path) -> None:
    """Matrix, quaternion and angles agree for each of the 24 orders; known values for the usual one."""
    code = """
        import itertools, math, numpy, tf
        from tf.transformations import *
        q = quaternion_from_euler(0.1, -0.2, 0.3)
        # scipy: Rotation.from_euler("xyz", (0.1, -0.2, 0.3)).as_quat()
        assert numpy.allclose(q, (0.06407135, -0.09115755, 0.15343930, 0.98184933), atol=1e-7), q
        assert numpy.allclose(euler_from_quaternion(q), (0.1, -0.2, 0.3))
        assert isinstance(euler_from_quaternion(q), tuple) and isinstance(q, numpy.ndarray)
        orders = [a + b + c + d for a in "sr" for b, c, d in itertools.product("xyz", repeat=3) if b != c != d]
        assert len(orders) == 24
        for axes in orders:
            angles = (0.4, 0.5, -0.6)
            matrix = euler_matrix(*angles, axes)
            assert numpy.allclose(quaternion_matrix(quaternion_from_euler(*angles, axes)), matrix), axes
            back = euler_from_matrix(matrix, axes)
            assert numpy.allclose(euler_matrix(*back, axes), matrix), (axes, back)
            assert axes[1] == axes[3] or numpy.allclose(back, angles), (axes, back)
        z, x = rotation_matrix(math.pi / 2, (0, 0, 1)), rotation_matrix(math.pi / 2, (1, 0, 0))
        assert numpy.allclose(euler_matrix(math.pi / 2, 0, math.pi / 2), z.dot(x))
        assert numpy.allclose(quaternion_multiply(q, quaternion_inverse(q)), (0, 0, 0, 1))
        assert numpy.allclose(quaternion_from_matrix(quaternion_matrix(q)), q)
        assert numpy.allclose(quaternion_slerp((0, 0, 0, 1), quaternion_about_axis(1.0, (0, 0, 1)), 0.5),
                              quaternion_about_axis(0.5, (0, 0, 1)))
        assert numpy.allclose(inverse_matrix(translation_matrix((1, 2, 3))), translation_matrix((-1, -2, -3)))
        try:
            quaternion_from_euler(1, 2, 3, "sxxy")
        except KeyError:
            print("fine")
    """
    assert output(code, tmp_path) == "fine\n"


def test_old_tf_on_a_graph(tmp_path: Path) -> None:
    """tf.TransformBroadcaster and tf.TransformListener, their tuples and exceptions."""
    code = """
        import rospy, tf
        from geometry_msgs.msg import PointStamped
        rospy.init_node("old_tf")
        listener, broadcaster = tf.TransformListener(), tf.TransformBroadcaster()
        quarter = tf.transformations.quaternion_from_euler(0, 0, 1.5707963267948966)
        timer = rospy.Timer(rospy.Duration(0.05),
            lambda e: broadcaster.sendTransform((1, 2, 0), quarter, rospy.Time.now(), "base", "map"))
        listener.waitForTransform("/map", "/base", rospy.Time(0), rospy.Duration(10))
        trans, rot = listener.lookupTransform("map", "base", rospy.Time(0))
        print(trans, [round(v, 4) for v in rot], listener.frameExists("base"))
        point = PointStamped()
        point.header.frame_id, point.point.x = "base", 1.0
        moved = listener.transformPoint("map", point)
        print(moved.header.frame_id, round(moved.point.x, 6), round(moved.point.y, 6))
        for call in (lambda: listener.lookupTransform("map", "nowhere", rospy.Time(0)),
                     lambda: listener.waitForTransform("map", "nowhere", rospy.Time(0), rospy.Duration(0.1))):
            try:
                call()
            except (tf.LookupException, tf.ConnectivityException, tf.ExtrapolationException) as e:
                print(type(e).__name__)
            except tf.Exception as e:
                print("Exception", "nowhere" in str(e))
    """
    with Master() as master:
        assert output(code, tmp_path, uri=master.uri).splitlines() == [
            "[1.0, 2.0, 0.0] [0.0, 0.0, 0.7071, 0.7071] True",
            "map 1.0 3.0",
            "LookupException",
            "Exception True",
        ]


def test_images_without_opencv(tmp_path: Path) -> None:
    """cv_bridge needs OpenCV only to convert between colours and grey."""
    code = """
        import numpy
        from cv_bridge import CvBridge, CvBridgeError
        bridge = CvBridge()
        image = numpy.arange(24, dtype=numpy.uint8).reshape(2, 4, 3)
        message = bridge.cv2_to_imgmsg(image, "bgr8")
        assert (message.height, message.width, message.step, message.encoding) == (2, 4, 12, "bgr8")
        assert (bridge.imgmsg_to_cv2(message) == image).all()
        assert (bridge.imgmsg_to_cv2(message, "rgb8") == image[:, :, ::-1]).all()
        depth = numpy.ones((2, 3), dtype=numpy.float32)
        assert bridge.cv2_to_imgmsg(depth).encoding == "32FC1"
        try:
            bridge.cv2_to_imgmsg(depth, "bgr8")
        except CvBridgeError as error:
            print("fine")
    """
    assert output(code, tmp_path) == "fine\n"


def test_small_modules_on_a_graph(tmp_path: Path) -> None:
    """rostopic, rosservice, rosparam, rosgraph as programs import them."""
    code = """
        import rospy, rosgraph, roslib, rosparam, rosservice, rostopic
        from std_msgs.msg import String
        from std_srvs.srv import Trigger, TriggerResponse
        roslib.load_manifest("std_msgs")
        rospy.init_node("small")
        pub = rospy.Publisher("/chat", String, queue_size=1)
        service = rospy.Service("/pull", Trigger, lambda r: TriggerResponse(True, "pulled"))
        print(rostopic.get_topic_type("/chat")[0], rostopic.get_topic_class("/chat")[0] is String)
        print(rosservice.get_service_type("/pull"), rosservice.call_service("/pull", [])[1].message)
        rosparam.upload_params("/deep", {"a": {"b": 1, "c": 2}})
        rosparam.upload_params("/deep", {"a": {"b": 5}, "/global": 7})
        print(rosparam.get_param("/deep"), rosparam.get_param("/global"))
        rosparam.delete_param("/deep")
        rosparam.delete_param("/global")
        print(rosparam.load_str("_ns: in\\nx: 1\\n---\\n_ns: /out\\ny: 2", "", "/base"))
        rosparam.set_param("/a", "[1, 2]")
        print(rosparam.get_param("/a"), rosparam.list_params("/"), rosgraph.is_master_online())
        print(rosgraph.Master("/me").lookupNode("/small") == rospy.get_node_uri())
    """
    with Master() as master:
        assert output(code, tmp_path, uri=master.uri).splitlines() == [
            "std_msgs/String True",
            "std_srvs/Trigger pulled",
            "{'a': {'b': 5, 'c': 2}} 7",
            "[({'x': 1}, '/base/in'), ({'y': 2}, '/out')]",
            "[1, 2] ['/a', '/rosdistro', '/rosversion', '/run_id', '/small/x'] True",
            "True",
        ]


def test_angles_of_parameter_files(tmp_path: Path) -> None:
    """deg(), rad() and the tags; what is none is rosparam's own error."""
    pytest.importorskip("yaml", reason="PyYAML is not installed (extra [cli])")
    code = """
        import rosparam
        print(rosparam.load_str("[deg(90), rad(pi/2), !degrees 180, !radians 2*pi]", "", "/")[0][0])
        for text in ("deg(x)", "!radians x", "deg(1if 1 else 2)"):
            try:
                rosparam.load_str(text, "")
            except rosparam.RosParamException as error:
                print(error)
    """
    assert output(code, tmp_path).splitlines() == [
        "[1.5707963267948966, 1.5707963267948966, 3.141592653589793, 6.283185307179586]",
        "invalid degree value: deg(x)",
        "invalid radian expression: x",
        "invalid degree value: deg(1if 1 else 2)",
    ]


def test_reconfigure_a_node(tmp_path: Path) -> None:
    """dynamic_reconfigure.client against a node that plays the server."""
    code = """
        import rospy
        from dynamic_reconfigure.client import Client
        from dynamic_reconfigure.encoding import encode_config
        from dynamic_reconfigure.msg import Config, ConfigDescription, Group, ParamDescription
        from dynamic_reconfigure.srv import Reconfigure, ReconfigureResponse
        rospy.init_node("reconfigured")
        description = ConfigDescription(groups=[Group(parameters=[
            ParamDescription(name="speed", type="double"), ParamDescription(name="on", type="bool")])])
        described = rospy.Publisher("/it/parameter_descriptions", ConfigDescription, latch=True, queue_size=1)
        updates = rospy.Publisher("/it/parameter_updates", Config, latch=True, queue_size=1)
        described.publish(description)
        updates.publish(encode_config({"speed": 1.0, "on": False}))
        rospy.Service("/it/set_parameters", Reconfigure, lambda r: ReconfigureResponse(r.config))
        client = Client("/it", timeout=5)
        print(client.get_configuration(5), client.update_configuration({"speed": 2, "on": "true"}))
        try:
            client.update_configuration({"nope": 1})
        except Exception as e:
            print(type(e).__name__)
    """
    with Master() as master:
        assert output(code, tmp_path, uri=master.uri).splitlines() == [
            "{'on': False, 'speed': 1.0} {'on': True, 'speed': 2.0}",
            "DynamicReconfigureParameterException",
        ]


def test_message_packages_have_a_file_and_a_folder(tmp_path: Path) -> None:
    """`__file__` beside the definitions, bundled and of `--msg-path`; RosPack finds the folder that holds them."""
    own = tmp_path / "definitions" / "my_msgs" / "msg"
    own.mkdir(parents=True)
    (own / "Reading.msg").write_text("int32 value\n", "utf-8")
    code = """
        import os
        import my_msgs.msg, rospkg, roslib.packages, std_srvs.srv
        import std_msgs.msg._String

        for module in (std_msgs, std_msgs.msg, std_msgs.msg._String, std_srvs.srv, my_msgs.msg):
            print("/".join(module.__file__.replace(os.sep, "/").split("/")[-3:]), os.path.isabs(module.__file__))
        for package in ("std_msgs", "my_msgs"):
            folder = rospkg.RosPack().get_path(package)
            print(os.path.basename(folder), [n for n in sorted(os.listdir(folder + "/msg")) if n.endswith(".msg")][-1])
            print(folder == os.path.dirname(__import__(package).__file__) == roslib.packages.get_pkg_dir(package))
        try:
            rospkg.RosPack().get_path("no_such_package")
        except rospkg.ResourceNotFound as error:
            print(error)
    """
    options = ["--msg-path", str(tmp_path / "definitions")]
    assert output(code, tmp_path, options=options).splitlines() == [
        "msgdefs/std_msgs/__init__.py True",
        "std_msgs/msg/__init__.py True",
        "std_msgs/msg/_String.py True",
        "std_srvs/srv/__init__.py True",
        "my_msgs/msg/__init__.py True",
        "std_msgs UInt8MultiArray.msg",
        "True",
        "my_msgs Reading.msg",
        "True",
        "no_such_package",
    ]


def test_a_class_read_from_a_bag_is_named_as_by_rosbag(tmp_path: Path) -> None:
    """By package and type; it is none of the classes that the program imports."""
    code = """
        import os
        import genpy, rosbag
        from sensor_msgs.msg import LaserScan

        path = os.path.join(os.environ["ROS_HOME"], "named.bag")
        with rosbag.Bag(path, "w") as bag:
            bag.write("/scan", LaserScan(ranges=[1.0]), genpy.Time(1))
        with rosbag.Bag(path) as bag:
            for _, message, _ in bag:
                print(type(message).__name__, type(message.header).__name__, LaserScan.__name__)
                print(isinstance(message, genpy.Message), isinstance(message, LaserScan), message.ranges)
            print([raw[4].__name__ for _, raw, _ in bag.read_messages(raw=True)])
    """
    assert output(code, tmp_path).splitlines() == [
        "_sensor_msgs__LaserScan _std_msgs__Header LaserScan",
        "True False (1.0,)",
        "['_sensor_msgs__LaserScan']",
    ]
