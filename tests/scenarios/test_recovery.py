"""A node's links and registrations after faults: FIN, RST, silence, restarts of publishers and masters, a new address."""

from __future__ import annotations

import gc
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from rosproto.master import Master
from rosproto.node import EventKind, MasterClient, Node
from rosproto.node.incoming import publisher_link_state
from rosproto.node.incoming.tcpros_link import FrameReader
from rosproto.transport import own_address, tcp
from tests.support.load import crowd
from tests.support.proxy import FaultProxy
from tests.support.ros import free_port
from tests.support.victim import eventually

ROOT = Path(__file__).resolve().parents[2]
STRING = "std_msgs/String"
LINK_SECONDS = 1.0  # what the README promises for a link
MASTER_SECONDS = 2.0  # and for registrations
# For a computer that does other things as well: `tests.benchmarks recovery` prints the real figures. The processes
# that each processor serves take their turns, and every step of a recovery waits for one.
SLACK = 2.0 * crowd()


def behind(proxy: FaultProxy, node: Node) -> None:
    """Have a node announce the proxy's port instead of its own."""
    handler, arity, refusal = node._parts.slave.methods["requestTopic"]
    node._parts.slave.methods["requestTopic"] = (
        lambda *call: [*handler(*call)[:2], ["TCPROS", proxy.host, proxy.port]],
        arity,
        refusal,
    )


@pytest.fixture
def pair() -> Iterator[tuple[Node, Node, FaultProxy]]:
    """A publishing node behind a proxy and a subscribing one."""
    with (
        Master() as master,
        Node("/talker", master_uri=master.uri, rosout=False) as a,
        Node("/hearer", master_uri=master.uri, rosout=False, intraprocess=False) as b,
        FaultProxy("127.0.0.1", a.tcpros_address[1]) as proxy,
    ):
        behind(proxy, a)
        yield a, b, proxy


@pytest.mark.promise("A publisher that closes its connection and stays")
@pytest.mark.parametrize("fault", ["cut", "reset"])
def test_ten_faults_in_a_row(
    fault: str, pair: tuple[Node, Node, FaultProxy], monkeypatch: pytest.MonkeyPatch
) -> None:
    """FIN and RST: each time connected again within a second, with a new connection, and counted."""
    monkeypatch.setattr(
        publisher_link_state, "STEADY_SECONDS", 0.0
    )  # or links that last only moments wait longer and longer
    a, b, proxy = pair
    publisher, subscriber = a.publisher("/t", STRING), b.subscriber("/t", STRING)
    publisher.wait_for_connection(10)
    subscriber.wait_for_connection(10)
    took = []
    for number in range(10):
        accepted = proxy.accepted
        began = time.monotonic()
        getattr(proxy, fault)()
        eventually(
            lambda n=accepted: (
                proxy.accepted > n and publisher.connections == 1 and subscriber.connections == 1
            )
        )  # type: ignore[misc]
        took.append(time.monotonic() - began)
        publisher.publish(data=str(number))
        assert subscriber.next(5).data == str(number)
    assert sorted(took)[5] < LINK_SECONDS + SLACK  # one may be late on a busy computer, not half of them
    assert subscriber.stats()[0].reconnects == 10


def test_errors_that_are_kept_hold_no_buffers(pair: tuple[Node, Node, FaultProxy]) -> None:
    """Their tracebacks held the receive buffer of each dead link: 8 MB for a topic with 32 errors."""
    a, b, proxy = pair
    publisher, subscriber = a.publisher("/t", STRING), b.subscriber("/t", STRING)
    publisher.wait_for_connection(10)
    subscriber.wait_for_connection(10)
    for _ in range(5):
        before = subscriber.stats()[0].reconnects
        proxy.reset()
        eventually(lambda n=before: subscriber.stats()[0].reconnects > n and subscriber.connections == 1)  # type: ignore[misc]
    assert len(subscriber.errors) >= 5
    gc.collect()
    address = f"{proxy.host}:{proxy.port}"
    readers = [one for one in gc.get_objects() if isinstance(one, FrameReader) and one._peer == address]
    assert len(readers) == 1


def test_nothing_queued_is_replayed_late(pair: tuple[Node, Node, FaultProxy]) -> None:
    """What waited for a link that then died is dropped and counted; the first message after it is a new one."""
    a, b, proxy = pair
    publisher = a.publisher("/t", "std_msgs/UInt8MultiArray", queue_size=500)
    subscriber = b.subscriber("/t", "std_msgs/UInt8MultiArray", queue_size=10_000)
    publisher.wait_for_connection(10)
    publisher.publish(data=bytes([1]))
    assert subscriber.next(5).data[0] == 1
    proxy.stall()
    old = bytes([2]) * 300_000
    for _ in range(100):
        publisher.publish(data=old)  # fills every buffer on the way, then the queue
    eventually(lambda: publisher.stats()[0].queued > 10)
    accepted = proxy.accepted
    proxy.reset()
    proxy.resume()
    eventually(
        lambda: proxy.accepted > accepted and publisher.connections == 1 and subscriber.connections == 1
    )
    publisher.publish(data=bytes([3]))
    seen = [subscriber.next(5).data[0]]
    while seen[-1] == 2:  # whole messages that had arrived before the reset
        seen.append(subscriber.next(5).data[0])
    assert seen[-1] == 3
    with pytest.raises(TimeoutError):
        subscriber.next(0.3)
    assert len(seen) < 60


def test_a_proxy_that_refuses_for_a_while(pair: tuple[Node, Node, FaultProxy]) -> None:
    """Unreachable for two seconds: tried again and again with pauses, connected within a second of being reachable."""
    a, b, proxy = pair
    publisher, subscriber = a.publisher("/t", STRING), b.subscriber("/t", STRING)
    publisher.wait_for_connection(10)
    proxy.refusing = True
    proxy.reset()
    before = proxy.accepted
    began = time.monotonic()
    time.sleep(2.0)
    eventually(lambda: proxy.accepted - before >= 2)
    tries = proxy.accepted - before
    assert tries <= 20 * (time.monotonic() - began), tries
    proxy.refusing = False
    began = time.monotonic()
    eventually(lambda: publisher.connections == 1 and subscriber.connections == 1)
    assert time.monotonic() - began < LINK_SECONDS + SLACK


def _vanish(sock: socket.socket) -> None:
    """Let a socket disappear without FIN or RST, as a computer does whose power fails (Linux, with privileges)."""
    repair = 19  # TCP_REPAIR, linux/tcp.h
    try:
        sock.setsockopt(socket.IPPROTO_TCP, repair, 1)
    except OSError as error:
        pytest.skip(f"a socket cannot vanish here: {error}")
    sock.close()


@pytest.mark.skipif(sys.platform != "linux", reason="TCP_REPAIR, to vanish without a word, is Linux's")
def test_a_peer_that_vanished_is_noticed_by_keep_alive(monkeypatch: pytest.MonkeyPatch) -> None:
    """Silence: the system's probes end the link, then it is made again. Here the first comes after a second, not two."""
    monkeypatch.setattr(tcp, "SILENCE_IDLE", 1)
    with (
        Master() as master,
        Node("/talker", master_uri=master.uri, rosout=False) as a,
        Node("/hearer", master_uri=master.uri, rosout=False, intraprocess=False) as b,
    ):
        publisher, subscriber = a.publisher("/t", STRING), b.subscriber("/t", STRING)
        publisher.wait_for_connection(10)
        eventually(
            lambda: subscriber.connections == 1
        )  # it has read the header: otherwise it would wait for that
        publication = a._parts.topics.publication("/t")
        assert publication is not None
        link: Any = publication.links[0]
        a._parts.context.link_monitor._drop = lambda link: None  # type: ignore[method-assign]
        _vanish(link.sock)
        publication.detach(link)
        eventually(lambda: subscriber.stats()[0].reconnects == 1 and subscriber.connections == 1, 10)
        publisher.wait_for_connection(10)  # an answered subscriber is not yet among those that get messages
        publisher.publish(data="again")
        assert subscriber.next(5).data == "again"


TALKER = """
import sys, time
from rosproto import Node
node = Node("/talker", master_uri=sys.argv[1], port=int(sys.argv[2]), rosout=False)
publisher = node.publisher("/t", "std_msgs/String")
print("ready", flush=True)
while True:
    publisher.publish(data=sys.argv[3])
    time.sleep(0.02)
"""


class Process:
    """A Python program of ours in a process, killed at the end."""

    def __init__(self, code: str, *arguments: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-c", code, *arguments], cwd=ROOT, stdout=subprocess.PIPE, text=True
        )
        assert self.process.stdout is not None
        assert self.process.stdout.readline() == "ready\n"

    def __enter__(self) -> Process:
        return self

    def __exit__(self, *exc: object) -> None:
        self.kill()

    def kill(self) -> None:
        """kill -9."""
        self.process.kill()
        self.process.wait(10)
        assert self.process.stdout is not None
        self.process.stdout.close()


@pytest.mark.parametrize("port", ["other", "same"])
def test_a_publisher_killed_and_started_again(port: str) -> None:
    """With another XML-RPC port the master tells; with the same one only our own tries find it (wire.md, fact 29)."""
    number = free_port() if port == "same" else 0
    with Master() as master, Node("/hearer", master_uri=master.uri, rosout=False) as node:
        subscriber = node.subscriber("/t", STRING, queue_size=1)
        with Process(TALKER, master.uri, str(number), "first") as first:
            assert subscriber.next(10).data == "first"
            first.kill()
            eventually(lambda: subscriber.connections == 0)
            time.sleep(1.0)  # it stays away for a while
        with Process(TALKER, master.uri, str(number), "second"):
            began = time.monotonic()
            while subscriber.next(10).data != "second":
                pass
            assert time.monotonic() - began < LINK_SECONDS + SLACK


OUR_MASTER = """
import sys, time
from rosproto.master import Master
Master(port=int(sys.argv[1]))
print("ready", flush=True)
time.sleep(600)
"""


def test_a_master_that_is_killed_three_times() -> None:
    """Publishers, subscribers, services and parameter subscriptions of two nodes are registered again each time."""
    port = free_port()
    uri = f"http://127.0.0.1:{port}/"
    events: list[Any] = []
    values: list[Any] = []
    with ExitStack() as stack:
        master = Process(OUR_MASTER, str(port))
        stack.callback(lambda: master.kill())
        a = stack.enter_context(Node("/a", master_uri=uri, intraprocess=False, on_event=events.append))
        b = stack.enter_context(Node("/b", master_uri=uri, intraprocess=False))
        publisher, subscriber = a.publisher("/t", STRING), b.subscriber("/t", STRING)
        a.service_server("/s", "std_srvs/Empty", lambda request: {})
        b.params.subscribe("/p", lambda key, value: values.append(value))
        publisher.wait_for_connection(10)
        for number in range(3):
            master.kill()
            publisher.publish(data="meanwhile")
            assert subscriber.next(5).data == "meanwhile"
            time.sleep(0.5)
            master = Process(OUR_MASTER, str(port))
            began = time.monotonic()
            with MasterClient(uri, "/test") as client:
                eventually(lambda c=client: _all_there(c))  # type: ignore[misc]
                assert time.monotonic() - began < MASTER_SECONDS + SLACK
                eventually(lambda: not b.stats().master_lost)
                client.set_param("/p", number)
                eventually(lambda n=number: values[-1:] == [n])  # type: ignore[misc]
            b.service_client("/s", "std_srvs/Empty").call()
            publisher.publish(data="after")
            assert subscriber.next(5).data == "after"
        kinds = [event.kind for event in events]
        assert kinds.count(EventKind.MASTER_BACK) == 3


def _all_there(client: MasterClient) -> bool:
    state = client.get_system_state()
    return bool(
        state.publishers.get("/t") == ["/a"]
        and state.subscribers.get("/t") == ["/b"]
        and "/s" in state.services
    )


def test_the_address_changes_under_way_many_times(monkeypatch: pytest.MonkeyPatch) -> None:
    """127.0.0.1 to 127.0.0.2 and on: topics both ways and services work at each new address, no old socket listens."""
    try:
        socket.create_server(("127.0.0.4", 0)).close()
    except OSError:
        pytest.skip("this computer has only one loopback address")
    address = ["127.0.0.1"]
    monkeypatch.setattr(own_address, "local_address_towards", lambda *_: address[0])
    with (
        Master() as master,
        Node("/roams", master_uri=master.uri, intraprocess=False) as roams,
        Node("/stays", master_uri=master.uri, host="127.0.0.1", intraprocess=False) as stays,
    ):
        publisher, subscriber = roams.publisher("/p", STRING), stays.subscriber("/p", STRING)
        back, forth = stays.publisher("/q", STRING), roams.subscriber("/q", STRING)
        roams.service_server("/s", "std_srvs/Empty", lambda request: {})
        client = stays.service_client("/s", "std_srvs/Empty", persistent=True)
        for number in (2, 3, 4):
            old = (
                "127.0.0.1" if number == 2 else f"127.0.0.{number - 1}",
                roams._parts.context.listening.endpoints.slave.port,
            )
            address[0] = f"127.0.0.{number}"
            eventually(lambda: roams.uri.startswith(f"http://{address[0]}:"))
            eventually(lambda: stays.master.lookup_node("/roams") == roams.uri)
            eventually(
                lambda: (
                    publisher.connections == subscriber.connections == 1
                    and back.connections == forth.connections == 1
                )
            )
            publisher.publish(data=address[0])
            while subscriber.next(5).data != address[0]:
                pass
            back.publish(data=address[0])
            while forth.next(5).data != address[0]:
                pass
            client.call(timeout=5)
            with pytest.raises(OSError):
                socket.create_connection(old, 1).close()


@pytest.mark.slow
def test_faults_from_all_sides_at_once(pair: tuple[Node, Node, FaultProxy]) -> None:
    """Five seconds of cuts, resets, stalls and dripping bytes while two threads publish: at the end it works."""
    import random

    a, b, proxy = pair
    publisher, subscriber = (
        a.publisher("/t", STRING, queue_size=100),
        b.subscriber("/t", STRING, queue_size=100),
    )
    publisher.wait_for_connection(10)
    ended = threading.Event()
    slowest = [0.0]

    def publish() -> None:
        while not ended.wait(0.001):
            began = time.monotonic()
            publisher.publish(data="x" * 2000)
            slowest[0] = max(slowest[0], time.monotonic() - began)

    threads = [threading.Thread(target=publish, daemon=True) for _ in range(2)]
    for thread in threads:
        thread.start()
    chance = random.Random(7)
    faults: list[Callable[[], object]] = [
        proxy.cut, proxy.reset, proxy.stall, proxy.resume, lambda: proxy.cut_after(chance.randrange(5000)),
        lambda: setattr(proxy, "byte_at_a_time", chance.random() < 0.3),
        lambda: setattr(proxy, "refusing", chance.random() < 0.3),
    ]  # fmt: skip
    end = time.monotonic() + 5
    while time.monotonic() < end:
        chance.choice(faults)()
        time.sleep(chance.random() * 0.1)
    proxy.byte_at_a_time = proxy.refusing = False
    proxy.resume()
    proxy.cut()
    ended.set()
    for thread in threads:
        thread.join(10)
    eventually(lambda: publisher.connections == 1 and subscriber.connections == 1, 10)
    # Both may count a link that is cut already, and what is sent over it is lost: sent until it is heard.
    end = time.monotonic() + 20
    while (message := subscriber.latest) is None or message.data != "the last":
        assert time.monotonic() < end
        publisher.publish(data="the last")
        time.sleep(0.01)
    assert slowest[0] < 2.0 * crowd()  # it waits for nobody, but for its turn
    eventually(lambda: len(a._parts.topics.link_stats()) == 1)
