"""More programs written for rospy, each run by real rospy and by `rosproto run` at the same time, and compared.

Both runs of a program have a master of their own, so that they can go side by side.
"""

from __future__ import annotations

import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from tests.interop.rospy_peers import answers
from tests.interop.test_rospy_programs import slow
from tests.support import ros
from tests.support.rospy_pair import Outcome, normalised, run_program

HERE = Path(__file__).resolve().parent
TRANSFORMATIONS_NEED = "Debian's python3-tf is not installed"


def side_by_side(
    program: str | Path, *arguments: str, packages: list[Path], **options: Any
) -> tuple[Outcome, Outcome]:
    """What real rospy does, and what we do."""
    with ThreadPoolExecutor(2) as pool:
        theirs = pool.submit(run_program, program, *arguments, real=True, packages=packages, **options)
        ours = pool.submit(run_program, program, *arguments, real=False, **options)
        return theirs.result(), ours.result()


CASES: dict[str, dict[str, Any]] = {
    "service_handlers.py": {},
    "service_headers.py": {},
    "service_ends_itself.py": {},
    "params_more.py": {
        "arguments": [
            *["_port:=/dev/ttyUSB0", "_baud:=115200", "_flag:=true", "_off:=False", "_neg:=-1.5"],
            *[
                "_list:=[1,2,3]",
                "_dict:={a: 1, b: two}",
                "_empty:=",
                '_str:="5"',
                "_exp:=1e3",
                "_spaces:=a b",
            ],
        ],
        "env": {"ROS_NAMESPACE": "params_ns"},
        "master_params": {
            "/robot": {"name": "w", "size": [1, 2.5, "x", True], "deep": {"a": {"b": 1}}},
            "/speed": 0.5,
            "/params_ns/local": 3,
        },
    },
    "logs_more.py": {},
    "log_format.py": {
        "env": {"ROSCONSOLE_FORMAT": "[${severity}] [${logger}] [${node}] [${function}] ${line}: ${message}"}
    },
    "callback_errors.py": {},
    "in_one_process.py": {"arguments": ["messages.py", "messages_more.py", "definitions.py", "times.py"]},
    "wrong_values_more.py": {},
    "topic_arguments.py": {},
    "before_init.py": {},
    "tool_functions.py": {},
    "names_more.py": {
        "arguments": [
            *["__name:=other", "__ns:=/my/ns", "chatter:=/abs/chat", "foo:=bar", "~priv:=moved"],
            *["_p:=5", "plain", "--opt=1", "a:=b:=c"],
        ]
    },
    "shutdown_order.py": {},
    "action_goals.py": {},
    "filters.py": {},
    "topic_headers.py": {"arguments": ["__hostname:=localhost"]},
    "statistics_topic.py": {"master_params": {"/enable_statistics": True}},
    "graph_api.py": {},
    "bags.py": {},
    "topic_life.py": {},
    "given_up.py": {},
    "threads.py": {},
    "logger_levels.py": {},
    "action_callbacks.py": {},
    "action_states.py": {},
    "graph_tools.py": {},
    "unit_tests.py": {},
    "walked_values.py": {},
    "bag_private.py": {},
    "bag_told.py": {},
    "bag_repair.py": {},
    "fields.py": {},
    "inner_names.py": {},
}


@pytest.mark.parametrize("program", CASES)
def test_a_program_does_what_it_does_with_rospy(program: str, genpy_packages: Path) -> None:
    """Exit code and both streams."""
    options = dict(CASES[program])
    arguments = options.pop("arguments", [])
    theirs, ours = side_by_side(program, *arguments, packages=[genpy_packages], **options)
    assert ours.compared() == theirs.compared()
    assert ours.out or ours.err, "a program that says nothing shows nothing"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
@pytest.mark.parametrize("where", ["sleep", "rate", "spin", "wfm", "wfs", "loop", "pysleep", "input", "call"])
def test_a_signal_anywhere(where: str, number: int, genpy_packages: Path) -> None:
    """Ends sleeping, waiting, spinning and calling as with rospy."""
    if number != signal.SIGINT and where not in ("sleep", "spin", "call"):
        pytest.skip("the handler is the same")
    theirs, ours = side_by_side(
        "ctrl_c_anywhere.py",
        where,
        packages=[genpy_packages],
        peer=answers({"/slow": ("std_srvs/Trigger", slow)}),
        interrupt=number,
    )
    assert ours.compared()[:3] == theirs.compared()[:3]


def chassis(packages: Path) -> Any:
    """A peer: the rospy chassis in a process of its own; notes what it received, sorted by kind.

    Topics have a thread each: how what came by one lies to what came by another is chance.
    """

    @contextmanager
    def peer(uri: str, log: list[Any]) -> Any:
        script = [ros.PYTHON, str(HERE / "rospy_chassis.py")]
        with ros.RosProcess(script, ros.environment(uri, packages=packages)) as process:
            process.wait_for("^up$")
            yield
            process.stop()
            lines = [line for line in normalised(process.output) if line.startswith("> ")]
            log.extend(sorted(lines, key=lambda line: line.split()[1]))

    return peer


def real_tf() -> bool:
    """True when Debian's Python has tf (and numpy)."""
    done = subprocess.run([ros.PYTHON, "-c", "import tf.transformations"], capture_output=True, timeout=60)
    return done.returncode == 0


def test_a_chassis_receives_the_same(genpy_packages: Path, tmp_path: Path) -> None:
    """A task, navigation, steps, a pose, velocities: what a rospy chassis gets, and what the program says."""
    packages = [genpy_packages]
    if not real_tf():  # real rospy borrows our transformations then; what is compared is rospy
        (tmp_path / "tf").mkdir()
        (tmp_path / "tf" / "__init__.py").write_text("from . import transformations\n")
        (tmp_path / "tf" / "transformations.py").write_text(BORROWED)
        packages.insert(0, tmp_path)
    theirs, ours = side_by_side(
        "chassis_tour.py", "A1", "_speed:=0.4", packages=packages, peer=chassis(genpy_packages)
    )
    assert ours.compared() == theirs.compared()
    assert ours.code == 4
    assert len(ours.noted) >= 13


BORROWED = """
import math
def quaternion_from_euler(roll, pitch, yaw):
    assert roll == pitch == 0
    return 0.0, 0.0, math.sin(yaw / 2.0), math.cos(yaw / 2.0)
def euler_from_quaternion(q):
    s = math.sqrt(2.0 / sum(part * part for part in q))
    x, y, z, w = (part * s for part in q)
    return 0.0, -0.0, math.atan2(x * y + z * w, 1.0 - y * y - z * z)
"""


def test_transforms_agree_with_tf2_to_the_last_digit(genpy_packages: Path) -> None:
    """Random trees and lookups, by tf2's C++ and by ours in one process: values, errors, texts, warnings."""
    ros.require_ros("tf2_py")
    core = Path(sys.modules["rosproto"].__file__ or "").parent / "rospy" / "modules" / "tf2_py"
    done = subprocess.run(
        [ros.PYTHON, str(HERE / "tf2_oracle.py"), str(core), "60"],
        env=ros.environment("http://127.0.0.1:1/", packages=genpy_packages),
        capture_output=True,
        text=True,
        timeout=100,
    )
    assert done.returncode == 0, done.stdout + done.stderr[-2000:]
    assert "all agree" in done.stdout


@pytest.mark.parametrize("kind", ["conf", "none"])
def test_log_configuration_file(kind: str, genpy_packages: Path, tmp_path: Path) -> None:
    """ROS_PYTHON_LOG_CONFIG_FILE and `__log:=`; one that is missing ends logging."""
    program = tmp_path / "program.py"
    program.write_text(
        "import logging, os, rospy, sys\n"
        "rospy.init_node('configured')\n"
        "rospy.loginfo('i'); rospy.logwarn('w'); rospy.logerr('e', logger_name='x')\n"
        "logging.getLogger('mine').error('m')\n"
        "print(os.path.basename(os.environ.get('ROS_LOG_FILENAME', '-')))\n"
    )
    (tmp_path / "log.conf").write_text(CONFIGURATION)
    theirs, ours = side_by_side(
        program,
        f"__log:={tmp_path}/my.log",
        packages=[genpy_packages],
        env={"ROS_PYTHON_LOG_CONFIG_FILE": str(tmp_path / f"log.{kind}")},
    )
    if kind == "none":  # whether the name is in the environment then differs
        theirs.out, ours.out = theirs.out[:-1], ours.out[:-1]
    assert ours.compared() == theirs.compared()


CONFIGURATION = """[loggers]
keys=root, rosout
[handlers]
keys=terminal
[formatters]
keys=own
[logger_root]
level=INFO
handlers=
[logger_rosout]
level=WARN
handlers=terminal
propagate=1
qualname=rosout
[handler_terminal]
class=rosgraph.roslogging.RosStreamHandler
level=DEBUG
formatter=own
args=(True,)
[formatter_own]
format=%(message)s
"""
