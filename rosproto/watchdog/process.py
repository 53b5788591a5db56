"""The watchdog process: prepares the messages it is given, and sends them when its parent has ended.

A watch that was prepared may not stay ready: the robot restarts, or another node takes the name of this one
(the master then shuts ours down, and the robot drops its links). So it is looked at all the time, reported to
the parent, and prepared anew, with another name if necessary.

It ends with its parent: when the pipe ends, or when its parent process changes (a forked child of the parent
may hold the pipe open). It ignores the signals by which terminals and supervisors end programs: its parent
may need a while to shut down, and is watched until then.
"""

from __future__ import annotations

import math
import os
import queue
import signal
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, BinaryIO

from rosproto.codec import decode, define, service_class
from rosproto.errors import RosError, RosTimeout
from rosproto.json_text import JsonReader
from rosproto.node import Node, PreparedCall
from rosproto.protocol.wire_limits import Limits
from rosproto.transport import Deadline, HttpClient
from rosproto.transport.uri import same_uri
from rosproto.watchdog.protocol import (
    READY_SECONDS,
    ROUNDS,
    Arm,
    Disarm,
    Drop,
    LastCall,
    LastMessage,
    LastRequest,
    Line,
    Prepare,
    Ready,
    Sent,
    WatchedNode,
    WatchTable,
    read_line,
    watchdog_name,
    write_line,
)

CONNECT_SECONDS = 1.0  # to connect to a subscriber that the master knows
CALL_SECONDS = 2.0
KEPT_SECONDS = 0.3  # for an answer on a connection that was kept: it may be dead
RETRY_SECONDS = 10.0  # after the parent's end, for a robot that cannot be reached
RETRY_INTERVAL = 0.5  # seconds between these attempts
PARENT_CHECK_SECONDS = 0.25  # between two checks of the parent
LATE_SECONDS = 0.2  # if woken later than this, this process was stopped itself
REPAIR_SECONDS = 1.0  # between two attempts to make a watch ready again
_read_json = JsonReader(max_values=10_000, nesting=24).one


class _LastCall:
    """A service that is called until a call succeeds after the `seconds` of its `LastCall`.

    The request is encoded and the connection opened in advance, so that sending needs no wait. If the
    provider has closed the connection meanwhile, the service is called in the usual way.
    """

    def __init__(self, node: Node, call: LastCall) -> None:
        kind = service_class(call.type, node.definitions.library_for(call.type, "srv"))
        self._service = call.service
        self._client = node.service_client(call.service, kind)
        self._request = decode(kind._request_class, call.data)
        self._prepared: PreparedCall | None = self._client.prepare(self._request, CONNECT_SECONDS)
        self._busy = threading.Lock()
        self._seconds, self._until = call.seconds, 0.0
        self.done = False

    @property
    def problem(self) -> str:
        """Why it could not be sent at once; "" if it could, or was."""
        prepared = self._prepared
        return "" if prepared is None or prepared.usable else f"{self._service}: the connection has ended"

    def send(self) -> None:
        """Call it; a thread waits for the response."""
        if self.done or not self._busy.acquire(blocking=False):
            return
        self._until = self._until or time.monotonic() + self._seconds
        prepared, self._prepared = self._prepared, None
        sent = prepared if prepared is not None and prepared.send() else None
        work = partial(self._finish, sent)
        threading.Thread(target=work, name="rosproto:last call", daemon=True).start()

    def _finish(self, sent: PreparedCall | None) -> None:
        try:
            if sent is not None:
                sent.answer(CALL_SECONDS)
            else:
                self._client.call(self._request, timeout=CALL_SECONDS)
            self.done = time.monotonic() >= self._until
        except RosError:
            pass  # called again in the next round
        finally:
            self._busy.release()

    def close(self) -> None:
        self._client.close()


class _LastMessage:
    """A topic and the message published on it at the end."""

    def __init__(self, node: Node, message: LastMessage) -> None:
        self._node = node
        self._class = define(message.type, message.text)
        # What was sent is delivered although this process is killed: a zero or a cancel may be late.
        self._publisher = node.publisher(message.topic, self._class, queue_size=ROUNDS)
        self.data = message.data
        self.done = False
        self._awaited = False  # whether somebody subscribes

    @property
    def problem(self) -> str:
        """Why it would not arrive; "" if it would, or if nobody subscribed."""
        if self._node.closed:
            return f"the watchdog's node was closed: {self._node.close_reason}"
        if not self._awaited or self._publisher.connections:
            return ""
        return f"{self._publisher.topic}: the robot has closed the connection"

    def expect(self, subscribers: Mapping[str, Sequence[str]]) -> None:
        """Note whether the master knows a subscriber, which is to be connected."""
        self._awaited = bool(subscribers.get(self._publisher.topic))

    def wait(self) -> None:
        """Wait until it is connected, if that is expected.

        Raises:
            RosTimeout: It is not.
        """
        if self._awaited:
            self._publisher.wait_for_connection(CONNECT_SECONDS)

    def send(self) -> None:
        message = decode(self._class, self.data)
        if self._class._has_header:
            message.header.stamp = self._node.clock.now()
        self._publisher.publish(message)
        self.done = self._publisher.connections > 0

    def close(self, wait: float = 0.0) -> None:
        """Close the topic; `wait` is the time for the robot to read the message, in seconds."""
        self._publisher.close(wait)


class RequestSender:
    """A request over HTTP; each round sends it, one after the other, in a thread.

    Attributes:
        problem: Why it cannot be sent; always "", because it is not made then.
        done: Whether the server has accepted it after its `seconds`, or does something else.
    """

    def __init__(self, request: LastRequest) -> None:
        self._request = request
        headers = {"Content-Type": "application/json", **request.headers}
        self._client = HttpClient(request.uri, limits=Limits(), headers=headers)
        self._turn = threading.Lock()
        self._until = 0.0
        self.problem, self.done = "", False
        self._post(request.ask_path, "{}", CONNECT_SECONDS)

    def _post(self, path: str, body: str, seconds: float) -> dict[str, Any]:
        response = self._client.post(path, body.encode(), Deadline(seconds), path=path)
        answer = _read_json(response.body)
        if response.status != 200 or not isinstance(answer, dict):
            raise ValueError(f"{path}: not answered (HTTP {response.status})")
        return answer

    def send(self) -> None:
        """Send it; a thread waits for the answer."""
        self._until = self._until or time.monotonic() + self._request.seconds
        threading.Thread(target=self.perform, name="rosproto:last request", daemon=True).start()

    def perform(self) -> None:
        """Send it unless that is superfluous, and wait for the answer."""
        with self._turn:
            for seconds in (KEPT_SECONDS, CALL_SECONDS):  # the second time by a new connection
                if self.done and self._request.only_if:
                    return
                try:
                    if self._is_other(seconds):
                        self.done = True
                    else:
                        answer = self._post(self._request.path, self._request.body, seconds)
                        self.done = answer.get("ok") is True and time.monotonic() >= self._until
                    return
                except RosTimeout:
                    pass
                except (RosError, ValueError):
                    return  # sent again in the next round

    def _is_other(self, seconds: float) -> bool:
        """Whether the server is known to do something else than this request is about."""
        if not self._request.only_if:
            return False
        key, wanted = self._request.only_if
        try:
            told = self._post(self._request.ask_path, "{}", seconds).get("body")
        except (RosError, ValueError) as error:
            if isinstance(error, RosTimeout) and seconds < CALL_SECONDS:
                raise
            return False  # in doubt it is stopped
        return isinstance(told, dict) and str(told.get(key, wanted)) != wanted

    def close(self) -> None:
        self._client.close()


@dataclass
class _Watch:
    """A watch that was prepared, as far as that succeeded.

    Attributes:
        line: What was asked for.
        parts: What is sent; messages first.
        complete: Whether all parts were made, and know whether a connection is expected. Then they tell
            whether it is ready; else it stays as `failed` says.
        failed: Why it could not be prepared.
        reported: The problem that was reported last.
        repair_at: When the next attempt to prepare it may begin; infinite during one.
    """

    line: Prepare
    parts: list[_LastMessage | _LastCall | RequestSender]
    complete: bool = False
    failed: str = ""
    reported: str = ""
    repair_at: float = 0.0

    @property
    def problem(self) -> str:
        """Why it is not ready; "" if it is."""
        problems = [each.problem for each in self.parts if each.problem]
        return problems[0] if problems else "" if self.complete else self.failed

    def close(self) -> None:
        """Close the parts in a thread: the master may be slow."""
        for each in self.parts:
            threading.Thread(target=each.close, name="rosproto:drop", daemon=True).start()


class WatchdogProcess:
    """Carries out the lines from the pipe until it ends.

    Args:
        lines: The pipe from the parent.
        answers: The pipe to the parent.
        parent: Returns the parent's process id; None where that does not show its end.
    """

    def __init__(self, lines: BinaryIO, answers: BinaryIO, parent: Callable[[], int] | None) -> None:
        self._lines, self._answers = lines, answers
        self._parent = parent
        self._born_of = parent() if parent is not None else 0
        # Not SimpleQueue: if its time-out passes within `get`, CPython before 3.13 waits for ever.
        self._inbox: queue.Queue[Line | Callable[[], None] | None] = queue.Queue()
        self._table = WatchTable(time.monotonic())
        self._nodes: dict[tuple[str, str], Node] = {}
        self._taken: Counter[tuple[str, str]] = Counter()  # names of ours that other nodes have taken
        self._opening = threading.Lock()
        self._ready: dict[int, _Watch] = {}
        self._talks = False  # whether the program has sent a line since the last report
        self._report_at = 0.0
        self._preparing: dict[int, Arm | None] = {}  # key -> the Arm to apply when it is prepared
        self._dropped: set[int] = set()

    def run(self) -> None:
        """Watch until the parent has ended, then act."""
        threading.Thread(target=self._read, name="rosproto:pipe", daemon=True).start()
        while not self._table.ended or self._preparing or self._table.wait(time.monotonic()) is not None:
            self._step()
            self._send(time.monotonic())
            self._look(time.monotonic())
        self._finish()

    def _read(self) -> None:
        for line in self._lines:
            self._inbox.put(read_line(line))
        self._inbox.put(None)

    def _step(self) -> None:
        """Handle one line, or notice that none came."""
        wait, before = self._table.wait(time.monotonic()), time.monotonic()
        seconds = PARENT_CHECK_SECONDS if wait is None else min(wait, PARENT_CHECK_SECONDS)
        try:
            self._take(self._inbox.get(timeout=seconds))
            return
        except queue.Empty:
            now = time.monotonic()
        if self._table.ended:
            return
        if now - before > seconds + LATE_SECONDS:
            self._table.heard(now)  # the parent may not have been silent
        elif self._parent is not None and self._parent() != self._born_of:
            self._table.end(now)
        elif silent := self._table.silent(now):
            self._send(now)
            self._answer(Sent(self._table.armed, silent))

    def _take(self, line: Line | Callable[[], None] | None) -> None:
        now = time.monotonic()
        if line is None:
            self._table.end(now)
        elif callable(line):
            line()
        else:
            self._table.heard(now)
            self._talks = True
            self._obey(line)

    def _look(self, now: float) -> None:
        """Report whether the watches are ready: when that changes, and again every second while the program
        talks (the pipe of a stopped one would fill up). Prepare again what is not ready.
        """
        tell = self._talks and now >= self._report_at
        if tell:
            self._talks, self._report_at = False, now + READY_SECONDS
        for key, watch in self._ready.items():
            problem = watch.problem
            if problem and now >= watch.repair_at:
                watch.repair_at = math.inf
                work = partial(self._prepare, watch.line, repair=True)
                threading.Thread(target=work, name="rosproto:prepare", daemon=True).start()
            if tell or problem != watch.reported:
                watch.reported = problem
                self._answer(Ready(key, problem))

    def _obey(self, line: Line) -> None:
        if isinstance(line, Prepare):
            if line.key not in self._ready and line.key not in self._preparing:
                self._preparing[line.key] = Arm(line.key) if line.armed else None
                work = partial(self._prepare, line)
                threading.Thread(target=work, name="rosproto:prepare", daemon=True).start()
        elif isinstance(line, Arm) and line.key in self._ready:
            for message, data in zip(self._ready[line.key].parts, line.data, strict=False):
                if isinstance(message, _LastMessage):
                    message.data = data
            self._table.arm(line.key)
        elif isinstance(line, (Arm, Disarm)) and line.key in self._preparing:
            self._preparing[line.key] = line if isinstance(line, Arm) else None
        elif isinstance(line, Disarm):
            self._table.disarm(line.key)
        elif isinstance(line, Drop):
            self._drop(line.key)

    def _prepare(self, line: Prepare, *, repair: bool = False) -> None:
        """Run in a thread: the master may be slow, and other watches go on meanwhile."""
        watch = _Watch(line, [])
        try:
            node = partial(self._node, line.watched, repair=repair)
            if not line.requests:
                node()  # requests need none
            for message in line.messages:
                watch.parts.append(_LastMessage(node(), message))
            for call in line.calls:
                watch.parts.append(_LastCall(node(), call))
            watch.parts += map(RequestSender, line.requests)
            messages = [each for each in watch.parts if isinstance(each, _LastMessage)]
            if messages:
                subscribers = node().master.get_system_state(timeout=CONNECT_SECONDS).subscribers
                for each in messages:
                    each.expect(subscribers)
            watch.complete = True
            for each in messages:
                each.wait()
        except Exception as error:
            watch.failed = str(error) or type(error).__name__
        self._inbox.put(partial(self._repaired if repair else self._prepared, watch))

    def _prepared(self, watch: _Watch) -> None:
        key = watch.line.key
        self._ready[key] = watch
        watch.repair_at, watch.reported = time.monotonic() + REPAIR_SECONDS, watch.failed
        armed = self._preparing.pop(key)
        if key in self._dropped:
            self._dropped.discard(key)
            self._drop(key)
            return
        if armed is not None:
            self._obey(armed)
        self._answer(Ready(key, watch.failed))

    def _repaired(self, watch: _Watch) -> None:
        """Replace a watch by one that was prepared later."""
        key = watch.line.key
        before = self._ready.get(key)
        if before is None or not watch.complete:
            watch.close()  # it was dropped meanwhile; or the one before is no worse
            if before is not None:
                before.failed, before.repair_at = watch.failed, time.monotonic() + REPAIR_SECONDS
            return
        for old, new in zip(before.parts, watch.parts, strict=False):
            if isinstance(old, _LastMessage) and isinstance(new, _LastMessage):
                new.data = old.data
        watch.reported, watch.repair_at = before.reported, time.monotonic() + REPAIR_SECONDS
        self._ready[key] = watch
        before.close()
        if key in self._table.armed:
            self._table.arm(key)  # due at once if the program has ended

    def _drop(self, key: int) -> None:
        self._table.disarm(key)
        if key in self._preparing:
            self._dropped.add(key)
        elif (watch := self._ready.pop(key, None)) is not None:
            watch.close()

    def _node(self, watched: WatchedNode, *, repair: bool) -> Node:
        """Our node in the graph of a watched node; another one, with another name, if its name was taken."""
        with self._opening:
            key = watched.master_uri, watched.node
            node = self._nodes.get(key)
            if node is not None and (node.closed or (repair and _lost_its_name(node))):
                self._taken[key] += 1
                threading.Thread(target=node.close, name="rosproto:drop", daemon=True).start()
                node = None
            if node is None:
                node = self._nodes[key] = Node(
                    watchdog_name(watched.node, self._taken[key]),
                    master_uri=watched.master_uri,
                    host=watched.host,
                    resolve=watched.resolve,
                    msg_path=watched.msg_path,
                    rosout=False,
                    follow_clock=False,
                    allow_shutdown=False,
                )
            return node

    def _send(self, now: float) -> None:
        for key in self._table.due(now):
            for each in self._ready[key].parts:
                _try(each)

    def _answer(self, line: Line) -> None:
        try:
            self._answers.write(write_line(line))
            self._answers.flush()
        except OSError:
            pass  # the parent no longer reads: the end of the other pipe follows

    def _finish(self) -> None:
        """After all rounds: retry for a while what could not be delivered."""
        until = time.monotonic() + RETRY_SECONDS
        while time.monotonic() < until and any(not each.done for each in self._acting()):
            self._look(time.monotonic())
            try:
                line = self._inbox.get(timeout=RETRY_INTERVAL)
                if callable(line):
                    line()
            except queue.Empty:
                pass
            for each in self._acting():
                if not each.done:
                    _try(each)
        for each in self._acting():
            if isinstance(each, _LastMessage):
                each.close(wait=0.5)
        for node in list(self._nodes.values()):
            node.close()

    def _acting(self) -> list[_LastMessage | _LastCall | RequestSender]:
        return [each for key in self._table.armed for each in self._ready[key].parts]


def _lost_its_name(node: Node) -> bool:
    """Whether the master has another node under its name."""
    try:
        return not same_uri(node.master.lookup_node(node.name, timeout=CONNECT_SECONDS), node.uri)
    except RosError:
        return False  # not registered yet, or the master is away


def _try(each: _LastMessage | _LastCall | RequestSender) -> None:
    """Send it; if it fails, the others are still sent."""
    try:
        each.send()
    except Exception:
        each.done = False


def main() -> None:
    """Run between the pipes of stdin and stdout."""
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK", "SIGQUIT"):
        if (number := getattr(signal, name, None)) is not None:
            signal.signal(number, signal.SIG_IGN)
    # On Windows the parent's id stays after it has ended, and the end of the pipe shows it in any case.
    parent = os.getppid if os.name == "posix" else None
    WatchdogProcess(sys.stdin.buffer, sys.stdout.buffer, parent).run()
