"""Runs or starts programs for tests and collects their output; checks whether Debian's ROS is installed.

Programs run in separate processes, with a clean environment, a temporary home directory, and a time limit; only
processes started here are ended.

A test with a missing requirement is skipped with the reason, or fails when REQUIRE_INTEROP=1 is set.
"""

from __future__ import annotations

import atexit
import functools
import os
import re
import shutil
import signal
import subprocess
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from subprocess import Popen
from typing import IO

import pytest

from tests.support import ros_warm
from tests.support.ros_warm import PYTHON, WarmProcess

__all__ = [
    "PYTHON",
    "TIMEOUT",
    "RosProcess",
    "clean_environment",
    "environment",
    "exclusive",
    "import_problem",
    "require",
    "require_ros",
    "run",
]

TIMEOUT = 120.0  # seconds for one tool or script, which end what hangs: a loaded computer needs ten for `import rospy`

# -- requirements ------------------------------------------------------------------------------------------


def require(present: object, reason: str) -> None:
    """Skip the running test unless `present`; fail it instead when REQUIRE_INTEROP=1."""
    if present:
        return
    if os.environ.get("REQUIRE_INTEROP") == "1":
        pytest.fail(f"REQUIRE_INTEROP=1, but {reason}")
    pytest.skip(reason)


@functools.cache
def import_problem(*modules: str) -> str:
    """Why Debian's Python cannot import these; "" when it can."""
    if not Path(PYTHON).exists():
        return f"there is no {PYTHON}"
    code = "import " + ", ".join(modules)
    done = subprocess.run(
        [PYTHON, "-c", code], capture_output=True, text=True, timeout=TIMEOUT, env=clean_environment()
    )
    return "" if done.returncode == 0 else f"{PYTHON}: {code}: {done.stderr.strip().splitlines()[-1]}"


def require_ros(*modules: str) -> None:
    """Skip (or fail, see `require`) unless Debian's Python has rospy and these modules."""
    problem = import_problem("rospy", *modules)
    require(not problem, f"real ROS 1 is not installed ({problem})")


# -- environment and processes -----------------------------------------------------------------------------


def clean_environment() -> dict[str, str]:
    """Return a minimal environment, without variables that affect ROS or Debian's Python."""
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
    env = clean_environment()
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
        arguments: The command line.
        process: The Popen object, or a `WarmProcess`.
    """

    def __init__(self, arguments: Sequence[str], env: Mapping[str, str]) -> None:
        self.arguments = list(arguments)
        reading, writing = os.pipe()
        self._output = os.fdopen(reading, "r", errors="replace")
        try:
            self.process = _start(self.arguments, env, writing, writing)
        finally:
            os.close(writing)
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

    def lines_after(self, number: int, timeout: float) -> list[str]:
        """Return the lines after the first ones; wait for one, until the program ends or the time is over."""
        with self._changed:
            self._changed.wait_for(lambda: len(self._lines) > number or self._ended, timeout)
            return self._lines[number:]

    def wait_for(self, pattern: str, timeout: float = 60.0) -> re.Match[str]:
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

    def wait(self, timeout: float = 60.0) -> int:
        """Wait for its end; the exit code."""
        code = self.process.wait(timeout)
        self._reader.join(5.0)
        return code

    def interrupt(self) -> None:
        """Ctrl-C."""
        self.process.send_signal(signal.SIGINT)

    def kill(self) -> None:
        """Kill it and its children."""
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
        self._output.close()

    def _signal(self, number: signal.Signals) -> None:
        try:
            os.killpg(self.process.pid, number)  # a group of its own, see start_new_session
        except ProcessLookupError:
            pass  # all of its processes have ended

    def _read(self) -> None:
        try:
            for line in self._output:
                with self._changed:
                    self._lines.append(line)
                    self._changed.notify_all()
        except ValueError:
            pass  # closed by stop()
        with self._changed:
            self._ended = True
            self._changed.notify_all()


def _start(
    arguments: Sequence[str], env: Mapping[str, str], out: int, err: int
) -> WarmProcess | Popen[bytes]:
    """Start a program in a new process group, so that only its children end with it."""
    if ros_warm.fits(arguments, env) and not import_problem("rospy"):
        return ros_warm.start(arguments, env, out, err)
    return Popen(
        list(arguments),
        stdin=subprocess.DEVNULL,
        stdout=out,
        stderr=err,
        env=dict(env),
        start_new_session=True,
    )


def run(
    arguments: Sequence[str], env: Mapping[str, str], timeout: float, check: bool
) -> subprocess.CompletedProcess[str]:
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        process = _start(arguments, env, out.fileno(), err.fileno())
        try:
            process.wait(timeout)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait(10)
            said = "\n".join(_text(file) for file in (out, err))
            raise AssertionError(f"{list(arguments)} did not end within {timeout} s:\n{said}") from None
        done = subprocess.CompletedProcess(list(arguments), process.wait(), _text(out), _text(err))
    if check and done.returncode != 0:
        raise AssertionError(f"{list(arguments)} ended with {done.returncode}:\n{done.stdout}\n{done.stderr}")
    return done


def _text(file: IO[bytes]) -> str:
    file.seek(0)
    return file.read().decode("utf-8", "replace")


@contextmanager
def exclusive(lock_file: Path) -> Iterator[None]:
    """Hold a lock among processes (pytest-xdist workers)."""
    import fcntl

    with lock_file.open("w") as handle:
        fcntl.flock(handle, fcntl.LOCK_EX)
        yield
