"""The layer for rospy programs, in processes of its own: it takes a process over, this one must stay free."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap
from multiprocessing import get_all_start_methods
from pathlib import Path

import pytest

from rosproto.master import Master
from tests.support.rospy_program import output, run

ROOT = Path(__file__).resolve().parents[3]
INSTALL = "import rosproto.rospy.install\n"
own_path = pytest.mark.skipif(
    bool(sys.flags.isolated), reason="an embeddable Python takes no folder of a program and no PYTHONPATH"
)


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


@pytest.mark.parametrize("method", [each for each in get_all_start_methods() if each != "fork"])
def test_processes_that_are_started_anew_have_the_layer_too(method: str, tmp_path: Path) -> None:
    """multiprocessing with "spawn" (Windows, macOS) and "forkserver" (Linux since 3.14); messages travel by pickle."""
    code = """
        import multiprocessing
        import rospy
        from geometry_msgs.msg import Point

        def work(queue):
            queue.put(Point(1, 2, 3))

        if __name__ == "__main__":
            context = multiprocessing.get_context("METHOD")
            queue = context.Queue()
            child = context.Process(target=work, args=(queue,))
            child.start()
            print(queue.get(timeout=30) == Point(1, 2, 3))
            child.join(30)
            print(child.exitcode)
    """
    assert output(code.replace("METHOD", method), tmp_path) == "True\n0\n"


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


def test_the_variables_of_a_ros_installation_are_set(tmp_path: Path) -> None:
    """Programs read them; one that the user has set stays."""
    names = ["ROS_VERSION", "ROS_DISTRO", "ROS_PYTHON_VERSION"]
    code = (
        f"import os; print(*map(os.environ.get, {names}), os.path.isdir(os.environ['ROS_ROOT'] + '/rospy'))"
    )
    assert output(code, tmp_path, ROS_DISTRO="mine") == "1 mine 3 True\n"


@pytest.mark.parametrize("options", [[], ["--msg-path", "/nowhere/at/all"]])
def test_a_folder_of_definitions_that_is_not_there_is_said_in_a_sentence(
    options: list[str], tmp_path: Path
) -> None:
    """And which setting gave it."""
    done = run("print(1)", tmp_path, options=options, ROSPROTO_MSG_PATH="/nowhere/at/all")
    assert (done.returncode, done.stdout) == (1, "")
    assert "is not a folder" in done.stderr
    assert "--msg-path or by the variable ROSPROTO_MSG_PATH" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_script_of_a_ros_installation_names_our_command(tmp_path: Path) -> None:
    """/usr/bin/rostopic ended in an AttributeError for a part of rostopic that is not here."""
    done = subprocess.run(
        [sys.executable, "-m", "rosproto.rospy", str(tmp_path / "rostopic"), "list"],
        capture_output=True,
        text=True,
        timeout=60,
        cwd=ROOT,
    )
    assert done.returncode == 2
    assert done.stderr == "rostopic is a command of a ROS installation: use `rosproto topic`\n"


def test_a_master_named_by_its_host_has_port_11311(tmp_path: Path) -> None:
    """As with --chassis, and in the other commands."""
    code = "import os; print(os.environ['ROS_MASTER_URI'])"
    assert output(code, tmp_path, options=["--master", "127.0.0.1"]) == "http://127.0.0.1:11311/\n"


def test_handle_of_a_service_says_what_there_is_in_its_place(tmp_path: Path) -> None:
    """rospy's own connection calls it; there is none here."""
    code = """
        import rospy
        from std_srvs.srv import Empty

        rospy.init_node("n")
        service = rospy.Service("/s", Empty, lambda request: {})
        try:
            service.handle(None, {})
        except NotImplementedError as error:
            print(error)
    """
    with Master() as master:
        told = output(code, tmp_path, uri=master.uri)
    assert told.startswith(
        "rospy.Service.handle is a part of rospy's own connections, which are rosproto's here: use "
    )
