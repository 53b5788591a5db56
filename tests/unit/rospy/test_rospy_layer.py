"""The layer for rospy programs, in processes of its own: it takes a process over, this one must stay free."""

from __future__ import annotations

import importlib.machinery
import os
import subprocess
import sys
import textwrap
import zipfile
import zipimport
from pathlib import Path

import pytest

from rosproto.master import Master

ROOT = Path(__file__).resolve().parents[3]
INSTALL = "import rosproto.rospy.install\n"
own_path = pytest.mark.skipif(
    bool(sys.flags.isolated), reason="an embeddable Python takes no folder of a program and no PYTHONPATH"
)


def run(
    code: str,
    tmp_path: Path,
    *,
    uri: str = "http://127.0.0.1:1/",
    options: list[str] | None = None,
    **env: str,
):
    """Run a program by `python -m rosproto.rospy`; its CompletedProcess."""
    program = tmp_path / "program.py"
    program.write_text(textwrap.dedent(code), "utf-8")
    environment = {
        **os.environ,
        "PYTHONPATH": str(ROOT),
        "ROS_MASTER_URI": uri,
        "ROS_IP": "127.0.0.1",
        "ROS_HOME": str(tmp_path),
        **env,
    }
    return subprocess.run(
        [sys.executable, "-m", "rosproto.rospy", *(options or []), str(program), "one", "--two", "_x:=3"],
        capture_output=True,
        text=True,
        timeout=60,
        env=environment,
    )


def output(code: str, tmp_path: Path, **options: object) -> str:
    """What it printed; it must end well."""
    done = run(code, tmp_path, **options)  # type: ignore[arg-type]
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_nobody_else_imports_it() -> None:
    """`import rosproto` and its node bring nothing of this layer, nor do they serve `import rospy`."""
    code = "import sys, rosproto; rosproto.Node; print([m for m in sys.modules if 'rospy' in m])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, timeout=60)
    assert done.stdout.strip() == "[]"


@own_path
@pytest.mark.parametrize(
    "word", ["program.py", "./program.py", "../here/program.py", "linked.py", "none.py", "wrong.py"]
)
def test_a_program_is_named_as_python_names_it(word: str, tmp_path: Path) -> None:
    """`__file__`, tracebacks and source lines after a chdir, and sys.argv[0] as typed: what `python WORD` gives."""
    here = tmp_path / "here"
    here.mkdir()
    code = """
        import inspect, os, sys, traceback
        import __main__

        def fail():
            raise ValueError("x")

        os.chdir(os.path.dirname(sys.executable))
        print(__file__, __main__.__file__, sys.argv[0], sys.path[0])
        print(os.path.abspath(__file__), os.path.dirname(__file__) + "/../lib", type(__loader__).__name__)
        print(inspect.getsource(fail), inspect.getfile(fail))
        try:
            fail()
        except ValueError:
            traceback.print_exc()
        fail()
    """
    (here / "program.py").write_text(textwrap.dedent(code), "utf-8")
    (here / "wrong.py").write_text("x = (\n", "utf-8")
    if word == "linked.py":
        try:
            (here / "linked.py").symlink_to(here / "program.py")
        except OSError:
            pytest.skip("this user may make no links")
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONSAFEPATH": ""}
    python, ours = (
        subprocess.run(
            [sys.executable, *way, word],
            cwd=here,
            env=environment,
            capture_output=True,
            text=True,
            timeout=60,
        )
        for way in ([], ["-m", "rosproto.rospy"])
    )
    assert (ours.returncode, ours.stdout, ours.stderr) == (python.returncode, python.stdout, python.stderr)
    assert ours.returncode == {"none.py": 2}.get(word, 1)
    assert str(here) in ours.stdout + ours.stderr


@own_path
def test_argv_main_and_path_are_as_python_sets_them(tmp_path: Path) -> None:
    """Arguments untouched, `__main__`, the program's folder first on the path."""
    code = """
        import sys, os, __main__
        print(sys.argv[1:], __name__, os.path.basename(__file__), __main__.__dict__ is globals())
        print(sys.path[0] == os.path.dirname(os.path.realpath(__file__)), sys.argv[0] == __file__)
    """
    assert output(code, tmp_path).split("\n")[:2] == [
        "['one', '--two', '_x:=3'] __main__ program.py True",
        "True True",
    ]


@pytest.mark.parametrize(
    ("code", "status", "error"),
    [
        ("raise ValueError('mine')", 1, "ValueError: mine"),
        ("import sys; sys.exit(5)", 5, ""),
        ("import sys; sys.exit('text')", 1, "text"),
        ("this is no Python", 1, "SyntaxError: invalid syntax"),
        ("import no_such_module", 1, "ModuleNotFoundError: No module named 'no_such_module'"),
        ("import std_msgs.nothing", 1, "ModuleNotFoundError: No module named 'std_msgs.nothing'"),
        (
            "from std_msgs.msg import Nothing",
            1,
            "ImportError: cannot import name 'Nothing' from 'std_msgs.msg'",
        ),
    ],
)
def test_exit_codes_and_tracebacks(code: str, status: int, error: str, tmp_path: Path) -> None:
    """The program's code, its own traceback, nothing of ours in it."""
    done = run(code, tmp_path)
    assert done.returncode == status
    assert error in done.stderr
    assert "launch.py" not in done.stderr


@pytest.mark.skipif(sys.version_info < (3, 11), reason="-P is new in Python 3.11")
def test_a_safe_path_is_left_as_it_is(tmp_path: Path) -> None:
    """Under -P, and in an embeddable Python, the first entry is Python's own: nothing takes its place."""
    program = tmp_path / "program.py"
    program.write_text("import sys, pkgutil; print(sys.path)\n")
    shown = [
        subprocess.run(
            [sys.executable, "-P", *words], capture_output=True, text=True, timeout=60, check=True,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
        ).stdout
        for words in ([str(program)], ["-m", "rosproto.rospy", str(program)])
    ]  # fmt: skip
    assert shown[0] == shown[1] != ""


def test_every_module_imports_and_keeps_its_all(tmp_path: Path) -> None:
    """All of `modules/`, submodules too, under their ROS names."""
    code = """
        import importlib, os, pkgutil
        from rosproto.rospy.finder import MODULES
        for info in pkgutil.walk_packages([MODULES]):
            if info.name in ("cv_bridge", "rospkg"):
                continue
            module = importlib.import_module(info.name)
            assert module.__file__.startswith(MODULES) or info.name == "rospkg", module
            missing = [n for n in getattr(module, "__all__", ()) if not hasattr(module, n)]
            assert not missing, (info.name, missing)
        print("fine")
    """
    assert output(code, tmp_path) == "fine\n"


def test_one_line_makes_a_program_run_by_python_itself(tmp_path: Path) -> None:
    """`import rosproto.rospy.install`."""
    program = tmp_path / "p.py"
    program.write_text(
        INSTALL + "import rospy, woosh_msgs.msg as m\nprint(rospy.get_name(), m.Battery().__class__)\n"
    )
    done = subprocess.run(
        [sys.executable, str(program)],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        timeout=60,
    )
    assert done.stdout == "/unnamed <class 'woosh_msgs.msg._Battery.Battery'>\n", done.stderr


@own_path
def test_the_users_own_generated_package_wins_over_ours(tmp_path: Path) -> None:
    """A folder with generated code is left to Python; one with rospy in it is a ROS installation, and is not."""
    for root, marker in (("workspace", None), ("ros", "rospy")):
        package = tmp_path / root / "woosh_msgs" / "msg"
        package.mkdir(parents=True)
        (package.parent / "__init__.py").touch()
        (package / "__init__.py").write_text(f"origin = {root!r}\n")
        if marker:
            (tmp_path / root / marker).mkdir()
            (tmp_path / root / marker / "__init__.py").write_text("raise ImportError('the real one')\n")
    code = "import woosh_msgs.msg as m, rospy; print(getattr(m, 'origin', 'ours'))"
    path = os.pathsep.join([str(ROOT), str(tmp_path / "workspace")])
    assert output(code, tmp_path, PYTHONPATH=path) == "workspace\n"
    path = os.pathsep.join([str(ROOT), str(tmp_path / "ros")])
    assert output(code, tmp_path, PYTHONPATH=path) == "ours\n"


def test_definitions_of_a_folder(tmp_path: Path) -> None:
    """`--msg-path` gives packages of .msg files, also ones that use ours."""
    (tmp_path / "defs" / "lab_msgs" / "msg").mkdir(parents=True)
    (tmp_path / "defs" / "lab_msgs" / "msg" / "Probe.msg").write_text("Header header\nfloat64[] values\n")
    code = """
        import pickle
        from lab_msgs.msg import Probe
        probe = Probe(values=[1.0])
        print(probe.header.seq, Probe._type, pickle.loads(pickle.dumps(probe)) == probe, Probe.__module__)
    """
    done = output(code, tmp_path, options=["--msg-path", str(tmp_path / "defs")])
    assert done == "0 lab_msgs/Probe True lab_msgs.msg._Probe\n"


def test_processes_that_are_started_anew_have_the_layer_too(tmp_path: Path) -> None:
    """multiprocessing with "spawn", as on Windows and macOS; messages travel by pickle."""
    code = """
        import multiprocessing
        import rospy
        from geometry_msgs.msg import Point

        def work(queue):
            queue.put(Point(1, 2, 3))

        if __name__ == "__main__":
            context = multiprocessing.get_context("spawn")
            queue = context.Queue()
            child = context.Process(target=work, args=(queue,))
            child.start()
            print(queue.get(timeout=30) == Point(1, 2, 3))
            child.join(30)
            print(child.exitcode)
    """
    assert output(code, tmp_path) == "True\n0\n"


def test_a_loader_of_many_modules_is_left_alone(tmp_path: Path) -> None:
    """A library in a zip, as in an embeddable Python for Windows, has one loader for all modules."""
    from rosproto.rospy.finder import RosFinder

    archive = tmp_path / "library.zip"
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr("one.py", "")
        file.writestr("other.py", "")
    one = RosFinder._patched("one", [str(archive)])
    other = importlib.machinery.PathFinder.find_spec("other", [str(archive)])
    assert one is not None
    assert other is not None
    assert other.loader.is_package("other") is one.loader.is_package("one") is False
    assert other.loader.exec_module.__func__ is zipimport.zipimporter.exec_module


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


def test_killed_by_a_tool(tmp_path: Path) -> None:
    """`rosnode kill`: hooks run, spin returns, the request is printed."""
    code = """
        import threading
        import rospy, rosnode
        hooked = threading.Event()
        rospy.init_node("victim")
        rospy.on_shutdown(lambda: (print("hook"), hooked.set()))
        print(rosnode.get_node_names(), rosnode.rosnode_ping("/victim", 1))
        threading.Thread(target=rosnode.kill_nodes, args=[["/victim"]]).start()
        rospy.spin()
        hooked.wait(20)  # spin looks twice a second, and may do so amid the shutdown
        print("over")
    """
    with Master() as master:
        lines = output(code, tmp_path, uri=master.uri).splitlines()
    assert lines == ["['/victim'] True", "shutdown request: user request", "hook", "over"]


def test_small_modules_on_a_graph(tmp_path: Path) -> None:
    """rostopic, rosservice, rosparam, rosgraph as programs import them."""
    code = """
        import rospy, rosgraph, roslib, rosparam, rosservice, rostopic
        from std_msgs.msg import String
        from std_srvs.srv import Trigger, TriggerResponse
        roslib.load_manifest("anything")
        rospy.init_node("small")
        pub = rospy.Publisher("/chat", String, queue_size=1)
        service = rospy.Service("/pull", Trigger, lambda r: TriggerResponse(True, "pulled"))
        print(rostopic.get_topic_type("/chat")[0], rostopic.get_topic_class("/chat")[0] is String)
        print(rosservice.get_service_type("/pull"), rosservice.call_service("/pull", [])[1].message)
        rosparam.set_param("/a", "[1, 2]")
        print(rosparam.get_param("/a"), rosparam.list_params("/"), rosgraph.is_master_online())
        print(rosgraph.Master("/me").lookupNode("/small") == rospy.get_node_uri())
    """
    with Master() as master:
        assert output(code, tmp_path, uri=master.uri).splitlines() == [
            "std_msgs/String True",
            "std_srvs/Trigger pulled",
            "[1, 2] ['/a', '/rosdistro', '/rosversion', '/run_id', '/small/x'] True",
            "True",
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


def test_chassis_option_sets_the_environment(tmp_path: Path) -> None:
    """A host, a host and port, or a URI; our own address is the one that routes there."""
    code = "import os; print(os.environ['ROS_MASTER_URI'], os.environ['ROS_IP'])"
    for given, uri in (
        ("127.0.0.1", "http://127.0.0.1:11311/"),
        ("127.0.0.1:99", "http://127.0.0.1:99/"),
        ("http://127.0.0.1:98", "http://127.0.0.1:98"),
    ):
        assert output(code, tmp_path, options=["--chassis", given], ROS_IP="8.8.8.8") == f"{uri} 127.0.0.1\n"
    assert (
        output("import os; print(os.environ['ROS_MASTER_URI'])", tmp_path, options=["--master", "http://x:1"])
        == "http://x:1\n"
    )


def test_library_log_on_request(tmp_path: Path) -> None:
    """`-v` shows the library's log and leaves the program's logging alone."""
    code = "import logging, rospy; print(logging.root.handlers); rospy.init_node('n')"
    with Master() as master:
        done = run(code, tmp_path, uri=master.uri, options=["-vv"])
    assert done.stdout == "[]\n"
    assert done.returncode == 0


def test_a_program_that_is_not_there(tmp_path: Path) -> None:
    """Python's words and exit code."""
    done = subprocess.run(
        [sys.executable, "-m", "rosproto", "run", "no_such.py"],
        capture_output=True,
        text=True,
        cwd=ROOT,
        timeout=60,
    )
    assert done.returncode == 2
    assert f"can't open file {str(ROOT / 'no_such.py')!r}: [Errno 2]" in done.stderr


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
