"""The program's side of the watchdog: start the process, send it the watches and the heartbeat.

One thread writes all lines, so no other thread waits for the pipe: a stop only adds to a queue. The same
thread sends the heartbeat, which therefore ends when the program is stopped or hangs as a whole.
"""

from __future__ import annotations

import itertools
import os
import queue
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import replace

from rosproto.errors import RemoteProtocolError
from rosproto.logs import get_logger
from rosproto.node import Node
from rosproto.sentence import say
from rosproto.transport import next_item
from rosproto.watchdog.protocol import (
    HEARTBEAT_SECONDS,
    Arm,
    Disarm,
    Drop,
    Heartbeat,
    LastCall,
    LastMessage,
    LastRequest,
    Line,
    Prepare,
    Ready,
    Sent,
    WatchedNode,
    read_line,
    write_line,
)

_log = get_logger("rosproto.watchdog")

READY_SECONDS = 2.0  # that a motion waits for its watch
START_SECONDS = 10.0  # more for the first motion: the process is still starting
END_SECONDS = 3.0  # for the process to end by itself
MAX_RESTARTS = 3
RESTART_WINDOW_SECONDS = 30.0  # seconds, for `MAX_RESTARTS`
MAX_LOOKS_WITHOUT_REPORT = 3  # one a second, as the reports of the process while something moves
_WITHOUT = say(
    "if this program is killed, what it has sent last stays in force: keep the red button within reach"
)


def watched_node_of(node: Node, msg_path: Sequence[str | os.PathLike[str]] = ()) -> WatchedNode:
    """The `WatchedNode` for a node.

    Args:
        node: Our node.
        msg_path: Folders with additional definitions that the node was given.
    """
    folders = tuple(os.path.abspath(folder) for folder in msg_path)
    return WatchedNode(node.master_uri, node.name, node.host_given, dict(node.hosts.given), folders)


class Watch:
    """One watch, created by `Watchdog.watch`. Only `wait` blocks.

    Attributes:
        armed: Whether something moves, or may.
    """

    def __init__(self, owner: Watchdog, line: Prepare) -> None:
        self._owner = owner
        self._line = line
        self._has_report = threading.Event()
        self.armed = line.armed
        self._data: tuple[bytes, ...] = ()
        self._problem: str | None = None
        self._looks = 0  # without a report

    @property
    def ready(self) -> bool:
        """Whether the watchdog could stop it at once."""
        return self._problem == ""

    @property
    def problem(self) -> str:
        """Why it is not ready; "" if it is."""
        return "it did not answer in time" if self._problem is None else self._problem

    def arm(self, *data: bytes) -> None:
        """The motion begins. `data` replaces the contents of the messages."""
        self._data, self._looks, self.armed = data, 0, True
        self._owner.send(Arm(self._line.key, data))

    def disarm(self) -> None:
        """The motion has stopped."""
        self.armed = False
        self._owner.send(Disarm(self._line.key))

    def drop(self) -> None:
        """The watch has ended; nothing more is sent for it. May be called again."""
        self.armed = False
        self._owner.forget(self._line.key)

    def wait(self, seconds: float) -> None:
        """Wait until the watchdog is ready, or has reported a problem."""
        self._has_report.wait(seconds)

    # -- for the watchdog

    @property
    def lines(self) -> tuple[Line, ...]:
        """The lines for a new process."""
        line = self._line
        prepare = replace(line, armed=False)
        return (prepare, Arm(line.key, self._data)) if self.armed else (prepare,)

    def forgotten(self) -> None:
        """The process has ended, and the next one does not know this watch yet."""
        self._problem = say("its process has ended")
        self._has_report.clear()

    def answered(self, problem: str) -> str | None:
        """The process has reported, or never will. Return the problem before, None if there was no report."""
        before, self._problem = self._problem, problem
        self._looks = 0
        self._has_report.set()
        return before

    def look(self) -> bool:
        """Whether it was ready, and has not been reported since for too long. Call it once a second.

        Looks are counted, not seconds: after a pause of this program, what the process has reported
        meanwhile is still unread.
        """
        self._looks += 1
        return self.armed and self.ready and self._looks > MAX_LOOKS_WITHOUT_REPORT


class Watchdog:
    """A process that stops the watched motions when this process has ended. Thread-safe.

    If it cannot be started, or ends repeatedly, one warning is logged and everything else goes on.

    Args:
        on_sent: Called with a sentence, in a thread of the library, if the watchdog has stopped everything
            although this program is alive: the program did not run for a while.

    Attributes:
        pid: Id of the process; None if there is none.
    """

    def __init__(self, on_sent: Callable[[str], object] | None = None) -> None:
        self._listeners = [] if on_sent is None else [on_sent]
        self._keys = itertools.count(1)
        self._watches: dict[int, Watch] = {}
        self._lines: queue.SimpleQueue[Line | None] = queue.SimpleQueue()
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._begun_in = 0  # process id: in a forked child the watchdog does not work
        self._began = 0.0
        self._ends: list[float] = []
        self._closed = self._failed = False
        self._slow = False
        self._ended = threading.Event()
        self._threads: list[threading.Thread] = []

    def __enter__(self) -> Watchdog:
        self.start()
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    @property
    def pid(self) -> int | None:
        """Id of the process; None if there is none."""
        return None if self._process is None else self._process.pid

    def on_sent(self, callback: Callable[[str], object]) -> None:
        """Add a callback, used like the argument `on_sent`."""
        self._listeners.append(callback)

    def start(self) -> None:
        """Start the process in advance, so that the first motion need not wait for it. Returns at once."""
        with self._lock:
            if self._closed or self._failed or self._begun_in:
                return
            self._begun_in, self._began = os.getpid(), time.monotonic()
            try:
                self._process = _start()
            except (OSError, ValueError) as error:
                self._give_up(say("it cannot be started ({error})", error=error))
                return
            for name, work in (("write", self._write), ("read", self._read), ("look", self._look)):
                thread = threading.Thread(target=work, name=f"rosproto:watchdog {name}", daemon=True)
                thread.start()
                self._threads.append(thread)

    def watch(
        self,
        watched: WatchedNode,
        *,
        messages: Sequence[LastMessage] = (),
        calls: Sequence[LastCall] = (),
        requests: Sequence[LastRequest] = (),
        armed: bool = True,
    ) -> Watch:
        """Add a watch and wait until the watchdog could stop it at once: call this before the motion.

        Without a watchdog, or if it is late, one warning is logged, and the returned watch does nothing.

        Args:
            watched: Our node and its graph.
            messages: Published when this program has ended.
            calls: Called then.
            requests: Sent then.
            armed: It moves from now on; else call `Watch.arm`.
        """
        self.start()
        line = Prepare(next(self._keys), watched, tuple(messages), tuple(calls), tuple(requests), armed)
        watch = Watch(self, line)
        if self._failed or self._closed or self._begun_in != os.getpid():
            return watch
        self._watches[line.key] = watch
        self.send(line)
        try:
            watch.wait(max(READY_SECONDS, self._began + START_SECONDS - time.monotonic()))
        except BaseException:  # Ctrl-C: the watch is not returned, and nothing will move
            watch.drop()
            raise
        if not watch.ready and not self._failed and not self._slow:
            self._slow = True
            _log.warning("! the watchdog is not ready for this motion: %s; %s", watch.problem, _WITHOUT)
        return watch

    def send(self, line: Line) -> None:
        """Put a line into the queue of the pipe; takes no lock and never waits."""
        self._lines.put(line)

    def forget(self, key: int) -> None:
        """Remove a watch."""
        if self._watches.pop(key, None) is not None:
            self.send(Drop(key))

    def close(self) -> None:
        """End the process; armed watches are not stopped by it. Bounded; may be called again."""
        with self._lock:
            self._closed = True
        self._ended.set()
        for key in list(self._watches):
            self.forget(key)
        process = self._process
        if process is None or self._begun_in != os.getpid():
            return
        self._lines.put(None)
        try:
            process.wait(END_SECONDS)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        for thread in self._threads:
            if thread is not threading.current_thread():
                thread.join(END_SECONDS)
        _close_pipes(process)

    # -- the three threads ----------------------------------------------------------------------------------

    def _write(self) -> None:
        """Write lines as they come, and heartbeats while something moves."""
        while True:
            armed = any(watch.armed for watch in list(self._watches.values()))
            try:
                line = next_item(self._lines, HEARTBEAT_SECONDS if armed else None)
            except queue.Empty:
                line = Heartbeat()
            pipe = self._process.stdin if self._process is not None else None
            assert pipe is not None
            try:
                if line is None:
                    pipe.close()
                    return
                pipe.write(write_line(line))
                pipe.flush()
            except (OSError, ValueError):  # it has ended; the other thread notices it as well
                if line is None:
                    return

    def _look(self) -> None:
        """Notice that the process does not report any more; in a thread of its own, because the heartbeat
        must not wait for a log.
        """
        while not self._ended.wait(1.0):
            for watch in list(self._watches.values()):
                if watch.look():
                    self._report(
                        watch, say("it has not reported for {seconds} s", seconds=MAX_LOOKS_WITHOUT_REPORT)
                    )

    def _report(self, watch: Watch, problem: str) -> None:
        """Take a report, and log it when it is another one than before."""
        before = watch.answered(problem)
        if before is not None and bool(before) != bool(problem):
            if problem:
                text = "! the watchdog is no longer ready, and tries again: %s; %s"
                _log.warning(text, problem, _WITHOUT)
            else:
                _log.warning("= the watchdog is ready again")

    def _read(self) -> None:
        """Read replies until the process ends for good."""
        while True:
            process = self._process
            assert process is not None
            assert process.stdout is not None
            try:
                for data in process.stdout:
                    self._heard(read_line(data))
            except (RemoteProtocolError, OSError, ValueError) as error:
                _log.debug("! %s", error)
                process.kill()
            code = process.wait()
            if self._closed or not self._again(code):
                return

    def _heard(self, line: Line) -> None:
        if isinstance(line, Ready) and (watch := self._watches.get(line.key)) is not None:
            self._report(watch, line.problem)
        elif isinstance(line, Sent):
            text = say(
                "this program had not run for {seconds:.1f} s while something of it moved, when its watchdog "
                "stopped the robot",
                seconds=line.seconds,
            )
            _log.warning("! %s", text)
            for listener in list(self._listeners):
                try:
                    listener(text)
                except Exception:
                    _log.exception("a callback of the watchdog failed")

    def _again(self, code: int) -> bool:
        """The process has ended unexpectedly: start another one; False after too many attempts."""
        now = time.monotonic()
        self._ends = [*(end for end in self._ends if now - end < RESTART_WINDOW_SECONDS), now]
        how = say("killed by signal {code}", code=-code) if code < 0 else say("exit code {code}", code=code)
        for watch in list(self._watches.values()):
            watch.forgotten()
        with self._lock:
            if self._closed:
                return False
            if len(self._ends) > MAX_RESTARTS:
                self._give_up(say("it has ended {count} times ({how})", count=len(self._ends), how=how))
                return False
            try:
                old, self._process = self._process, _start()
            except (OSError, ValueError) as error:
                self._give_up(
                    say("it has ended ({how}) and cannot be started again ({error})", how=how, error=error)
                )
                return False
        if old is not None:
            _close_pipes(old)
        _log.warning("! the watchdog process has ended (%s), and was started again", how)
        for watch in list(self._watches.values()):
            for line in watch.lines:
                self.send(line)
        return True

    def _give_up(self, why: str) -> None:
        self._failed = True
        _log.warning("! there is no watchdog: %s; %s", why, _WITHOUT)
        for watch in list(self._watches.values()):
            watch.answered(why)


def _close_pipes(process: subprocess.Popen[bytes]) -> None:
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            try:
                pipe.close()
            except OSError:
                pass  # lines that it did not read


def _start() -> subprocess.Popen[bytes]:
    """Start the process, without a terminal, so that Ctrl-C does not reach it.

    Raises:
        OSError, ValueError: It cannot be started.
    """
    if getattr(sys, "frozen", False) or not sys.executable:
        raise OSError("this program has no Python interpreter of its own to start it with")
    # It has the import path of this program, in the same order.
    paths = os.pathsep.join(os.path.abspath(path) for path in sys.path)
    flags = 0
    if sys.platform == "win32":
        flags = subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.CREATE_NO_WINDOW
    return subprocess.Popen(
        [sys.executable, "-m", "rosproto.watchdog"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        cwd=os.path.abspath(os.sep),
        env={**os.environ, "PYTHONPATH": paths, "PYTHONSAFEPATH": "1"},
        start_new_session=True,
        creationflags=flags,
    )
