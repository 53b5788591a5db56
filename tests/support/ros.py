"""Real ROS 1 (Debian's packages) as a peer: run its tools, Python scripts and C++ nodes against a master.

Everything runs in processes of its own, with a clean environment, a home directory of its own, and a time
limit; only processes started here are ever ended. The fixtures are in tests/interop/conftest.py.

A test that needs something which is absent is skipped with the reason, or fails when REQUIRE_INTEROP=1 is set.
"""

from __future__ import annotations

import atexit
import functools
import hashlib
import os
import re
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import pytest

__all__ = [
    "MSGDEFS",
    "PYTHON",
    "RosProcess",
    "build_cpp_node",
    "environment",
    "exclusive",
    "free_port",
    "generate_cpp_headers",
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

PYTHON = "/usr/bin/python3"
BIN = Path("/usr/bin")
GENMSG_PY = Path("/usr/lib/genpy/genmsg_py.py")
GENSRV_PY = Path("/usr/lib/genpy/gensrv_py.py")
GEN_CPP = Path("/usr/lib/gencpp/gen_cpp.py")
GENACTION = Path("/usr/lib/actionlib_msgs/genaction.py")
CPP_TEMPLATES = Path("/usr/share/gencpp")
MSGDEFS = Path(__file__).resolve().parents[2] / "msgdefs"
MADE_OF_ACTIONS = ("Action", "ActionGoal", "ActionResult", "ActionFeedback", "Goal", "Result", "Feedback")
TIMEOUT = 60.0  # seconds for one tool or script: a loaded computer needs several for `import rospy` alone

# -- is it there? ------------------------------------------------------------------------------------------


def require(present: object, reason: str) -> None:
    """Skip the running test unless `present`; fail it instead when REQUIRE_INTEROP=1."""
    if present:
        return
    if os.environ.get("REQUIRE_INTEROP") == "1":
        pytest.fail(f"REQUIRE_INTEROP=1, but {reason}")
    pytest.skip(reason)


@functools.cache
def _import_problem(*modules: str) -> str:
    """Why Debian's Python cannot import these; "" when it can."""
    if not Path(PYTHON).exists():
        return f"there is no {PYTHON}"
    code = "import " + ", ".join(modules)
    done = subprocess.run(
        [PYTHON, "-c", code], capture_output=True, text=True, timeout=TIMEOUT, env=_clean_environment()
    )
    return "" if done.returncode == 0 else f"{PYTHON}: {code}: {done.stderr.strip().splitlines()[-1]}"


def require_ros(*modules: str) -> None:
    """Skip (or fail, see `require`) unless Debian's Python has rospy and these modules."""
    problem = _import_problem("rospy", *modules)
    require(not problem, f"real ROS 1 is not installed ({problem})")


# -- environment and processes -----------------------------------------------------------------------------


def _clean_environment() -> dict[str, str]:
    """The little that programs need; nothing of ours that leads ROS or Debian's Python astray."""
    wanted = ("PATH", "HOME", "LANG", "LC_ALL", "TMPDIR", "LD_LIBRARY_PATH", "USER")
    return {key: os.environ[key] for key in wanted if key in os.environ}


@functools.cache
def _home() -> str:
    """A ROS home of this test process, so that no log lands in the user's."""
    path = tempfile.mkdtemp(prefix="ros-home-")
    atexit.register(shutil.rmtree, path, True)
    return path


def environment(
    master_uri: str, *, packages: Path | str | None = None, extra: Mapping[str, str] | None = None
) -> dict[str, str]:
    """Environment of a ROS process on this computer.

    Args:
        master_uri: For ROS_MASTER_URI.
        packages: Generated Python message packages (fixture `genpy_packages`), for PYTHONPATH.
        extra: Further variables.
    """
    env = _clean_environment()
    env |= {"ROS_MASTER_URI": master_uri, "ROS_IP": "127.0.0.1", "PYTHONUNBUFFERED": "1"}
    env |= {"HOME": _home(), "ROS_HOME": _home(), "ROS_LOG_DIR": f"{_home()}/log"}
    # Quiet about what a tool does with colours and old configuration.
    env |= {"TERM": "dumb", "ROSCONSOLE_FORMAT": "[${severity}] ${message}"}
    if packages is not None:
        env["PYTHONPATH"] = str(packages)
    return env | dict(extra or {})


class RosProcess:
    """A running program whose output (both streams) is collected; ends with the `with` block.

    Attributes:
        arguments: What was started.
        process: The Popen object.
    """

    def __init__(self, arguments: Sequence[str], env: Mapping[str, str]) -> None:
        self.arguments = list(arguments)
        self.process = subprocess.Popen(
            self.arguments,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            env=dict(env),
            start_new_session=True,  # so that its children end with it, and nobody else
        )
        self._lines: list[str] = []
        self._changed = threading.Condition()
        self._ended = False
        self._reader = threading.Thread(target=self._read, name="test:output", daemon=True)
        self._reader.start()

    def __enter__(self) -> RosProcess:
        return self

    def __exit__(self, *exc: object) -> None:
        self.stop()

    @property
    def pid(self) -> int:
        """Process id."""
        return self.process.pid

    @property
    def output(self) -> str:
        """Everything it has written so far."""
        with self._changed:
            return "".join(self._lines)

    @property
    def running(self) -> bool:
        """Whether it has not ended yet."""
        return self.process.poll() is None

    def wait_for(self, pattern: str, timeout: float = 30.0) -> re.Match[str]:
        """Wait until the output contains a regular expression.

        Raises:
            AssertionError: The program ended, or the time was over; the text holds the output.
        """
        end = time.monotonic() + timeout
        with self._changed:
            while True:
                found = re.search(pattern, "".join(self._lines), re.MULTILINE)
                if found:
                    return found
                left = end - time.monotonic()
                if self._ended or left <= 0:
                    state = "ended" if self._ended else f"went on for {timeout} s"
                    raise AssertionError(
                        f"{self.arguments[:3]} {state} without writing {pattern!r}; it wrote:\n"
                        + "".join(self._lines)
                    )
                self._changed.wait(left)

    def wait(self, timeout: float = 30.0) -> int:
        """Wait for its end; the exit code."""
        code = self.process.wait(timeout)
        self._reader.join(5.0)
        return code

    def interrupt(self) -> None:
        """Ctrl-C."""
        self.process.send_signal(signal.SIGINT)

    def kill(self) -> None:
        """End it and its children at once, without a chance to say good-bye."""
        self._signal(signal.SIGKILL)
        self.process.wait(10.0)

    def stop(self, patience: float = 5.0) -> None:
        """End it and its children: Ctrl-C first, by force after `patience` seconds."""
        if self.process.poll() is None:
            self._signal(signal.SIGINT)
            try:
                self.process.wait(patience)
            except subprocess.TimeoutExpired:
                pass  # by force below
        self._signal(signal.SIGKILL)
        self.process.wait(10.0)
        self._reader.join(5.0)
        if self.process.stdout is not None:
            self.process.stdout.close()

    def _signal(self, number: signal.Signals) -> None:
        try:
            os.killpg(self.process.pid, number)  # a group of its own, see start_new_session
        except ProcessLookupError:
            pass  # everybody there has ended

    def _read(self) -> None:
        assert self.process.stdout is not None
        try:
            for line in self.process.stdout:
                with self._changed:
                    self._lines.append(line)
                    self._changed.notify_all()
        except ValueError:
            pass  # closed by stop()
        with self._changed:
            self._ended = True
            self._changed.notify_all()


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
    return _run(
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
    return _run(_tool(arguments), environment(master_uri, packages=packages), timeout, check)


def start_tool(
    arguments: Sequence[str], master_uri: str, *, packages: Path | str | None = None
) -> RosProcess:
    """Start a ROS command line tool that runs on, such as `rostopic echo`; to be used in a `with`."""
    return RosProcess(_tool(arguments), environment(master_uri, packages=packages))


def start_program(
    path: Path | str, master_uri: str, *arguments: str, env: Mapping[str, str] | None = None
) -> RosProcess:
    """Start a compiled node (`build_roscpp`); to be used in a `with`."""
    return RosProcess([str(path), *arguments], environment(master_uri, extra=env))


def _tool(arguments: Sequence[str]) -> list[str]:
    program = BIN / arguments[0]
    require(program.exists(), f"there is no {program}")
    return [PYTHON, str(program), *arguments[1:]]


def _run(
    arguments: Sequence[str], env: Mapping[str, str], timeout: float, check: bool
) -> subprocess.CompletedProcess[str]:
    process = subprocess.Popen(
        list(arguments),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        errors="replace",
        env=dict(env),
        start_new_session=True,
    )
    try:
        out, err = process.communicate(timeout=timeout)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        out, err = process.communicate(timeout=10)
        raise AssertionError(f"{list(arguments)} did not end within {timeout} s:\n{out}\n{err}") from None
    if check and process.returncode != 0:
        raise AssertionError(f"{list(arguments)} ended with {process.returncode}:\n{out}\n{err}")
    return subprocess.CompletedProcess(list(arguments), process.returncode, out, err)


# -- Debian's master ---------------------------------------------------------------------------------------


def free_port() -> int:
    """A port that was free a moment ago, for programs that cannot take port 0."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextmanager
def start_real_master() -> Iterator[str]:
    """Debian's rosmaster on a free port, with what roscore puts on its parameter server; its URI."""
    from rosproto.transport import XmlRpcClient

    require_ros("rosmaster")
    for attempt in range(5):  # somebody may take the port between looking and listening
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


# -- code from our definitions, by Debian's generators -----------------------------------------------------


@contextmanager
def exclusive(lock_file: Path) -> Iterator[None]:
    """Hold a lock among processes (pytest-xdist workers)."""
    import fcntl

    with lock_file.open("w") as handle:
        fcntl.flock(handle, fcntl.LOCK_EX)
        yield


def write_revision(target: Path, package: str, label: str) -> Path:
    """The definitions of one revision of a package as files, all of them; a folder like msgdefs."""
    from rosproto.msg import bundled

    library = bundled().package_revisions(package)[label]
    names = {"msg": set(), "srv": set(library.services(package)), "action": set(library.actions(package))}
    made = {name + suffix for name in names["action"] for suffix in MADE_OF_ACTIONS}
    names["msg"] = set(library.messages(package)) - made
    looks = {"msg": library.message, "srv": library.service, "action": library.action}
    for kind, found in names.items():
        place = target / package / kind
        place.mkdir(parents=True, exist_ok=True)
        for name in found:
            text = looks[kind](name).text
            (place / f"{name.partition('/')[2]}.{kind}").write_text(text, "utf-8", errors="surrogateescape")
    return target


def _definitions(work: Path, root: Path = MSGDEFS) -> dict[str, dict[str, list[Path]]]:
    """package -> {"msg": files, "srv": files} of a folder, the messages of its actions included."""
    found: dict[str, dict[str, list[Path]]] = {}
    for package in sorted(path for path in root.iterdir() if path.is_dir()):
        files = {kind: sorted((package / kind).glob(f"*.{kind}")) for kind in ("msg", "srv")}
        for action in sorted((package / "action").glob("*.action")):
            target = work / "actions" / package.name
            target.mkdir(parents=True, exist_ok=True)
            _generate([PYTHON, str(GENACTION), str(action), "-o", str(target)])
        known = {path.name for path in files["msg"]}
        files["msg"] += [
            p for p in sorted((work / "actions" / package.name).glob("*.msg")) if p.name not in known
        ]
        if files["msg"] or files["srv"]:
            found[package.name] = files
    return found


def _include_path(work: Path, definitions: Mapping[str, object], root: Path = MSGDEFS) -> list[str]:
    places = [
        place
        for name in definitions
        for place in (root / name / "msg", work / "actions" / name)
        if place.is_dir()
    ]
    if root != MSGDEFS:  # what a revision uses of other packages
        others = (path / "msg" for path in sorted(MSGDEFS.iterdir()) if path.name not in definitions)
        places += [place for place in others if place.is_dir()]
    return [f"-I{place.parent.name if place.name == 'msg' else place.name}:{place}" for place in places]


def _generate(arguments: Sequence[str]) -> None:
    done = subprocess.run(
        list(arguments), capture_output=True, text=True, timeout=TIMEOUT, env=_clean_environment()
    )
    assert done.returncode == 0, f"{list(arguments)[:4]}: {done.stdout}{done.stderr}"


def generate_python_packages(target: Path, root: Path = MSGDEFS) -> Path:
    """Message packages for rospy from definitions, by genpy's own scripts; a directory for PYTHONPATH.

    Packages that Debian's Python has already (std_msgs, actionlib and so on) are left out: one with messages
    only would hide the code of the same name.
    """
    require_ros("genpy", "genmsg")
    require(GENMSG_PY.exists() and GENSRV_PY.exists(), f"there is no {GENMSG_PY}")
    target.mkdir(parents=True, exist_ok=True)
    definitions = _definitions(target, root)
    include = _include_path(target, definitions, root)
    for name, kinds in definitions.items():
        if not _import_problem(name):
            continue
        for kind, script in (("msg", GENMSG_PY), ("srv", GENSRV_PY)):
            if kinds[kind]:
                out = target / name / kind
                out.mkdir(parents=True, exist_ok=True)
                base = [PYTHON, str(script), "-p", name, "-o", str(out)]
                _generate([*base, *include, *map(str, kinds[kind])])
                _generate([*base, "--initpy"])
        (target / name / "__init__.py").touch()
    return target


# One process for all files: the interpreter's start would take most of the time.
_GEN_CPP_ALL = """
import json, sys, genmsg.template_tools as t
for package, kind, path, out, include, templates in json.load(open(sys.argv[1])):
    t.generate_from_command_line_options(
        ["gen_cpp.py", path, *include, "-p", package, "-o", out, "-e", templates],
        {"msg.h.template": "@NAME@.h"}, {"srv.h.template": "@NAME@.h"})
"""


def generate_cpp_headers(target: Path, root: Path = MSGDEFS) -> Path:
    """roscpp headers from definitions, by gencpp; a directory for -I.

    Packages whose headers are in /usr/include already are left out.
    """
    import json

    require(GEN_CPP.exists() and CPP_TEMPLATES.exists(), f"there is no {GEN_CPP}")
    target.mkdir(parents=True, exist_ok=True)
    definitions = _definitions(target, root)
    include = _include_path(target, definitions, root)
    work = []
    for name, kinds in definitions.items():
        if (Path("/usr/include") / name).is_dir():
            continue
        (target / name).mkdir(exist_ok=True)
        for kind in ("msg", "srv"):
            work += [
                (name, kind, str(path), str(target / name), include, str(CPP_TEMPLATES))
                for path in kinds[kind]
            ]
    plan = target / "plan.json"
    plan.write_text(json.dumps(work))
    _generate([PYTHON, "-c", _GEN_CPP_ALL, str(plan)])
    return target


def build_cpp_node(name: str, source: str, target: Path, headers: Path | None = None) -> Path:
    """Compile a roscpp program; the path of the executable. The same source is compiled once per directory."""
    compiler, config = shutil.which("g++"), shutil.which("pkg-config")
    require(compiler and config, "there is no g++ or pkg-config")
    flags = subprocess.run(
        [str(config), "--cflags", "--libs", "roscpp"], capture_output=True, text=True, timeout=TIMEOUT
    )
    require(flags.returncode == 0, "roscpp's development files are not installed")
    digest = hashlib.sha256(source.encode()).hexdigest()[:12]
    program = target / f"{name}-{digest}"
    with exclusive(target / f"{name}-{digest}.lock"):
        if not program.exists():
            text = target / f"{name}-{digest}.cpp"
            text.write_text(source)
            include = [f"-I{headers}"] if headers is not None else []
            built = program.with_suffix(".tmp")
            command = [str(compiler), "-O1", "-std=c++17", "-w", *include, str(text), "-o", str(built)]
            libraries = [*flags.stdout.split(), "-lpthread"]
            if "<actionlib/" in source:
                libraries.insert(0, "-lactionlib")
            done = subprocess.run([*command, *libraries], capture_output=True, text=True, timeout=300)
            assert done.returncode == 0, f"{name} does not compile:\n{done.stderr}"
            built.rename(program)
    return program
