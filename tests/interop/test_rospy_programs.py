"""Programs written for rospy, each run by real rospy and by `rosproto run`, with the same kind of peer."""

from __future__ import annotations

import contextlib
import signal
import subprocess
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

import rosproto
from tests.interop.rospy_peers import (
    action_caller,
    action_server,
    answers,
    calls,
    clock,
    hears,
    says,
    together,
)
from tests.support import ros
from tests.support.rospy_pair import Outcome, run_program

Run = Callable[..., tuple[Outcome, Outcome]]

STRINGS = [{"data": f"word {i}"} for i in range(5)]


@pytest.fixture
def both(genpy_packages: Path) -> Run:
    """Run a program by both at the same time; compare them unless told not to."""

    def run(program: str, *arguments: str, compare: bool = True, **options: Any) -> tuple[Outcome, Outcome]:
        brought = tuple(options.pop("brought", ()))
        with ThreadPoolExecutor(2) as pool:  # each has a master and peers of its own
            runs = [
                pool.submit(run_program, program, *arguments, real=real, packages=packages, **options)
                for real, packages in ((True, [*brought, genpy_packages]), (False, brought))
            ]
            theirs, ours = (run.result() for run in runs)
        if compare:
            assert ours.code == theirs.code, ours.err
            assert ours.out == theirs.out
            assert ours.err == theirs.err
            assert ours.noted == theirs.noted
        return theirs, ours

    return run


def switch(request: Any) -> Any:
    return {"success": True, "message": "on" if request.data else "off"}


def refuse(request: Any) -> Any:
    raise rosproto.ServiceError("/refuse", "not today")


def slow(request: Any) -> Any:
    time.sleep(3)
    return {"success": True, "message": "late"}


SERVICES = answers({"/switch": ("std_srvs/SetBool", switch), "/refuse": ("std_srvs/Trigger", refuse)})
SERVER_CALLS = calls(
    [
        ("/switch", "std_srvs/SetBool", {"data": True}),
        ("/switch", "std_srvs/SetBool", {"data": False}),
        ("/as_dict", "std_srvs/SetBool", {"data": True}),
        ("/as_list", "std_srvs/SetBool", {"data": True}),
        ("/nothing", "std_srvs/SetBool", {"data": True}),
        ("/too_few", "std_srvs/SetBool", {"data": True}),
        ("/wrong", "std_srvs/SetBool", {"data": True}),
        ("/fails", "std_srvs/Trigger", {}),
        ("/server/private", "std_srvs/Empty", {}),
        ("/quit", "std_srvs/Empty", {}),
    ]
)
SCAN = {"ranges": [1.0, 2.0, 3.5], "range_max": 4.0}
TYPES = {
    "t_int8": "Int8",
    "t_uint8": "UInt8",
    "t_uint64": "UInt64",
    "t_float64": "Float64",
    "t_bool": "Bool",
    "t_string": "String",
    "t_time": "Time",
}
WRONG_TOPICS = {f"/{topic}": f"std_msgs/{kind}" for topic, kind in TYPES.items()} | {
    "/t_twist": "geometry_msgs/Twist",
    "/t_laserscan": "sensor_msgs/LaserScan",
    "/t_posestamped": "geometry_msgs/PoseStamped",
}


def end_node(uri: str) -> None:
    """What `rosnode kill` does."""
    from rosproto.node import MasterClient, NodeClient

    with MasterClient(uri, "/killer") as master, contextlib.suppress(rosproto.ConnectionLost):
        # rospy may be gone before it has answered.
        NodeClient(master.lookup_node("/action_server"), "/killer").shutdown("user request")


CASES: dict[str, dict[str, Any]] = {
    "talker.py": {"peer": hears({"/chatter": "std_msgs/String"})},
    "listener.py": {"peer": says({"/chatter": ("std_msgs/String", STRINGS[:3])}, latch=False)},
    "params.py": {
        "arguments": ["_rate:=10", "_name:=base", "_list:=[1, 2.5, x]", "_on:=true", "_half:=0.5"],
        "master_params": {"/given": {"number": 7}},
    },
    "service_server.py": {"peer": SERVER_CALLS},
    "service_client.py": {"peer": SERVICES},
    "action_client.py": {"peer": action_server()},
    "action_server.py": {"peer": action_caller([(3, None), (-2, None), (7, None), (1000, 0.1)], end_node)},
    "timers.py": {},
    "hooks.py": {"peer": hears({"/stop": "std_msgs/Float64"})},
    "uncaught.py": {},
    "wrong_values.py": {"peer": hears(WRONG_TOPICS)},
    "names.py": {"peer": hears({"/chatter": "std_msgs/String", "/names/private": "std_msgs/String"})},
    "latched.py": {
        "peer": together(
            says({"/given": ("std_msgs/String", [{"data": "kept"}])}), hears({"/mine": "std_msgs/Int8"})
        )
    },
    "waiting.py": {"peer": says({"/given": ("std_msgs/String", [{"data": "kept"}])})},
    "queues.py": {
        "peer": says(
            {
                "/numbers_a": ("std_msgs/UInt64", [{"data": i} for i in range(100)]),
                "/numbers_b": ("std_msgs/UInt64", [{"data": i} for i in range(100)]),
            },
            latch=False,
            pause=0.02,
        )
    },
    "logs.py": {},
    "callbacks.py": {
        "peer": says({"/pose": ("geometry_msgs/PoseStamped", [{}] * 5)}, latch=False, when="/ready")
    },
    "processes.py": {"peer": hears({"/never": "std_msgs/String", "/from_children": "std_msgs/String"})},
    "listeners.py": {
        "peer": together(
            hears({"/greeting": "std_msgs/String"}),
            hears({"/relayed": "std_msgs/String"}, name="/other_ear"),
            says({"/given": ("std_msgs/String", [{"data": "kept"}])}),
        )
    },
    "transforms.py": {},
    "synchronised.py": {},
    "simulated_time.py": {"peer": clock(speed=1000.0), "master_params": {"/use_sim_time": True}},
}


@pytest.mark.parametrize("program", CASES)
def test_a_program_does_what_it_does_with_rospy(program: str, both: Run) -> None:
    """Exit code, both streams, and what the peer saw."""
    options = dict(CASES[program])
    theirs, ours = both(program, *options.pop("arguments", []), compare=False, **options)
    if program == "processes.py":  # which child is first is chance
        for outcome in (theirs, ours):
            outcome.noted[0]["/from_children"].sort()
    if program == "wrong_values.py":  # a failed publish leaves rospy's stream out of step (its bug)
        theirs.noted = ours.noted
    assert ours.compared() == theirs.compared()
    assert ours.out or ours.err, "a program that says nothing shows nothing"


def test_numpy_msg() -> None:
    """Arrays for those who ask for them, tuples and bytes for the others (Debian's rospy has no numpy)."""
    peer = together(
        says(
            {
                "/scan": ("sensor_msgs/LaserScan", [SCAN]),
                "/bytes": ("std_msgs/UInt8MultiArray", [{"data": b"\x01\x02"}]),
            }
        ),
        hears({"/doubled": "sensor_msgs/LaserScan"}),
    )
    ours = run_program("numpy_program.py", real=False, peer=peer)
    assert (ours.code, ours.err) == (0, [])
    assert ours.out == ["ndarray float32 6.5 0", "tuple (1.0, 2.0, 3.5)  False", "bytes b'\\x01\\x02'"]
    first, second = ours.noted[0]["/doubled"]
    assert "ranges: [2.0, 4.0, 7.0]" in first
    assert "intensities: [1.0, 2.5]" in first
    assert "ranges: [0.0, 1.0, 2.0]" in second


def test_remapped_in_a_namespace(both: Run) -> None:
    """`name:=other`, `__name:=`, `__ns:=` and plain arguments side by side."""
    peer = hears({"/ns/talk": "std_msgs/String", "/ns/renamed/private": "std_msgs/String"})
    arguments = ["plain", "chatter:=talk", "__name:=renamed", "__ns:=/ns", "--flag", "5"]
    both("names.py", *arguments, peer=peer)


@pytest.mark.parametrize(
    ("arguments", "namespace"),
    [
        (["my-node"], ""),
        (["my.node"], ""),
        (["kn\u00f6ten"], ""),
        (["7up"], ""),
        (["n", "__name:=my-node"], ""),
        (["n", "__ns:=/robot-1"], ""),
        (["n"], "robot-1"),
        (["a/b"], ""),
    ],
)
def test_a_name_that_is_not_legal(arguments: list[str], namespace: str, both: Run) -> None:
    """rospy warns and goes on; it refuses a name with a namespace."""
    both("odd_node_name.py", *arguments, env={"ROS_NAMESPACE": namespace})


def test_anonymous(both: Run) -> None:
    """The name is made of process and time."""
    _, ours = both("names.py", "--anonymous", peer=hears({"/chatter": "std_msgs/String"}))
    assert "_PID_MS" in ours.out[1]


def test_log_lines_with_their_time(both: Run) -> None:
    """`[INFO] [1234.567]: text` without ROSCONSOLE_FORMAT, on the streams that rospy takes."""
    form = "[${severity}] [${time}]: ${message}"
    _, ours = both("logs.py", env={"ROSCONSOLE_FORMAT": form})
    assert "[INFO] [TIME]: info 5 and [1]" in ours.out
    assert "[ERROR] [TIME]: error" in ours.err


MY_MSGS = {
    "msg/Reading.msg": "Header header\nfloat64[] values\nstring[] names\nuint8[] raw\nuint32 count\n"
    "time at\ngeometry_msgs/Point[] points\n",
    "msg/Odd.msg": "int32 pass=7\nint32 OTHER=8\nint32 yield\nint32 in\nstring from\nfloat32[] class\nint32 self\n"
    "int32 print\nuint8[] lambda\nint32 None\nstring data\n",
    "msg/OddHolder.msg": "Odd def\nOdd[] with\n",
    "srv/Scale.srv": "float64 factor\nfloat64 value\n---\nfloat64 result\n",
}


@pytest.fixture(scope="module")
def my_msgs(ros_installed: None, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A user's own package: (folder with generated code, folder with the definitions)."""
    base = tmp_path_factory.mktemp("brought")
    code, definitions = base / "code" / "my_msgs", base / "definitions" / "my_msgs"
    for name, text in MY_MSGS.items():
        file = definitions / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        kind = file.parent.name
        out = code / kind
        out.mkdir(parents=True, exist_ok=True)
        tool = str(ros.GENMSG_PY if kind == "msg" else ros.GENSRV_PY)
        include = [f"-I{p}:{ros.MSGDEFS / p / 'msg'}" for p in ("std_msgs", "geometry_msgs")]
        start = [ros.PYTHON, tool, "-p", "my_msgs", "-o", str(out)]
        subprocess.run(
            [*start, *include, f"-Imy_msgs:{definitions / 'msg'}", str(file)], check=True, timeout=60
        )
        subprocess.run([*start, "--initpy"], check=True, timeout=60)
    (code / "__init__.py").touch()
    return code.parent, definitions.parent


def test_a_package_that_the_user_brings(both: Run, my_msgs: tuple[Path, Path]) -> None:
    """Code that genpy generated runs on our genpy, over topics and services."""
    both("brought.py", brought=[my_msgs[0]])


@pytest.mark.parametrize("program", ["brought.py", "reserved_names.py"])
def test_a_package_of_definitions_only(
    program: str, my_msgs: tuple[Path, Path], genpy_packages: Path
) -> None:
    """`--msg-path` does what generated code does."""
    theirs = run_program(program, real=True, packages=[my_msgs[0], genpy_packages])
    ours = run_program(program, real=False, options=["--msg-path", str(my_msgs[1])])
    assert ours.compared() == theirs.compared()
    assert ours.code == 0


@pytest.mark.parametrize(
    ("program", "number", "arguments"),
    [
        ("ctrl_c_loop.py", signal.SIGINT, []),
        ("ctrl_c_loop.py", signal.SIGTERM, []),
        ("ctrl_c_spin.py", signal.SIGINT, []),
        ("ctrl_c_wait.py", signal.SIGINT, []),
        ("ctrl_c_python.py", signal.SIGINT, []),
        ("ctrl_c_python.py", signal.SIGINT, ["again"]),
    ],
)
def test_a_signal_ends_a_program_as_with_rospy(
    program: str, number: int, arguments: list[str], both: Run
) -> None:
    """The same output and exit code, and not later: no wait that rospy does not know (ours end after 5 s and more)."""
    peer = answers({"/slow": ("std_srvs/Trigger", slow)})
    theirs, ours = both(program, *arguments, peer=peer, interrupt=number)
    assert ours.seconds < theirs.seconds + 5.0


def test_no_master_then_ctrl_c(tmp_path: Path, both: Run) -> None:
    """Says so once, tries on, and ends with 1 when interrupted."""
    program = tmp_path / "alone.py"
    program.write_text('import rospy\nrospy.init_node("alone")\n')
    env = {"ROS_MASTER_URI": "http://127.0.0.1:1/"}
    _, ours = both(str(program), interrupt=signal.SIGINT, ready="Unable to register", env=env)
    assert ours.code == 1
    assert "Unable to register with master node" in ours.out[0]


CHASSIS_PROGRAMS: dict[str, list[str]] = {
    "chassis_velocity.py": [],
    "chassis_step.py": [],
    "chassis_task.py": ["A1"],
}


def on_a_chassis(
    programs: Sequence[str], *, firmware: str = "", real_packages: Path | None = None
) -> list[Outcome]:
    """Run chassis programs one after the other on one simulated chassis; by real rospy where its packages are given."""
    from woosh_pure import SimulatedChassis

    options = {"firmware": firmware} if firmware else {}
    with SimulatedChassis(speed=5, **options) as sim:
        return [
            run_program(
                program,
                *CHASSIS_PROGRAMS[program],
                real=real_packages is not None,
                packages=[real_packages] if real_packages else [],
                master_uri=sim.master_uri,
            )
            for program in programs
        ]


def test_chassis_programs(genpy_packages: Path) -> None:
    """The same programs against the same simulated chassis."""
    names = list(CHASSIS_PROGRAMS)
    with ThreadPoolExecutor(2) as pool:
        real = pool.submit(on_a_chassis, names, real_packages=genpy_packages)
        ours = on_a_chassis(names)
        theirs = real.result()
    assert [(n, o.compared()) for n, o in zip(names, ours, strict=True)] == [
        (n, o.compared()) for n, o in zip(names, theirs, strict=True)
    ]
    assert [o.code for o in ours] == [0, 0, 0], [o.err for o in ours]


def test_sim_option(genpy_packages: Path) -> None:
    """`woosh run --sim` needs no chassis and no master."""
    ours = run_program(
        "chassis_velocity.py",
        real=False,
        command="woosh_pure",
        options=["--sim"],
        env={"ROS_MASTER_URI": "http://127.0.0.1:1/"},
    )
    code, printed, (told, *more), rest = ours.compared()
    assert (code, printed, more, rest) == (0, ["True"], [], [])
    assert told.startswith("a new simulated robot")


@pytest.mark.parametrize("firmware", ["1.0.7", "page"])
def test_a_chassis_with_other_definitions(firmware: str) -> None:
    """What real rospy refuses by md5sum: topics, services and actions of another firmware."""
    ours = on_a_chassis(["chassis_step.py", "chassis_task.py"], firmware=firmware)
    assert [o.code for o in ours] == [0, 0], [o.err for o in ours]
    assert [o.out[0] for o in ours] == ["True 3 1", "True Battery"]


def test_packages_are_those_of_rospy(both: Run) -> None:
    """load_manifest, modules of message packages, and what a bag says of its compression."""
    both("packages.py")


@pytest.mark.parametrize("name", ["roslaunch", "rosmaster", "rosmaster.master_api"])
def test_debians_modules_that_cannot_run_here_say_so(tmp_path: Path, name: str) -> None:
    """With Debian's packages on the path; before, "No module named 'rosgraph.xmlrpc'"."""
    program = tmp_path / "program.py"
    program.write_text(f"import {name}\n", "utf-8")
    done = run_program(program, real=False, packages=["/usr/lib/python3/dist-packages"])
    assert done.code == 1
    assert done.err[-1].startswith(f"ModuleNotFoundError: No module named {name.partition('.')[0]!r}: ")
    assert "rosproto" in done.err[-1]
