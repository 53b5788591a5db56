"""Real ROS 1 (Debian's packages) as a peer: run its tools, Python scripts and C++ nodes against a master.

What a test uses is here; how programs are run is in ros_process.py, and how code is made for them in ros_code.py.
"""

from __future__ import annotations

import socket
import subprocess
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from tests.support.ports import unused_port
from tests.support.ros_code import (
    GENMSG_PY,
    GENSRV_PY,
    MSGDEFS,
    build_cpp_node,
    generate_python_packages,
    write_revision,
)
from tests.support.ros_process import (
    PYTHON,
    TIMEOUT,
    RosProcess,
    clean_environment,
    environment,
    exclusive,
    require,
    require_ros,
    run,
)

__all__ = [
    "GENMSG_PY",
    "GENSRV_PY",
    "MSGDEFS",
    "PYTHON",
    "RosProcess",
    "build_cpp_node",
    "clean_environment",
    "environment",
    "exclusive",
    "free_port",
    "generate_python_packages",
    "require",
    "require_ros",
    "ros_tool",
    "run_rospy",
    "start_program",
    "start_real_master",
    "start_rospy",
    "start_tool",
    "write_revision",
]

BIN = Path("/usr/bin")


def _rospy_arguments(code_or_path: str | Path, arguments: Sequence[str]) -> list[str]:
    if isinstance(code_or_path, Path):
        return [PYTHON, str(code_or_path), *arguments]
    return [PYTHON, "-c", code_or_path, *arguments]


def run_rospy(
    code_or_path: str | Path,
    master_uri: str,
    *arguments: str,
    packages: Path | str | None = None,
    env: Mapping[str, str] | None = None,
    timeout: float = TIMEOUT,
    check: bool = True,
) -> subprocess.CompletedProcess[str]:
    """Run Python code (a string) or a script (a Path) with Debian's Python until it ends.

    Raises:
        AssertionError: It failed (with `check`) or took too long; the text holds its output.
    """
    require_ros()
    return run(
        _rospy_arguments(code_or_path, arguments),
        environment(master_uri, packages=packages, extra=env),
        timeout,
        check,
    )


def start_rospy(
    code_or_path: str | Path,
    master_uri: str,
    *arguments: str,
    packages: Path | str | None = None,
    env: Mapping[str, str] | None = None,
) -> RosProcess:
    """As `run_rospy`, in the background; to be used in a `with`."""
    require_ros()
    return RosProcess(
        _rospy_arguments(code_or_path, arguments), environment(master_uri, packages=packages, extra=env)
    )


def ros_tool(
    arguments: Sequence[str],
    master_uri: str,
    *,
    packages: Path | str | None = None,
    timeout: float = TIMEOUT,
    check: bool = True,
) -> subprocess.CompletedProcess[str]:
    """Run a ROS command line tool, `["rostopic", "list"]`, until it ends; see `run_rospy`."""
    return run(_tool(arguments), environment(master_uri, packages=packages), timeout, check)


def start_tool(
    arguments: Sequence[str], master_uri: str, *, packages: Path | str | None = None
) -> RosProcess:
    """Start a ROS command line tool that runs on, such as `rostopic echo`; to be used in a `with`."""
    return RosProcess(_tool(arguments), environment(master_uri, packages=packages))


def start_program(
    path: Path | str, master_uri: str, *arguments: str, env: Mapping[str, str] | None = None
) -> RosProcess:
    """Start a compiled node (`build_cpp_node`); to be used in a `with`."""
    return RosProcess([str(path), *arguments], environment(master_uri, extra=env))


def _tool(arguments: Sequence[str]) -> list[str]:
    program = BIN / arguments[0]
    require(program.exists(), f"there is no {program}")
    return [PYTHON, str(program), *arguments[1:]]


# -- Debian's master ---------------------------------------------------------------------------------------


def free_port() -> int:
    """A port for programs that cannot take port 0."""
    return unused_port()


@contextmanager
def start_real_master() -> Iterator[str]:
    """Debian's rosmaster on a free port, with what roscore puts on its parameter server; its URI."""
    from rosproto.transport import XmlRpcClient

    require_ros("rosmaster")
    for attempt in range(5):  # another program may take the port before it is used
        port = free_port()
        uri = f"http://127.0.0.1:{port}/"
        with RosProcess(
            [PYTHON, str(BIN / "rosmaster"), "--core", "-p", str(port)], environment(uri)
        ) as process:
            if not _listening(port, process):
                assert attempt < 4, f"rosmaster does not start:\n{process.output}"
                continue
            with XmlRpcClient(uri) as client:
                for key, value in (("/run_id", f"test-{port}"), ("/rosdistro", "noetic\n")):
                    client.call("setParam", "/roscore", key, value)
            yield uri
            return


def _listening(port: int, process: RosProcess, timeout: float = 30.0) -> bool:
    end = time.monotonic() + timeout
    while process.running and time.monotonic() < end:
        try:
            socket.create_connection(("127.0.0.1", port), 1.0).close()
            return True
        except OSError:
            time.sleep(0.02)
    return False
