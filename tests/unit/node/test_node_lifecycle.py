"""Opening, closing, restarting: masters that come and go, addresses that change, nothing left behind."""

from __future__ import annotations

import gc
import os
import socket
import sys
import threading
import time
from typing import Any

import pytest

from rosproto.errors import ConnectionLost, LocalProtocolError, RosTimeout
from rosproto.master import Master
from rosproto.node import EventKind, MasterClient, Node, shutdown
from rosproto.transport import own_address
from rosproto.transport.own_address import local_address_towards
from rosproto.transport.uri import parse_uri
from tests.support.ports import unused_port
from tests.support.slave_caller import Caller, require_second_address
from tests.support.victim import eventually

String = "std_msgs/String"


def test_no_master_is_told_with_address_and_advice() -> None:
    """At once when the connection is refused."""
    uri = f"http://127.0.0.1:{unused_port()}/"
    with pytest.raises(ConnectionLost, match="is the master") as caught:
        Node("/n", master_uri=uri)
    assert uri in str(caught.value)


def test_a_silent_master_is_told_within_the_timeout() -> None:
    """It accepts and never answers."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        began = time.monotonic()
        with pytest.raises(RosTimeout, match="cannot join the master"):
            Node("/n", master_uri=f"http://127.0.0.1:{server.getsockname()[1]}", timeout=0.3)
        assert time.monotonic() - began < 8.0  # other waits for a master have ten seconds


def test_close_takes_everything_off_the_master_and_may_be_called_twice(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Also from several threads at once; afterwards everything refuses politely."""
    monkeypatch.setattr(shutdown, "CLOSE_SECONDS", 10.0)  # a busy computer may need longer than it is given
    with Master() as master:
        node = Node("/n", master_uri=master.uri)
        publisher, subscriber = node.publisher("/p", String), node.subscriber("/s", String)
        threads = [threading.Thread(target=node.close) for _ in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(20)
        node.close()
        with MasterClient(master.uri, "/test") as client:
            assert client.get_system_state().nodes == []
        assert publisher.closed
        assert subscriber.closed
        with pytest.raises(LocalProtocolError, match="closed"):
            publisher.publish(data="x")
        with pytest.raises(LocalProtocolError, match="is closed"):
            node.publisher("/q", String)


def test_close_is_bounded_when_the_master_is_gone() -> None:
    """A dead master is no reason to wait."""
    master = Master()
    node = Node("/n", master_uri=master.uri)
    for n in range(20):
        node.publisher(f"/p{n}", String)
    master.close()
    began = time.monotonic()
    node.close()
    assert time.monotonic() - began < 10.0  # a second for each topic would be twenty


def test_everything_is_registered_again_at_a_restarted_master() -> None:
    """The same process id, the same port, an empty registry."""
    port = unused_port()
    events: list[EventKind] = []
    master = Master(port=port)
    with Node("/n", master_uri=master.uri, on_event=lambda e: events.append(e.kind)) as node:
        node.publisher("/p", String)
        node.subscriber("/s", String)
        master.close()
        eventually(lambda: EventKind.MASTER_LOST in events)
        with Master(port=port) as again, MasterClient(again.uri, "/test") as client:
            eventually(
                lambda: (
                    "/p" in client.get_system_state().publishers
                    and "/s" in client.get_system_state().subscribers
                )
            )
            eventually(lambda: EventKind.MASTER_BACK in events)
            node.close()
            assert client.get_system_state().nodes == []


def test_what_is_lost_at_the_master_without_a_restart_is_found() -> None:
    """A new registration made before the restart was noticed does not hide the lost ones."""
    with Master() as master, Node("/n", master_uri=master.uri) as node:
        node.publisher("/p", String)
        with MasterClient(master.uri, "/n") as somebody:
            somebody.unregister_publisher("/p", node.uri)
            node.watch_master(period=1.0, full_check_every=1)
            eventually(lambda: "/p" in somebody.get_system_state().publishers)


DEAF: Any = {"allow": ["192.0.2.1"], "intraprocess": False}
"""As behind a firewall that lets nobody in: the master's publisherUpdate never arrives."""


def test_publishers_that_nobody_told_us_of_are_found() -> None:
    with (
        Master() as master,
        Node("/a", master_uri=master.uri, intraprocess=False) as a,
        Node("/b", master_uri=master.uri, **DEAF) as b,
    ):
        subscriber = b.subscriber("/p", String)
        publisher = a.publisher("/p", String)
        b.watch_master(period=1.0, full_check_every=1)
        eventually(lambda: subscriber.connections == 1)
        publisher.close()
        eventually(lambda: not subscriber.stats())


def test_a_publisher_that_is_elsewhere_now_is_asked_for() -> None:
    """Restarted on other ports, which nobody tells us."""
    with Master() as master, Node("/b", master_uri=master.uri, **DEAF) as b:
        with Node("/a", master_uri=master.uri, intraprocess=False) as a:
            a.publisher("/p", String)
            subscriber = b.subscriber("/p", String)
            subscriber.wait_for_connection(20)
        eventually(lambda: not subscriber.connections)
        with Node("/a", master_uri=master.uri, intraprocess=False) as a:
            a.publisher("/p", String)
            eventually(lambda: subscriber.connections == 1)


def test_waiting_to_verify_does_not_spin_while_the_master_is_away(monkeypatch: pytest.MonkeyPatch) -> None:
    require_second_address()
    looks: list[float] = []

    def counted(*where: Any) -> str:
        looks.append(time.monotonic())
        return local_address_towards(*where)

    with Master() as master, Node("/n", master_uri=master.uri) as node:
        node.subscriber("/p", String)
        master.close()
        eventually(lambda: node.stats().master_lost)
        with Caller(parse_uri(node.uri)) as stranger:  # whose list is to be verified
            assert stranger.call("publisherUpdate", "/master", "/p", []) == [1, "", 0]
        monkeypatch.setattr(own_address, "local_address_towards", counted)
        eventually(lambda: len(looks) >= 5)
        # The first may come at once; then the back-off: 0.1 s and more, less a tenth.
        assert min(looks[n + 1] - looks[n] for n in range(1, len(looks) - 1)) > 0.08


@pytest.mark.promise("`ROS_HOSTNAME` takes precedence over `ROS_IP`")
def test_the_node_follows_its_address(monkeypatch: pytest.MonkeyPatch) -> None:
    """Another address towards the master: servers and registrations move, links come back."""
    address = ["127.0.0.1"]
    monkeypatch.setattr(own_address, "local_address_towards", lambda *_: address[0])
    events: list[Any] = []
    with (
        Master() as master,
        Node("/n", master_uri=master.uri, on_event=events.append, intraprocess=False) as node,
        Node("/o", master_uri=master.uri, host="127.0.0.1", intraprocess=False) as other,
    ):
        publisher, subscriber = node.publisher("/p", String), other.subscriber("/p", String)
        back, forth = other.publisher("/q", String), node.subscriber("/q", String)
        publisher.wait_for_connection()
        back.wait_for_connection()
        old = node.uri
        (first,) = publisher.stats()
        address[0] = "127.0.0.2"
        try:
            with socket.create_server(("127.0.0.2", 0)):
                pass
        except OSError:
            pytest.skip("this computer has no second loopback address")
        eventually(lambda: any(event.kind is EventKind.ADDRESS_CHANGED for event in events))
        assert node.uri.startswith("http://127.0.0.2:")
        assert node.uri != old
        eventually(
            lambda: (
                [link.address for link in publisher.stats()] not in ([], [first.address])
                and subscriber.connections == 1
                and back.connections == 1
            )
        )
        with MasterClient(master.uri, "/test") as client:
            assert client.lookup_node("/n") == node.uri
        publisher.publish(data="moved")
        assert subscriber.next(20).data == "moved"
        eventually(lambda: forth.connections == 1)
        back.publish(data="too")
        assert forth.next(20).data == "too"
        assert not node.closed


def test_names() -> None:
    """Namespaces, private names, remappings, anonymous names."""
    with Master() as master:
        with Node(
            "arm", namespace="/robot", master_uri=master.uri, remappings={"scan": "/laser/scan"}
        ) as node:
            assert node.name == "/robot/arm"
            assert node.namespace == "/robot/"
            assert node.publisher("~state", String).topic == "/robot/arm/state"
            assert node.subscriber("odom", String).topic == "/robot/odom"
            assert node.subscriber("scan", String).topic == "/laser/scan"
        with (
            Node("/n", master_uri=master.uri, anonymous=True, rosout=False) as one,
            Node("/n", master_uri=master.uri, anonymous=True, rosout=False) as two,
        ):
            assert one.name != two.name
            assert one.name.startswith("/n_")
        for wrong in ("", "~x", "/", "ü", "a b"):
            with pytest.raises(ValueError, match="name"):
                Node(wrong, master_uri=master.uri)


def test_the_environment_is_read_only_when_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    """ROS_MASTER_URI, ROS_IP, ROS_NAMESPACE."""
    with Master() as master:
        monkeypatch.setenv("ROS_MASTER_URI", master.uri)
        monkeypatch.setenv("ROS_IP", "127.0.0.1")
        monkeypatch.setenv("ROS_NAMESPACE", "/ns")
        with pytest.raises(ValueError, match="which master"):
            Node("n")
        with Node("n", use_environment=True, rosout=False) as node:
            assert node.name == "/ns/n"
            assert node.uri.startswith("http://127.0.0.1:")


def test_a_second_node_of_the_same_name_ends_the_first() -> None:
    """As in ROS: the master tells the old one, which checks and obeys."""
    with (
        Master() as master,
        Node("/same", master_uri=master.uri) as first,
        Node("/same", master_uri=master.uri) as second,
    ):
        assert first.wait(20)
        assert not second.closed
        with MasterClient(master.uri, "/test") as client:
            assert client.lookup_node("/same") == second.uri


def open_files() -> int:
    return len(os.listdir("/proc/self/fd"))


@pytest.mark.whole
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="counts open files in /proc")
@pytest.mark.slow
def test_cycles_leave_no_threads_and_no_sockets() -> None:
    """Subscribing and unsubscribing, opening and closing nodes."""

    def cycle() -> None:
        with Node("/cycle", master_uri=master.uri, intraprocess=False) as node:
            for n in range(5):
                with node.subscriber("/t", String) as subscriber:
                    subscriber.wait_for_connection()
                node.publisher(f"/p{n}", String).close()

    with Master() as master, Node("/pub", master_uri=master.uri) as source:
        publisher = source.publisher("/t", String)
        cycle()
        eventually(lambda: publisher.connections == 0)
        gc.collect()
        threads, files = threading.active_count(), open_files()
        for _ in range(10):
            cycle()
        gc.collect()
        eventually(lambda: publisher.connections == 0)
        eventually(lambda: threading.active_count() <= threads + 2, 10)
        eventually(lambda: open_files() <= files + 2, 10)


@pytest.mark.promise("A node listens on the one address", "A node listens on one address, on a")
def test_it_listens_on_one_address_only() -> None:
    """The one that routes to the master."""
    with Master() as master, Node("/n", master_uri=master.uri) as node:
        assert node.tcpros_address[0] == local_address_towards("127.0.0.1", 80)
        port = node.tcpros_address[1]
        try:
            outside = local_address_towards("192.0.2.1", 80)
        except ConnectionLost:
            pytest.skip("no other address here")
        with pytest.raises(OSError):
            socket.create_connection((outside, port), 1.0).close()


def test_what_is_to_be_done_before_a_node_closes_finds_it_whole() -> None:
    """A last message is sent and heard; `on_shutdown` comes afterwards; one that fails harms nobody."""
    with Master() as master, Node("/listener", master_uri=master.uri) as listener:
        heard: list[str] = []
        order: list[tuple[str, str, bool]] = []
        listener.subscriber("/p", String, callback=lambda message: heard.append(message.data))
        node = Node("/n", master_uri=master.uri)
        publisher = node.publisher("/p", String)
        publisher.wait_for_connection(timeout=10)
        node.before_close(lambda _: 1 // 0)
        node.before_close(lambda reason: order.append(("before", reason, node.closed)))
        node.before_close(lambda _: publisher.publish(data="last"))
        node.before_close(lambda _: node.close())  # and this does not wait for itself
        node.on_shutdown(lambda reason: order.append(("shutdown", reason, node.closed)))
        node.close()
        node.close()
        assert order == [("before", "", False), ("shutdown", "", True)]
        eventually(lambda: heard == ["last"])


def test_a_node_whose_close_is_interrupted_is_closed_all_the_same() -> None:
    """Ctrl-C while a callback runs before the end is raised when the node is unregistered."""

    def interrupted(_: str) -> None:
        raise KeyboardInterrupt

    with Master() as master, MasterClient(master.uri, "/tool") as client:
        node = Node("/n", master_uri=master.uri)
        node.before_close(interrupted)
        node.on_shutdown(interrupted)
        with pytest.raises(KeyboardInterrupt):
            node.close()
        assert node.closed
        assert client.get_system_state().nodes == []


def test_a_second_caller_of_close_waits_for_what_is_done_before() -> None:
    """Whatever closes it, the node is closed when `close` returns."""
    with Master() as master:
        node = Node("/n", master_uri=master.uri)
        came, go_on = threading.Event(), threading.Event()
        node.before_close(lambda _: (came.set(), go_on.wait(20)))
        first = threading.Thread(target=node.close)
        second = threading.Thread(target=node.close)
        first.start()
        assert came.wait(10)
        second.start()
        assert not node.closed
        node.publisher("/p", String).publish(data="x")
        go_on.set()
        first.join(20)
        second.join(20)
        assert node.closed
