"""What a node offers to those who build on it: hooks of its end, its looks at the master, its addresses."""

from __future__ import annotations

import socket
import subprocess
import sys
import threading
from collections.abc import Iterator

import pytest

from rosproto.master import Master
from rosproto.node import Event, EventKind, MasterClient, Node, NodeClient
from rosproto.protocol.handshake import subscriber_header
from rosproto.protocol.wire_limits import Limits
from rosproto.transport.deadline import Deadline
from rosproto.transport.tcp import read_header, write_header
from tests.support.victim import eventually

String = "std_msgs/String"


@pytest.fixture
def master() -> Iterator[Master]:
    with Master() as master:
        yield master


# -- the end of a node ------------------------------------------------------------------------------------------


def test_closers_are_called_the_newest_first_and_the_node_ends_all_the_same(master: Master) -> None:
    """One that fails, or is removed, does not keep the others from it."""
    called: list[str] = []
    node = Node("/n", master_uri=master.uri, rosout=False)

    def fails() -> None:
        called.append("fails")
        raise RuntimeError("a closer of the test")

    def removed() -> None:
        called.append("removed")

    def oldest() -> None:
        called.append(f"oldest, closed: {node.closed}")

    node.add_closer(oldest)
    node.add_closer(fails)
    node.add_closer(removed)
    node.add_closer(lambda: called.append("newest"))
    node.remove_closer(removed)
    node.remove_closer(removed)  # not there any more: nothing happens
    node.close()
    node.close()
    assert called == ["newest", "fails", "oldest, closed: True"]
    assert node.wait(0)
    with MasterClient(master.uri, "/test") as client:
        assert client.get_system_state().nodes == []


def test_a_closer_finds_the_links_of_the_node_still_there(master: Master) -> None:
    """It is called before they go."""
    with Node("/hears", master_uri=master.uri, rosout=False) as hears:
        hears.subscriber("/p", String)
        node = Node("/n", master_uri=master.uri, rosout=False)
        publisher = node.publisher("/p", String)
        publisher.wait_for_connection(20)
        seen: list[int] = []
        node.add_closer(lambda: seen.append(publisher.connections))
        node.close()
        assert seen == [1]


def test_a_node_that_is_not_to_be_closed_at_exit_stays_at_the_master(master: Master) -> None:
    """The program sees to it, or leaves it to somebody else; with the default it is taken off."""
    code = (
        "import sys, rosproto\n"
        "for name, close in (('/left', False), ('/taken', True)):\n"
        "    node = rosproto.Node(name, master_uri=sys.argv[1], rosout=False, close_at_exit=close)\n"
        "    node.publisher('/p', 'std_msgs/String')\n"
    )
    subprocess.run([sys.executable, "-c", code, master.uri], check=True, timeout=60)
    with MasterClient(master.uri, "/test") as client:
        assert client.get_system_state().nodes == ["/left"]


def test_who_ends_a_node_may_be_asked_to_wait_for_the_program(master: Master) -> None:
    """With `on_shutdown_request` nothing is closed: the program is told why, and does it."""
    asked: list[str] = []
    told = threading.Event()

    def on_request(reason: str) -> None:
        asked.append(reason)
        told.set()

    with Node("/n", master_uri=master.uri, rosout=False, on_shutdown_request=on_request) as node:
        with NodeClient(node.uri, "/rosnode") as rosnode:
            rosnode.shutdown("enough")
        assert told.wait(5)
        assert not node.closed
        (reason,) = asked
        assert "enough" in reason
        assert "/rosnode" in reason
    assert node.close_reason == ""


# -- looks at the master ----------------------------------------------------------------------------------------


def test_a_look_at_the_master_can_be_asked_for(master: Master) -> None:
    """What is missing there is registered now, though the next look is due in an hour."""
    with (
        Node("/n", master_uri=master.uri, rosout=False) as node,
        MasterClient(master.uri, "/n") as somebody,
    ):
        node.publisher("/p", String)
        node.watch_master(period=3600, full_check_every=1)
        for _ in range(2):  # the first look was due within a second in any case
            assert somebody.unregister_publisher("/p", node.uri) == 1
            node.check_master_now()
            eventually(lambda: "/p" in somebody.get_system_state().publishers, 5.0)


def test_a_node_may_look_often(master: Master) -> None:
    """The period and the looks between two comparisons of the graph are the program's."""
    with (
        Node("/n", master_uri=master.uri, rosout=False) as node,
        MasterClient(master.uri, "/n") as somebody,
    ):
        node.publisher("/p", String)
        node.watch_master(period=0.02, full_check_every=2)
        node.check_master_now()
        for _ in range(3):
            assert somebody.unregister_publisher("/p", node.uri) == 1
            eventually(lambda: "/p" in somebody.get_system_state().publishers, 5.0)


# -- the clock --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("follow", [True, False])
def test_a_program_may_keep_the_clock_for_itself(master: Master, follow: bool) -> None:
    """Then /clock is not subscribed, whatever /use_sim_time says."""
    with MasterClient(master.uri, "/test") as client:
        client.set_param("/use_sim_time", True)
        with Node("/n", master_uri=master.uri, rosout=False, follow_clock=follow) as node:
            assert node.clock.simulated is follow
            assert client.get_system_state().subscribers == ({"/clock": ["/n"]} if follow else {})


# -- addresses, and who came there ------------------------------------------------------------------------------


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port: int = server.getsockname()[1]
        return port


def test_the_addresses_are_those_that_others_are_told(master: Master) -> None:
    """The slave API at the master, the TCPROS server to subscribers, and to clients of services."""
    with (
        Node("/n", master_uri=master.uri, rosout=False, tcpros_port=free_port()) as node,
        MasterClient(master.uri, "/test") as client,
        NodeClient(node.uri, "/test") as peer,
    ):
        node.publisher("/p", String)
        node.service_server("/s", "std_srvs/Trigger", lambda request: (True, ""))
        host, port = node.tcpros_address
        assert client.lookup_node("/n") == node.uri
        assert peer.request_topic("/p") == ["TCPROS", host, port]
        assert client.lookup_service("/s") == node.rosrpc_uri == f"rosrpc://{host}:{port}"


def test_a_tcpros_port_can_be_given(master: Master) -> None:
    """For a firewall that lets one port in."""
    port = free_port()
    with Node("/n", master_uri=master.uri, rosout=False, tcpros_port=port) as node:
        assert node.tcpros_address == ("127.0.0.1", port)


def test_the_event_of_a_refused_subscriber_has_its_header(master: Master) -> None:
    """So a program can tell who came with another definition, and with which."""
    events: list[Event] = []
    with Node("/n", master_uri=master.uri, rosout=False, on_event=events.append) as node:
        node.publisher("/p", String)
        header = subscriber_header(
            topic="/p", type_name="std_msgs/UInt8", md5sum="7" * 32, callerid="/stranger"
        )
        with socket.create_connection(node.tcpros_address, 5.0) as sock:
            write_header(sock, header, Deadline(5.0))
            assert "error" in read_header(sock, Limits(), Deadline(5.0))
        eventually(lambda: any(event.kind is EventKind.REFUSED for event in events), 5.0)
    (refused,) = [event for event in events if event.kind is EventKind.REFUSED]
    assert refused.name == "/p"
    assert refused.header["callerid"] == "/stranger"
    assert refused.header["md5sum"] == "7" * 32
    assert all(not event.header for event in events if event is not refused)
