"""A Python process elsewhere (another network namespace) that executes a test's commands, line by line.

The test's side is `Remote`; the process runs `serve`. Its definitions stay until it ends, and it ends with its input,
also when a test is killed.
"""

from __future__ import annotations

import json
import os
import queue
import socket
import subprocess
import sys
import tempfile
import threading
import time
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

__all__ = ["Remote", "RemoteFailed", "serve"]

ROOT = Path(__file__).resolve().parents[2]


class RemoteFailed(AssertionError):
    """The remote code raised; the text is its traceback."""


class Remote:
    """The process, seen from the test.

    Args:
        prefix: Command that runs the process where it belongs: `["unshare", "--net"]`.
    """

    def __init__(self, prefix: Sequence[str] = (), environment: dict[str, str] | None = None) -> None:
        self._errors = tempfile.TemporaryFile("w+")  # noqa: SIM115 (closed by close)
        self.process = subprocess.Popen(
            [*prefix, sys.executable, "-u", "-c", "from tests.support.remote import serve; serve()"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            text=True,
            cwd=ROOT,
            env=None if environment is None else {**os.environ, **environment},
        )
        self._answers: queue.Queue[str] = queue.Queue()
        threading.Thread(target=self._read, name="test:remote", daemon=True).start()

    def __enter__(self) -> Remote:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    def do(self, code: str, timeout: float = 60.0) -> None:
        """Run statements."""
        self._exchange({"do": code}, timeout)

    def ask(self, expression: str, timeout: float = 60.0) -> Any:
        """The value of an expression, through JSON."""
        return self._exchange({"ask": expression}, timeout)

    def eventually(self, expression: str, timeout: float = 60.0) -> float:
        """Wait, over there, until an expression is true and does not raise; `time.monotonic()` of that moment."""
        return float(self._exchange({"eventually": expression, "timeout": timeout}, timeout + 10.0))

    @property
    def errors(self) -> str:
        """Return its output on stderr."""
        self._errors.seek(0)
        return self._errors.read()

    def kill(self) -> None:
        """Kill the process; the kernel closes its sockets."""
        self.process.kill()
        self.process.wait(10)

    def close(self) -> None:
        """Let it end."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        try:
            self.process.stdin.close()
        except BrokenPipeError:
            pass  # it has ended
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.kill()
        self.process.stdout.close()
        self._errors.close()

    def _exchange(self, order: dict[str, Any], timeout: float) -> Any:
        assert self.process.stdin is not None
        try:
            self.process.stdin.write(json.dumps(order) + "\n")
            self.process.stdin.flush()
            line = self._answers.get(timeout=timeout)
        except (queue.Empty, BrokenPipeError):
            raise RemoteFailed(f"{order} was not done within {timeout} s; stderr:\n{self.errors}") from None
        if not line:
            raise RemoteFailed(f"the process ended over {order}; stderr:\n{self.errors}")
        answer = json.loads(line)
        if "error" in answer:
            raise RemoteFailed(f"{order}:\n{answer['error']}")
        return answer["value"]

    def _read(self) -> None:
        assert self.process.stdout is not None
        try:
            for line in self.process.stdout:
                self._answers.put(line)
        except ValueError:
            pass  # closed
        self._answers.put("")


# -- remote side -------------------------------------------------------------------------------------------


class Heard:
    """Collects messages `"number sent-at"` of a std_msgs/String topic, as `Ticker` sends them."""

    def __init__(self, node: Any, topic: str, **options: Any) -> None:
        self.messages: list[tuple[float, float, int]] = []  # received, sent, number
        self.subscriber = node.subscriber(topic, "std_msgs/String", self._heard, **options)

    def _heard(self, message: Any) -> None:
        number, sent = message.data.split()[:2]
        self.messages.append((time.monotonic(), float(sent), int(number)))

    def since(self, moment: float) -> list[tuple[float, float, int]]:
        """Those received after a moment."""
        return [entry for entry in list(self.messages) if entry[0] > moment]

    def latest_after(self, moment: float) -> float:
        """The greatest delay in seconds of those received after a moment."""
        return max((received - sent for received, sent, _ in self.since(moment)), default=0.0)

    def first_sent_after(self, moment: float) -> float | None:
        """When the first message came that was sent after a moment."""
        return next((received for received, sent, _ in list(self.messages) if sent > moment), None)


class Ticker:
    """Publishes `"number sent-at padding"` at a steady rate until told to stop; notes how long publish() took."""

    def __init__(self, node: Any, topic: str, rate: float, padding: int = 0, **options: Any) -> None:
        self.publisher = node.publisher(topic, "std_msgs/String", **options)
        self.longest = 0.0
        self.count = 0
        self._padding = "x" * padding
        self._pause = 1.0 / rate
        self.stop = threading.Event()
        threading.Thread(target=self._run, name="ticker", daemon=True).start()

    def _run(self) -> None:
        while not self.stop.wait(self._pause):
            began = time.monotonic()
            self.publisher.publish(data=f"{self.count} {began!r} {self._padding}")
            self.longest = max(self.longest, time.monotonic() - began)
            self.count += 1


def reachable(host: str, port: int) -> bool:
    """Whether connections to this address are accepted."""
    try:
        socket.create_connection((host, port), 1.0).close()
    except OSError:
        return False
    return True


def _await(condition: Callable[[], object], timeout: float) -> float:
    end = time.monotonic() + timeout
    while True:
        problem: Exception | None = None
        try:
            if condition():
                return time.monotonic()
        except Exception as error:
            problem = error  # a master that does not know the name yet, or does not answer
        if time.monotonic() > end:
            raise TimeoutError(f"not true within {timeout} s") from problem
        time.sleep(0.005)


def serve() -> None:
    """Execute commands from stdin, answer on stdout, end with stdin."""
    out = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)  # what is printed by mistake goes to stderr
    world: dict[str, Any] = {"time": time, "Heard": Heard, "Ticker": Ticker, "reachable": reachable}
    for line in sys.stdin:
        order = json.loads(line)
        value: object = None
        try:
            if "do" in order:
                exec(order["do"], world)
            elif "ask" in order:
                value = eval(order["ask"], world)
            else:
                value = _await(lambda code=order["eventually"]: eval(code, world), order["timeout"])  # type: ignore[misc]
        except BaseException:
            out.write(json.dumps({"error": traceback.format_exc()}) + "\n")
        else:
            out.write(json.dumps({"value": value}, default=repr) + "\n")
    os._exit(0)  # as when killed: without shutdown of nodes
