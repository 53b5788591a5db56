"""Debian's Python with rospy and ROS's tools loaded, which is forked for each program.

`import rospy` costs more than most programs of the tests do themselves. Each program runs in a process (and a group)
of its own, forked from one that has loaded what they share and has done nothing else: as `python3 FILE` or
`python3 -c CODE` would run it, with its own arguments, environment, streams, and the whole end of an interpreter.

    process = start([PYTHON, "-c", "print(1)"], env, stdout, stderr)   # of tests; like a subprocess.Popen

The other half, `serve`, is this file as a program under Debian's Python.
"""

from __future__ import annotations

import contextlib
import functools
import gc
import json
import os
import selectors
import signal
import socket
import subprocess
import sys
import threading
import types
from collections.abc import Mapping, Sequence
from typing import Any

__all__ = ["WarmProcess", "fits", "start"]

PYTHON = "/usr/bin/python3"
LOADED = (
    "rospy", "roslib.message", "std_msgs.msg", "geometry_msgs.msg", "sensor_msgs.msg", "rostopic", "rosnode", "rosservice",
    "rosparam", "rosmsg", "rosbag", "rosmaster", "rosmaster.main", "xmlrpc.server",
)  # fmt: skip
# What is in an environment when a program starts and is not looked at before: any other needs a Python of its own.
KNOWN = {
    "PATH", "HOME", "LANG", "LC_ALL", "TMPDIR", "LD_LIBRARY_PATH", "USER", "TERM", "PYTHONPATH", "PYTHONUNBUFFERED",
    "ROS_MASTER_URI", "ROS_IP", "ROS_HOME", "ROS_LOG_DIR", "ROSCONSOLE_FORMAT",
}  # fmt: skip


# -- the tests' side ---------------------------------------------------------------------------------------


def fits(arguments: Sequence[str], env: Mapping[str, str]) -> bool:
    """Whether a warm Python can run this command line."""
    return (
        arguments[0] == PYTHON
        and (arguments[1] == "-c" or not arguments[1].startswith("-"))
        and set(env) <= KNOWN
        and env.get("PYTHONUNBUFFERED") == "1"
    )


class WarmProcess:
    """The used part of the interface of `subprocess.Popen`."""

    def __init__(self, arguments: Sequence[str], pid: int) -> None:
        self.args = list(arguments)
        self.pid = pid
        self.returncode: int | None = None
        self.ended = threading.Event()

    def poll(self) -> int | None:
        return self.returncode

    def wait(self, timeout: float | None = None) -> int:
        if not self.ended.wait(timeout):
            raise subprocess.TimeoutExpired(self.args, timeout or 0.0)
        assert self.returncode is not None
        return self.returncode

    def send_signal(self, number: int) -> None:
        if self.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self.pid, number)


class _Warm:
    """The process that is forked, one per process of tests; it ends with it."""

    def __init__(self, env: Mapping[str, str]) -> None:
        self._socket, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with theirs:
            self._process = subprocess.Popen(
                [PYTHON, __file__, str(theirs.fileno())], pass_fds=[theirs.fileno()], env=dict(env),
                stdin=subprocess.DEVNULL, start_new_session=True, cwd="/",
            )  # fmt: skip
        self._lock = threading.Lock()
        self._changed = threading.Condition()
        self._started: list[int] = []
        self._running: dict[int, WarmProcess] = {}
        self._codes: dict[int, int] = {}
        threading.Thread(target=self._read, name="test:warm", daemon=True).start()

    def start(self, arguments: Sequence[str], env: Mapping[str, str], out: int, err: int) -> WarmProcess:
        order = {"arguments": list(arguments[1:]), "env": dict(env), "folder": os.getcwd()}
        with self._lock, self._changed:
            socket.send_fds(self._socket, [json.dumps(order).encode()], [out, err])
            assert self._changed.wait_for(lambda: self._started, 120), "the warm Python does not answer"
            process = WarmProcess(arguments, self._started.pop())
            self._running[process.pid] = process
            if process.pid in self._codes:
                self._end(process.pid, self._codes.pop(process.pid))
        return process

    def _read(self) -> None:
        while message := self._socket.recv(1000):
            pid, code = json.loads(message)
            with self._changed:
                if code is None:
                    self._started.append(pid)
                elif pid in self._running:
                    self._end(pid, code)
                else:
                    self._codes[pid] = code  # it ended before its id was known
                self._changed.notify_all()

    def _end(self, pid: int, code: int) -> None:
        process = self._running.pop(pid)
        process.returncode = code
        process.ended.set()


@functools.cache
def _warm() -> _Warm:
    wanted = ("PATH", "HOME", "LANG", "LC_ALL", "TMPDIR", "LD_LIBRARY_PATH", "USER")
    return _Warm({**{key: os.environ[key] for key in wanted if key in os.environ}, "PYTHONUNBUFFERED": "1"})


def start(arguments: Sequence[str], env: Mapping[str, str], out: int, err: int) -> WarmProcess:
    """Start a program that `fits`; its streams are file descriptors, which the caller may close afterwards."""
    return _warm().start(arguments, env, out, err)


# -- the forked side ---------------------------------------------------------------------------------------


def serve(control: socket.socket) -> dict[str, Any]:
    """Fork for every order, report process id and later exit code; return in the children, with the order."""
    for name in LOADED:
        with contextlib.suppress(ImportError):
            __import__(name)
    gc.freeze()  # the collector of each program skips the loaded objects
    woken, wake = os.pipe()
    os.set_blocking(wake, False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    signal.set_wakeup_fd(wake)
    with selectors.DefaultSelector() as selector:
        selector.register(control, selectors.EVENT_READ)
        selector.register(woken, selectors.EVENT_READ)
        while True:
            for key, _ in selector.select():
                if key.fileobj is control:
                    data, streams, _, _ = socket.recv_fds(control, 1 << 20, 2)
                    if not data:
                        raise SystemExit
                    order: dict[str, Any] = json.loads(data)
                    pid = os.fork()
                    if pid == 0:
                        signal.set_wakeup_fd(-1)
                        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
                        for fd in (woken, wake):
                            os.close(fd)
                        return {**order, "streams": streams}
                    for fd in streams:
                        os.close(fd)
                    os.setpgid(pid, pid)
                    control.send(json.dumps([pid, None]).encode())
                else:
                    os.read(woken, 1000)
                    _tell_ends(control)


def _tell_ends(control: socket.socket) -> None:
    while True:
        try:
            pid, status = os.waitpid(-1, os.WNOHANG)
        except ChildProcessError:
            return
        if not pid:
            return
        control.send(json.dumps([pid, os.waitstatus_to_exitcode(status)]).encode())


def become(order: Mapping[str, Any]) -> None:
    """Run the program in this process."""
    for number, fd in zip((1, 2), order["streams"], strict=True):
        os.dup2(fd, number)
        os.close(fd)
    os.chdir(order["folder"])
    os.environ.clear()
    os.environ.update(order["env"])
    first, *rest = order["arguments"]
    sys.path[0] = "" if first == "-c" else os.path.dirname(first)
    sys.path[1:1] = [folder for folder in order["env"].get("PYTHONPATH", "").split(os.pathsep) if folder]
    main = types.ModuleType("__main__")
    sys.modules["__main__"] = main
    if first == "-c":  # into the list that is there: ROS's functions have it as their default
        name, text, sys.argv[:] = "<string>", rest[0], ["-c", *rest[1:]]
    else:
        main.__file__ = name = first
        sys.argv[:] = [first, *rest]
        with open(first, encoding="utf-8") as file:
            text = file.read()
    sys.modules["rospy"].names.reload_mappings(sys.argv)
    try:
        exec(compile(text, name, "exec"), main.__dict__)
    except Exception as error:
        inner = error.__traceback__ and error.__traceback__.tb_next
        sys.excepthook(type(error), error.with_traceback(inner), inner)
        raise SystemExit(1) from None


def _live() -> None:
    with socket.socket(fileno=int(sys.argv[1])) as control:
        order = serve(control)
        os.setpgid(0, 0)
    become(order)


if __name__ == "__main__":
    _live()
