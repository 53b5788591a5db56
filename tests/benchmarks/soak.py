"""Hours in minutes: 4 nodes, 40 topics, services and parameters, faults all the time; nothing may grow.

    python -m tests.benchmarks soak [--seconds 600] [--seed 1]

The nodes run in a process of their own, each behind a proxy that cuts, resets, stalls, drips and refuses at random;
the master is restarted, subscribers and publishers come and go. Each row of the table is what the process holds at
that time. It fails (exit code 1) when threads, open files or memory at the end are above those after the first third
by more than the bounds printed, when anything hung, or when in the calm at the end not every topic works.
"""

from __future__ import annotations

import argparse
import gc
import json
import os
import random
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rosproto.errors import RosError
from rosproto.master import Master
from rosproto.node import Node
from tests.support.proxy import FaultProxy
from tests.support.ros import free_port

ROOT = Path(__file__).resolve().parents[2]
NODES, TOPICS = 4, 40
STRING = "std_msgs/String"
MAX_THREADS, MAX_FILES, MAX_MEMORY = 8, 12, 8 << 20  # growth from the first third to the end


def run(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="tests.benchmarks soak")
    parser.add_argument("--seconds", type=float, default=600)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args(arguments)
    code = "import sys; from tests.benchmarks.soak import Soak; sys.exit(Soak(float(sys.argv[1]), int(sys.argv[2])).run())"
    return subprocess.call([sys.executable, "-c", code, str(args.seconds), str(args.seed)], cwd=ROOT)


class Soak:
    """The process with the nodes."""

    def __init__(self, seconds: float, seed: int) -> None:
        self.seconds = seconds
        self.chance = random.Random(seed)
        self.port = free_port()
        self.master = Master(port=self.port)
        self.nodes: list[Node] = []
        self.proxies: list[FaultProxy] = []
        self.publishers: list[Any] = []
        self.subscribers: list[Any] = []
        self.clients: list[Any] = []
        self.heard = [0] * TOPICS
        self.calls = self.failed_calls = self.published = self.faults = self.master_restarts = (
            self.renewed
        ) = 0
        self.slowest_publish = self.slowest_call = 0.0
        self.problems: list[str] = []
        self.ended = threading.Event()

    # -- the graph ------------------------------------------------------------------------------------------

    def open(self) -> None:
        """Node n publishes every topic t with t % 4 == n, the next node subscribes it, through n's proxy."""
        for number in range(NODES):
            node = Node(f"/soak{number}", master_uri=self.master.uri, intraprocess=False)
            proxy = FaultProxy("127.0.0.1", node.tcpros_address[1])
            handler, arity, refusal = node._parts.slave.methods["requestTopic"]
            node._parts.slave.methods["requestTopic"] = (
                lambda *call, h=handler, p=proxy: [*h(*call)[:2], ["TCPROS", p.host, p.port]],  # type: ignore[misc]
                arity,
                refusal,
            )
            node.service_server(f"/echo{number}", "std_srvs/SetBool", lambda r: {"success": r.data})
            node.params.subscribe("/soaked", lambda key, value: None)
            self.nodes.append(node)
            self.proxies.append(proxy)
        for topic in range(TOPICS):
            self.publishers.append(self.publisher(topic))
            self.subscribers.append(self.subscriber(topic))
        for number in range(NODES):
            client = self.nodes[number].service_client(
                f"/echo{(number + 1) % NODES}", "std_srvs/SetBool", persistent=number % 2 == 0
            )
            self.clients.append(client)

    def publisher(self, topic: int) -> Any:
        return self.nodes[topic % NODES].publisher(f"/t{topic}", STRING, latch=topic % 5 == 0, queue_size=20)

    def subscriber(self, topic: int) -> Any:
        def heard(message: Any, topic: int = topic) -> None:
            self.heard[topic] += 1

        node = self.nodes[(topic + 1) % NODES]
        return node.subscriber(f"/t{topic}", STRING, heard, queue_size=20)

    # -- the load -------------------------------------------------------------------------------------------

    def publish(self, first: int) -> None:
        while not self.ended.wait(0.02):
            for topic in range(first, TOPICS, 2):
                began = time.monotonic()
                try:
                    self.publishers[topic].publish(data="x" * (10 + 3000 * (topic % 7 == 0)))
                    self.published += 1
                except RosError:
                    pass  # it is being renewed
                self.slowest_publish = max(self.slowest_publish, time.monotonic() - began)

    def call(self) -> None:
        number = 0
        while not self.ended.wait(0.02):
            number += 1
            began = time.monotonic()
            try:
                self.clients[number % NODES].call(data=True, timeout=2.0)
                self.nodes[number % NODES].params["/soaked"] = number
                self.calls += 1
            except (RosError, OSError):
                self.failed_calls += 1
            self.slowest_call = max(self.slowest_call, time.monotonic() - began)

    def fault(self) -> None:
        """One fault somewhere."""
        chance = self.chance
        proxy = chance.choice(self.proxies)
        faults: list[Callable[[], object]] = [
            proxy.cut, proxy.reset, proxy.resume, proxy.resume, lambda: proxy.cut_after(chance.randrange(20_000)),
            lambda: setattr(proxy, "byte_at_a_time", chance.random() < 0.2),
            lambda: setattr(proxy, "refusing", chance.random() < 0.3),
            proxy.stall, self.renew, self.renew,
        ]  # fmt: skip
        if chance.random() < 0.02:
            self.restart_master()
        chance.choice(faults)()
        self.faults += 1

    def renew(self) -> None:
        """A subscriber or a publisher is closed and made again."""
        topic = self.chance.randrange(TOPICS)
        try:
            if self.chance.random() < 0.5:
                self.subscribers[topic].close()
                self.subscribers[topic] = self.subscriber(topic)
            else:
                self.publishers[topic].close()
                self.publishers[topic] = self.publisher(topic)
            self.renewed += 1
        except (RosError, OSError) as error:
            self.problems.append(f"renewing topic {topic}: {error}")

    def restart_master(self) -> None:
        self.master.close()
        time.sleep(0.3)
        self.master = Master(port=self.port)
        self.master_restarts += 1

    def calm(self) -> None:
        """No more faults: everything must work."""
        for proxy in self.proxies:
            proxy.byte_at_a_time = proxy.refusing = False
            proxy.resume()
            proxy.reset()
        end = time.monotonic() + 30
        while any(p.connections != 1 for p in self.publishers) or any(
            s.connections != 1 for s in self.subscribers
        ):
            if time.monotonic() > end:
                self.problems.append(f"not connected again within 30 s: {self.disconnected()}")
                break
            time.sleep(0.05)
        before = list(self.heard)
        time.sleep(2.0)
        still = [f"/t{n}" for n in range(TOPICS) if self.heard[n] == before[n]]
        if still:
            self.problems.append(f"connected, but nothing arrives: {still}")

    def disconnected(self) -> list[str]:
        """How things stand with each topic that is not connected."""
        state = self.nodes[0].master.get_system_state()
        found = []
        for publisher, subscriber in zip(self.publishers, self.subscribers, strict=True):
            if publisher.connections != 1 or subscriber.connections != 1:
                topic = publisher.topic
                found.append(
                    f"{topic}: {publisher.connections} subscribers, {subscriber.connections} publishers,"
                    f" {subscriber._subscription.why_silent()}; at the master {state.publishers.get(topic)} ->"
                    f" {state.subscribers.get(topic)}; closed {publisher.closed}, {subscriber.closed}"
                )
        return found

    # -- the measure ----------------------------------------------------------------------------------------

    def measure(self) -> tuple[int, int, int]:
        """Threads, files, bytes."""
        gc.collect()
        files = len(os.listdir("/proc/self/fd")) if os.path.isdir("/proc/self/fd") else 0
        memory = 0
        if os.path.exists("/proc/self/statm"):
            memory = int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
        return threading.active_count(), files, memory

    def run(self) -> int:
        """The whole run; the exit code."""
        import logging

        logging.getLogger("rosproto").setLevel(logging.CRITICAL)
        began = time.monotonic()
        self.open()
        threads = [threading.Thread(target=self.publish, args=(n,), daemon=True) for n in range(2)]
        threads.append(threading.Thread(target=self.call, daemon=True))
        for thread in threads:
            thread.start()
        print(
            f"{'s':>6} {'threads':>8} {'files':>6} {'MB':>7} {'published':>10} {'heard':>9} {'calls':>7} {'faults':>7}"
        )
        step = max(5.0, self.seconds / 10)
        first: tuple[int, int, int] | None = None
        end = began + self.seconds
        while time.monotonic() < end:
            stop = min(end, time.monotonic() + step)
            while time.monotonic() < stop - 3:
                self.fault()
                time.sleep(self.chance.random() * 0.2)
            self.calm()  # comparable: everything connected, no proxy in the middle of something
            held = self.measure()
            if first is None and time.monotonic() - began >= self.seconds / 3:
                first = held
            print(
                f"{time.monotonic() - began:6.0f} {held[0]:8} {held[1]:6} {held[2] / 1e6:7.1f} {self.published:10}"
                f" {sum(self.heard):9} {self.calls:7} {self.faults:7}",
                flush=True,
            )
        self.ended.set()
        for thread in threads:
            thread.join(10)
            if thread.is_alive():
                self.problems.append("a publishing or calling thread hangs")
        return self.report(first or held, held)

    def report(self, first: tuple[int, int, int], last: tuple[int, int, int]) -> int:
        stats = [node.stats() for node in self.nodes]
        print(
            f"reconnects {sum(s.reconnects for s in stats)}, dropped {sum(s.dropped for s in stats)}, master restarts"
            f" {self.master_restarts}, renewed {self.renewed}, failed calls {self.failed_calls};"
            f" slowest publish {self.slowest_publish * 1e3:.0f} ms, slowest call {self.slowest_call:.1f} s"
        )
        for what, a, b, most in zip(
            ("threads", "files", "bytes"), first, last, (MAX_THREADS, MAX_FILES, MAX_MEMORY), strict=True
        ):
            good = b - a <= most
            print(f"  {'ok ' if good else 'NO '} {what}: {a} -> {b} (may grow by {most})")
            if not good:
                self.problems.append(f"{what} grew from {a} to {b}")
        if self.slowest_publish > 2.0:
            self.problems.append(f"publish() took {self.slowest_publish:.1f} s")
        closing = time.monotonic()
        for node in self.nodes:
            node.close()
        self.master.close()
        for proxy in self.proxies:
            proxy.close()
        print(
            f"closed in {time.monotonic() - closing:.1f} s: {json.dumps(threading.active_count())} threads left"
        )
        for problem in self.problems:
            print("  NO ", problem)
        return 1 if self.problems else 0
