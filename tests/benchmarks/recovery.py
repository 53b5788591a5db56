"""How long it takes until everything works again after a fault: `python -m tests.benchmarks recovery [--rounds N]`.

Each row is the time from the moment the other side can be reached again (a publisher restarted, a link cut, a master
that answers) until a message arrives, or until the master knows everything again.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable

from rosproto.master import Master
from rosproto.node import MasterClient, Node
from tests.support.proxy import FaultProxy
from tests.support.ros import free_port

STRING = "std_msgs/String"


def run(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="tests.benchmarks recovery")
    parser.add_argument("--rounds", type=int, default=5)
    args = parser.parse_args(arguments)
    for label, must, case in (
        ("link reset by the network", 1.0, link_reset),
        ("publisher restarted, other ports", 1.0, publisher_restarted),
        ("publisher killed, same XML-RPC port, master not told", 1.0, publisher_same_port),
        ("master restarted: all registered again", 2.0, master_restarted),
    ):
        times = [case() for _ in range(args.rounds)]
        print(
            f"{label:56} median {statistics.median(times) * 1e3:7.0f} ms   worst {max(times) * 1e3:7.0f} ms"
            f"   must be below {must:g} s: {'ok' if max(times) < must else 'NO'}"
        )


def until(condition: Callable[[], object], timeout: float = 20.0) -> float:
    """Seconds until it holds."""
    began = time.monotonic()
    while not condition():
        if time.monotonic() - began > timeout:
            raise RuntimeError("it never recovered")
        time.sleep(0.001)
    return time.monotonic() - began


def link_reset() -> float:
    """The TCP connection is reset though both nodes live."""
    with (
        Master() as master,
        Node("/a", master_uri=master.uri) as a,
        Node("/b", master_uri=master.uri, intraprocess=False) as b,
        FaultProxy("127.0.0.1", a._tcpros.port) as proxy,
    ):
        # The publisher announces the proxy's port.
        handler, arity, refusal = a._slave.methods["requestTopic"]
        a._slave.methods["requestTopic"] = (
            lambda *call: [*handler(*call)[:2], ["TCPROS", "127.0.0.1", proxy.port]],
            arity,
            refusal,
        )
        publisher = a.publisher("/t", STRING)
        subscriber = b.subscriber("/t", STRING)
        publisher.wait_for_connection()
        proxy.reset()
        until(lambda: publisher.connections == 0)
        return until(lambda: publisher.connections == 1 and subscriber.connections == 1)


def publisher_restarted() -> float:
    """The publisher's node is closed and opened again."""
    with Master() as master, Node("/b", master_uri=master.uri, intraprocess=False) as b:
        subscriber = b.subscriber("/t", STRING)
        with Node("/a", master_uri=master.uri) as a:
            a.publisher("/t", STRING).wait_for_connection()
        with Node("/a", master_uri=master.uri) as a:
            publisher = a.publisher("/t", STRING)
            return until(lambda: publisher.connections == 1 and subscriber.connections == 1)


def publisher_same_port() -> float:
    """The publisher dies without a word for two seconds and comes back on the same XML-RPC port (pitfall 29)."""
    port = free_port()
    with Master() as master, Node("/b", master_uri=master.uri, intraprocess=False) as b:
        subscriber = b.subscriber("/t", STRING)
        a = Node("/a", master_uri=master.uri, port=port)
        a.publisher("/t", STRING).wait_for_connection()
        a._registrations._table.clear()  # it does not unregister, as a killed process does not
        a.close()
        time.sleep(2.0)
        with Node("/a", master_uri=master.uri, port=port, rosout=False) as a:
            # The master's list does not change: only the subscriber's own tries find it.
            from rosproto.node.publication import Publication
            from rosproto.node.publisher import Publisher
            from rosproto.node.topic_types import resolve_type

            publication = Publication(a, "/t", resolve_type(STRING))
            publication.add_handle(Publisher(a, publication, latch=False, queue_size=1, on_connect=None))
            a._topics._publications["/t"] = publication
            return until(lambda: len(publication.links) == 1 and subscriber.connections == 1)


def master_restarted() -> float:
    """Killed for a second, then back on its port with an empty registry; 20 topics."""
    port = free_port()
    master = Master(port=port)
    with Node("/a", master_uri=master.uri) as node:
        for n in range(10):
            node.publisher(f"/p{n}", STRING)
            node.subscriber(f"/s{n}", STRING)
        master.close()
        time.sleep(1.0)
        with Master(port=port) as again, MasterClient(again.uri, "/test") as client:

            def all_there() -> bool:
                state = client.get_system_state()
                return len(state.publishers) == 11 and len(state.subscribers) == 10

            return until(all_there)
