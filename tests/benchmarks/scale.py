"""Many subscribers, many topics, many connections, beside rospy: rate, latency, threads and memory per link.

    python -m tests.benchmarks scale [--subscribers 50] [--topics 200] [--connections 1000] [--seconds 3]
                                     [--gone 400] [--nodes 200] [--registrations 10000] [--simulators 20]
                                     [--only subscribers,topics,connections,gone,nodes,registrations,simulators]

* N processes' worth of subscribers of one topic: one publisher, N plain sockets that read and count; the same
  reader for both libraries, so only the publisher differs. Messages per second, CPU per message, latency of one
  message at 20 Hz to the last of the readers.
* M topics on one node: one publisher node, one subscriber node, each topic at 10 Hz.
* K idle connections to one publisher: memory and threads per connection, and whether the next subscriber is served.
* One subscriber of G topics whose publishers are registered and gone: processor time and threads, after a while.
* N idle nodes of ours in one process, a node beside R registrations (and one of rospy), and S simulated chassis in one
  process: processor time, threads and files.
"""

from __future__ import annotations

import argparse
import os
import select
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from rosproto.node.graph.slave_client import NodeClient
from rosproto.protocol.handshake import encode_header, subscriber_header
from rosproto.transport import XmlRpcClient
from tests.benchmarks.transport import Bench, _answer, _last
from tests.support.attacks import read_header

TWIST_MD5 = "9f195f881246fdfa2798d1d3eebca84a"
ROOT = Path(__file__).resolve().parents[2]
FRAME = 52  # bytes of a Twist with its length


def run(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="tests.benchmarks scale")
    parser.add_argument("--subscribers", type=int, default=50)
    parser.add_argument("--topics", type=int, default=200)
    parser.add_argument("--connections", type=int, default=1000)
    parser.add_argument("--seconds", type=float, default=3.0)
    parser.add_argument("--gone", type=int, default=400)
    parser.add_argument("--nodes", type=int, default=200)
    parser.add_argument("--registrations", type=int, default=10_000)
    parser.add_argument("--simulators", type=int, default=20)
    parser.add_argument(
        "--settle", type=float, default=60.0, help="seconds before idle processes are measured"
    )
    parser.add_argument(
        "--only", default="subscribers,topics,connections,gone,nodes,registrations,simulators"
    )
    args = parser.parse_args(arguments)
    only = args.only.split(",")
    with tempfile.TemporaryDirectory() as folder, Bench(Path(folder), 1, args.seconds) as bench:
        if "subscribers" in only:
            many_subscribers(bench, args.subscribers, args.seconds)
        if "topics" in only:
            many_topics(bench, args.topics, args.seconds)
        if "connections" in only:
            many_connections(bench, args.connections)
        if "gone" in only:
            gone_publishers(bench, args.gone, args.settle, args.seconds)
        if "nodes" in only:
            many_idle(bench, NODES, args.nodes, "nodes", args.seconds)
        if "registrations" in only:
            many_registrations(bench, args.registrations, args.seconds)
        if "simulators" in only:
            many_idle(bench, SIMULATORS, args.simulators, "simulated chassis", args.seconds)


def subscribe(bench: Bench, node: str, count: int) -> list[socket.socket]:
    """So many raw subscribers of /bench at the node of that name."""
    uri = registered(bench, node)
    sockets = []
    for number in range(count):
        with NodeClient(uri, "/scale") as publisher:
            _, host, port = publisher.request_topic("/bench")
        sock = socket.create_connection((host, port), 20)
        header = subscriber_header(
            topic="/bench",
            type_name="geometry_msgs/Twist",
            md5sum=TWIST_MD5,
            callerid=f"/raw{number}",
            tcp_nodelay=True,
        )
        sock.sendall(encode_header(header))
        read_header(sock)
        sockets.append(sock)
    return sockets


def registered(bench: Bench, node: str) -> str:
    """URI of the node of that name, as soon as it publishes /bench."""
    end = time.monotonic() + 20
    with XmlRpcClient(bench.uri) as master:
        while time.monotonic() < end:
            state = master.call("getSystemState", "/scale")
            if any(topic == "/bench" and node in nodes for topic, nodes in state[2][0]):
                return str(master.call("lookupNode", "/scale", node)[2])
            time.sleep(0.05)
    raise RuntimeError(f"{node} does not register")


def process_facts(pid: int) -> tuple[int, int, float]:
    """Bytes, threads, CPU seconds."""
    memory = int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * 4096
    threads = len(os.listdir(f"/proc/{pid}/task"))
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return memory, threads, (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def drain(sockets: list[socket.socket], seconds: float, quiet: float = 1.0) -> tuple[int, float]:
    """Read from all until nothing has come for `quiet` seconds: (bytes, seconds from first to last)."""
    poll = select.epoll()
    by_number = {sock.fileno(): sock for sock in sockets}
    for sock in sockets:
        sock.setblocking(False)
        poll.register(sock, select.EPOLLIN)
    total, first, last = 0, 0.0, time.monotonic() + 20
    while time.monotonic() < last + quiet:
        for number, _ in poll.poll(0.1):
            try:
                data = by_number[number].recv(1 << 20)
            except BlockingIOError:
                continue
            if not data:
                poll.unregister(number)
            total += len(data)
            last = time.monotonic()
            first = first or last
        if first and time.monotonic() - first > seconds + 10:
            break
    return total, max(1e-9, last - first)


def many_subscribers(bench: Bench, count: int, seconds: float) -> None:
    print(f"\n{count} subscribers of one topic (Twist)")
    for library in ("rospy", "ours"):
        bench.renew_master()
        process = bench.start(
            library, "publish_fast", subscribers=count, seconds=seconds, chunk=10, queue_size=1000
        )
        sockets: list[socket.socket] = []
        try:
            memory, threads, _ = _settled(process)
            sockets = subscribe(bench, f"/publish_fast_{process.pid}", count)
            grown, more, _ = process_facts(process.pid)
            size, took = drain(sockets, seconds)
            sent = _last(process, 30)
            messages = size / FRAME
            print(
                f"  {library:6} {messages / took / 1000:8.1f} k messages/s received by all together,"
                f" {sent['cpu'] / max(1, messages) * 1e6:6.1f} us of the publisher's CPU for each;"
                f" {(more - threads) / count:.2f} threads and {(grown - memory) / count / 1024:.1f} KiB per link"
            )
        finally:
            _end(process, sockets)
        _latency_of_many(bench, library, count)


def _latency_of_many(bench: Bench, library: str, count: int) -> None:
    """One message at 20 Hz, until the last of the readers has it."""
    import struct

    process = bench.start(library, "publish_steady", subscribers=count, hz=20, count=60, queue_size=10)
    sockets: list[socket.socket] = []
    try:
        sockets = subscribe(bench, f"/publish_steady_{process.pid}", count)
        times: list[float] = []
        for sock in sockets:
            sock.settimeout(10)
        for _ in range(50):
            stamp = 0.0
            for sock in sockets:
                data = b""
                while len(data) < FRAME:
                    data += sock.recv(FRAME - len(data))
                stamp = struct.unpack_from("<d", data, 4)[0]
            times.append(time.monotonic() - stamp)
        times.sort()
        print(
            f"  {library:6} at 20 Hz the last of {count} has it after p50 {times[25] * 1e3:.2f} ms, p90 {times[45] * 1e3:.2f} ms"
        )
    finally:
        _end(process, sockets)


def _settled(process: subprocess.Popen[str]) -> tuple[int, int, float]:
    """Facts of a process that has started: when its threads have not changed for half a second."""
    facts = (0, 0, 0.0)
    same = 0
    while same < 5:
        time.sleep(0.1)
        now = process_facts(process.pid)
        same = same + 1 if now[1] == facts[1] and now[0] == facts[0] and now[1] > 2 else 0
        facts = now
    return facts


def _end(process: subprocess.Popen[str], sockets: list[socket.socket]) -> None:
    for sock in sockets:
        sock.close()
    process.kill()
    process.wait(10)


def many_topics(bench: Bench, count: int, seconds: float) -> None:
    print(f"\n{count} topics between two nodes, each at 10 Hz")
    for library in ("rospy", "ours"):
        bench.renew_master()
        sub = bench.start(library, "many_subscribe", topics=count, life=seconds + 25)
        began = time.monotonic()
        _answer(sub, "ready")
        subscribed = time.monotonic() - began
        pub = bench.start(library, "many_publish", topics=count, hz=10, seconds=seconds)
        try:
            sent = _last(pub, 90)
            result = _last(sub, 60)
            times = sorted(result["times"])
            print(
                f"  {library:6} connected {sent['connected']} of {count} after {sent['connect_seconds']:.1f} s"
                f" (process and subscriptions {subscribed:.1f} s); {result['received'] / max(1, sent['sent']):.1%} received,"
                f" latency p50 {times[len(times) // 2] * 1e3:.2f} ms, p99 {times[len(times) * 99 // 100] * 1e3:.2f} ms;"
                f" per topic: subscriber {result['threads'] / count:.2f} threads, {result['rss'] / count / 1024:.1f} KiB,"
                f" {result['cpu'] / max(1, result['received']) * 1e6:.0f} us CPU per message;"
                f" publisher {sent['threads'] / count:.2f} threads, {sent['cpu'] / max(1, sent['sent']) * 1e6:.0f} us"
            )
        finally:
            for process in (pub, sub):
                process.kill()
                process.wait(10)


def many_connections(bench: Bench, count: int) -> None:
    print(f"\n{count} idle subscribers connected to one publisher")
    for library in ("rospy", "ours"):
        bench.renew_master()
        process = bench.start(library, "publish_steady", subscribers=10**6, hz=1, count=1)
        sockets: list[socket.socket] = []
        try:
            memory, threads, _ = _settled(process)
            began = time.monotonic()
            sockets = subscribe(bench, f"/publish_steady_{process.pid}", count)
            took = time.monotonic() - began
            grown, more, _ = process_facts(process.pid)
            waits = []
            for _ in range(20):
                start = time.monotonic()
                sockets += subscribe(bench, f"/publish_steady_{process.pid}", 1)
                waits.append(time.monotonic() - start)
            print(
                f"  {library:6} {took / count * 1e3:6.2f} ms each to connect; {(grown - memory) / count / 1024:6.1f} KiB and"
                f" {(more - threads) / count:.2f} threads per connection; the next one is served in"
                f" {statistics.median(waits) * 1e3:.1f} ms"
            )
        finally:
            _end(process, sockets)


def gone_publishers(bench: Bench, count: int, settle: float, seconds: float) -> None:
    print(f"\n{count} topics whose publishers are registered and gone, {settle:g} s after subscribing")
    for library in ("rospy", "ours"):
        bench.renew_master()
        with socket.socket() as dead, XmlRpcClient(bench.uri) as master:
            dead.bind(("127.0.0.1", 0))
            uri = f"http://127.0.0.1:{dead.getsockname()[1]}/"
            for number in range(count):
                master.call("registerPublisher", "/gone", f"/many{number}", "geometry_msgs/Twist", uri)
            process = bench.start(library, "many_subscribe", topics=count, life=settle + seconds)
            try:
                _answer(process, "ready")
                time.sleep(settle)
                print(f"  {library:6} {idle_cost(process.pid, seconds)}")
            finally:
                _end(process, [])


def idle_cost(pid: int, seconds: float) -> str:
    """Processor time and threads of a process that has nothing to do."""
    before = process_facts(pid)
    time.sleep(seconds)
    after = process_facts(pid)
    files = len(os.listdir(f"/proc/{pid}/fd"))
    return (
        f"{(after[2] - before[2]) / seconds:7.2%} of a core, {after[1]} threads, {files} files,"
        f" {after[0] / 2**20:.0f} MiB"
    )


NODES = """
import sys, time, rosproto
nodes = [rosproto.Node(f"/node{i}", master_uri=sys.argv[1]) for i in range(int(sys.argv[2]))]
for node in nodes:
    node.publisher(f"{node.name}/out", "std_msgs/String")
    node.subscriber("/all", "std_msgs/String")
print("ready", flush=True)
sys.stdin.readline()
began = time.process_time()
for node in nodes:
    node.close()
print(time.process_time() - began, flush=True)
"""
SIMULATORS = """
import sys, time
from woosh_pure import SimulatedChassis
robots = [SimulatedChassis().start() for _ in range(int(sys.argv[2]))]
print("ready", flush=True)
sys.stdin.readline()
began = time.process_time()
for robot in robots:
    robot.close()
print(time.process_time() - began, flush=True)
"""


def many_idle(bench: Bench, program: str, count: int, what: str, seconds: float) -> None:
    """Many things of ours in one process, at rest, and what closing them costs."""
    print(f"\n{count} {what} in one process")
    bench.renew_master()
    process = subprocess.Popen(
        [sys.executable, "-c", program, bench.uri, str(count)],
        cwd=ROOT,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdout.readline()
        time.sleep(12)  # the first looks at the master are over, and idle threads have ended
        print(f"  ours   {idle_cost(process.pid, max(seconds, 10.0))}")
        process.stdin.write("\n")
        process.stdin.flush()
        took = float(process.stdout.readline())
        print(f"         closing them takes {took:.1f} s of processor time")
    finally:
        _end(process, [])


def many_registrations(bench: Bench, count: int, seconds: float) -> None:
    print(f"\nan idle node beside {count} registrations")
    for library in ("rospy", "ours"):
        bench.renew_master()
        with XmlRpcClient(bench.uri) as master:
            for number in range(count):
                master.call(
                    "registerPublisher", "/many", f"/topic/{number}", "std_msgs/String", "http://127.0.0.1:9/"
                )
        process = bench.start(library, "many_subscribe", topics=1, life=60 + seconds)
        try:
            _answer(process, "ready")
            time.sleep(12)
            print(f"  {library:6} {idle_cost(process.pid, max(seconds, 20.0))}")
        finally:
            _end(process, [])
