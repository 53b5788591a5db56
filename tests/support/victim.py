"""A master and a node in a separate process, as the target of attacks that are measured from outside.

`Victim` starts the process; `Bystander` is a regular peer: a subscriber and service clients whose longest wait is
measured during an attack.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rosproto.node import Node
from tests.support.load import crowd
from tests.support.waiting import until

__all__ = ["Bystander", "Victim", "eventually"]

ROOT = Path(__file__).resolve().parents[2]
PATIENCE = 4.0  # seconds a regular peer may wait during attacks, with a processor for each process


def eventually(condition: Callable[[], object], timeout: float = 60.0, what: str = "it") -> None:
    """Wait until a condition holds."""
    until(condition, timeout, what)


class Victim:
    """The process, with short timeouts so that waiting attacks end soon.

    Its node /victim publishes /tick (std_msgs/String, 50 Hz), sends /in back on /out, answers /echo
    (std_srvs/SetBool) and follows the parameter /watched.

    Attributes:
        master, node: (host, port) of their XML-RPC servers.
        tcpros: (host, port) of the node's TCPROS server.
        master_uri: URI of the master.
        pid: Process id.
    """

    HANDSHAKE_SECONDS = 1.5

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-c", "from tests.support.victim import live; live()"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=ROOT,
        )
        assert self._process.stdout is not None
        told = json.loads(self._process.stdout.readline())
        self.pid = self._process.pid
        self.master_uri: str = told["master_uri"]
        self.node_uri: str = told["node_uri"]
        self.master = ("127.0.0.1", told["master"])
        self.node = ("127.0.0.1", told["node"])
        self.tcpros = ("127.0.0.1", told["tcpros"])

    def __enter__(self) -> Victim:
        return self

    def __exit__(self, *exc: object) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()  # the process ends with its input
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait(5)
            raise AssertionError("the victim did not end by itself") from None

    @property
    def alive(self) -> bool:
        return self._process.poll() is None

    def ask(self, question: str = "stats") -> dict[str, Any]:
        """Query the process over its pipes, one line each way."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(question + "\n")
        self._process.stdin.flush()
        answer: dict[str, Any] = json.loads(self._process.stdout.readline())
        return answer

    @property
    def memory(self) -> int:
        """Resident bytes; 0 if the system does not report them."""
        try:
            return int(Path(f"/proc/{self.pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
        except OSError:
            return 0

    def peak_since(self) -> Callable[[], int]:
        """Start measuring; return a function for the peak rise of memory in bytes."""
        before = self.memory
        try:
            Path(f"/proc/{self.pid}/clear_refs").write_text("5")
        except OSError:
            return lambda: max(0, self.memory - before)  # the system reports no peak: use the current rise

        def peak() -> int:
            for line in Path(f"/proc/{self.pid}/status").read_text().splitlines():
                if line.startswith("VmHWM:"):
                    return max(0, int(line.split()[1]) * 1024 - before)
            return 0

        return peak

    @property
    def threads(self) -> int:
        """Number of its threads, Python's and others."""
        return int(self.ask()["threads"])

    @property
    def files(self) -> int:
        """Number of its open files and sockets; 0 if the system does not report it."""
        try:
            return len(os.listdir(f"/proc/{self.pid}/fd"))
        except OSError:
            return 0


def live() -> None:
    """Run the victim's process until its input ends."""
    from rosproto.master import Master
    from rosproto.protocol.wire_limits import Limits

    limits = Limits(handshake_seconds=Victim.HANDSHAKE_SECONDS, idle_seconds=3.0)
    with (
        Master(limits=limits) as master,
        Node("/victim", master_uri=master.uri, limits=limits, rosout=True, allow_shutdown=False) as node,
    ):
        tick = node.publisher("/tick", "std_msgs/String", queue_size=10)
        out = node.publisher("/out", "std_msgs/String", queue_size=100)
        node.subscriber("/in", "std_msgs/String", out.publish, queue_size=100)
        node.service_server("/echo", "std_srvs/SetBool", lambda r: {"success": r.data, "message": "echo"})
        watched: list[Any] = []
        node.params.subscribe("/watched", lambda key, value: watched.append(value))
        print(
            json.dumps(
                {
                    "master_uri": master.uri,
                    "node_uri": node.uri,
                    "master": master.port,
                    "node": node._parts.context.listening.endpoints.slave.port,
                    "tcpros": node.tcpros_address[1],
                }
            ),
            flush=True,
        )
        threading.Thread(target=_tick, args=(node, tick), name="ticker", daemon=True).start()
        for line in sys.stdin:
            if line.startswith("stats"):
                names = [thread.name for thread in threading.enumerate()]
                answer: dict[str, Any] = {
                    "threads": len(names),
                    "names": names,
                    "watched": watched[-5:],
                    "closed": node.closed,
                    "tcpros": node._parts.context.listening.endpoints.tcpros.connections,
                    "slave": node._parts.context.listening.endpoints.slave._server.connections,
                    "master": master.stats()["connections"],
                    "links": {
                        uri: link.state.value
                        for uri, link in node._parts.topics.subscription("/in").links.items()
                    },
                }
                print(json.dumps(answer), flush=True)


def _tick(node: Node, publisher: Any) -> None:
    while not node.closed:
        publisher.publish(data="tick")
        time.sleep(0.02)


class Bystander:
    """A regular peer: subscribes /tick, calls /echo over a persistent link and over new ones."""

    def __init__(self, victim: Victim) -> None:
        self._node = Node(f"/bystander{os.getpid()}", master_uri=victim.master_uri, rosout=False)
        self._ticks = self._node.subscriber("/tick", "std_msgs/String", queue_size=1)
        self._kept = self._node.service_client("/echo", "std_srvs/SetBool", persistent=True)
        self._fresh = self._node.service_client("/echo", "std_srvs/SetBool")
        self._ticks.wait_for_connection(60)

    def __enter__(self) -> Bystander:
        return self

    def __exit__(self, *exc: object) -> None:
        self._node.close()

    @property
    def node(self) -> Node:
        return self._node

    def check(self) -> float:
        """Run all checks once; return the longest wait in seconds. Raises if a check fails."""
        waits = []
        patience = PATIENCE * crowd()
        for step in (
            lambda: self._ticks.next(patience),
            lambda: self._kept.call(data=True, timeout=patience),
            lambda: self._fresh.call(data=True, timeout=patience),
            lambda: self._node.master.lookup_service("/echo", timeout=patience),
        ):
            began = time.monotonic()
            step()
            waits.append(time.monotonic() - began)
        return max(waits)

    @contextmanager
    def goes_on(self) -> Iterator[None]:
        """Run the checks repeatedly in another thread during the block, and once afterwards."""
        ended = threading.Event()
        problems: list[BaseException] = []
        rounds = [0]

        def watch() -> None:
            while not ended.is_set():
                try:
                    self.check()
                    rounds[0] += 1
                except BaseException as error:
                    problems.append(error)
                    return
                ended.wait(0.05)

        links = self._ticks.stats()[0].reconnects
        watcher = threading.Thread(target=watch, name="bystander", daemon=True)
        watcher.start()
        try:
            yield
        finally:
            ended.set()
            watcher.join(5 * PATIENCE * crowd())
        if problems:
            raise AssertionError(
                f"after {rounds[0]} good rounds an innocent peer got: {problems[0]!r}"
            ) from (problems[0])
        self.check()
        assert self._ticks.stats()[0].reconnects == links, "the innocent subscriber lost its connection"
