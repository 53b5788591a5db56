"""Whose words a running node believes: publisherUpdate, paramUpdate and shutdown from strangers, floods of them."""

from __future__ import annotations

import random
import threading
from collections.abc import Callable
from contextlib import AbstractContextManager, closing
from typing import Any

import pytest

from rosproto.errors import MasterError, RosTimeout
from rosproto.master import Master
from rosproto.node import MasterClient, Node
from rosproto.protocol.wire_limits import Limits
from rosproto.protocol.xmlrpc import Fault
from rosproto.transport import XmlRpcClient
from tests.support import attacks
from tests.support.slave_caller import STRANGER, Caller, require_second_address
from tests.support.slaves import BlackHole, RecordingNode
from tests.support.victim import Bystander, Victim, eventually

Unharmed = Callable[..., AbstractContextManager[None]]
STRING = "std_msgs/String"


@pytest.fixture(autouse=True)
def second_address() -> None:
    require_second_address()


def settled_links(victim: Victim) -> dict[str, str]:
    """Its links, when all of them receive: a publisher sees a connection a moment before its subscriber does."""
    eventually(lambda: set(victim.ask()["links"].values()) == {"receiving"}, what="links that receive")
    links: dict[str, str] = victim.ask()["links"]
    return links


@pytest.mark.promise("are checked with the master")
def test_publisher_updates_from_strangers(victim: Victim, bystander: Bystander, unharmed: Unharmed) -> None:
    """Two thousand lists of rubbish: the master is asked a few times at most, no link is lost or made."""
    with bystander.node.publisher("/in", STRING) as into, bystander.node.subscriber("/out", STRING) as back:
        into.wait_for_connection(60)
        back.wait_for_connection(60)
        before = settled_links(victim)
        with unharmed(threads=30), Caller(victim.node) as stranger:
            for number in range(2000):
                uris = [f"http://127.0.0.1:{1 + (number + n) % 60000}/" for n in range(number % 7)]
                assert stranger.call("publisherUpdate", "/master", "/in", uris)[0] == 1
            into.publish(data="still here")
            assert back.next(60).data == "still here"
        assert victim.ask()["links"] == before


@pytest.mark.parametrize(
    "params",
    [
        (), ("/x",), ("/x", "/in"), ("/x", "/in", []), ("/x", 5, []), ("/x", "/in", {}), ("/x", "/in", "http://a:1/"),
        ("/x", "in", []), ("/x", "/in", [1, 2]), ("/x", "/in", [[]]), ("/x", "/in", ["x"]), ("/x", "/in", ["http://:1/"]),
        ("/x", "/in", ["http://127.0.0.1:99999/"]), ("/x", "/in", ["http://[::1/"]), ("/x", "/" + "i" * 5000, []),
        ("/x", "/in", [], 4), ([], "/in", []), ("/x", "/never", ["http://127.0.0.1:1/"]),
    ],
    ids=range(18),
)  # fmt: skip
def test_publisher_updates_of_any_shape(params: tuple[Any, ...], victim: Victim, unharmed: Unharmed) -> None:
    """Also from the master's own address: a reply of three, and no harm."""
    for source in (STRANGER, "127.0.0.1"):
        with unharmed(), Caller(victim.node, source) as caller:
            for _ in range(20):
                reply = caller.call("publisherUpdate", *params)
                assert len(reply) == 3
                assert reply[0] in (1, -1)


def _answers(into: Any, back: Any) -> bool:
    """The publisher may still count a link that the last list but one ended: what it sends there is lost."""
    into.publish(data="in order")
    try:
        return bool(back.next(0.5).data == "in order")
    except RosTimeout:
        return False


@pytest.mark.promise("A `publisherUpdate` may come before the answer of")
def test_updates_in_any_order_end_with_the_truth(
    victim: Victim, bystander: Bystander, unharmed: Unharmed
) -> None:
    """27: stale, empty and double lists from the master's address, then the right one: one link, and it works."""
    with bystander.node.publisher("/in", STRING) as into, bystander.node.subscriber("/out", STRING) as back:
        into.wait_for_connection(60)
        back.wait_for_connection(60)
        right = [bystander.node.uri]
        shuffle = random.Random(27)
        lists = []
        for _ in range(200):
            wrong = [f"http://127.0.0.1:{shuffle.randrange(1, 1000)}/" for _ in range(shuffle.randrange(4))]
            lists.append(shuffle.choice([[], right, right * 2, wrong, wrong + right]))
        # Each stale address costs a thread until its try is over, however late that is on a busy computer.
        stale = sum(uri not in right for uris in lists for uri in uris)
        with unharmed(threads=stale + 10), Caller(victim.node, "127.0.0.1") as master:
            for uris in lists:
                assert master.call("publisherUpdate", "/master", "/in", uris)[0] == 1
            spelled = bystander.node.uri.rstrip("/").upper().replace("HTTP", "http")
            for uris in (right, [spelled], [*right, spelled]):  # 28: a slash and capitals are no other node
                assert master.call("publisherUpdate", "/master", "/in", uris)[0] == 1
            eventually(lambda: _answers(into, back), what="an answer")
            eventually(lambda: into.connections == 1, what="one link to the publisher")
    eventually(lambda: victim.ask()["links"] == {})


@pytest.mark.slow
def test_a_thousand_publishers_that_do_not_exist(
    victim: Victim, bystander: Bystander, unharmed: Unharmed
) -> None:
    """Anybody may register at a master: dead, silent and absurd addresses beside one that works."""
    with (
        bystander.node.publisher("/in", STRING) as into,
        bystander.node.subscriber("/out", STRING) as back,
        BlackHole() as silent,
        MasterClient(victim.master_uri, "/nobody") as master,
    ):
        into.wait_for_connection(60)
        back.wait_for_connection(60)
        names = [f"/nobody{n}" for n in range(300)]
        uris = [(silent.uri if n % 2 else f"http://127.0.0.1:{n + 1}/") for n in range(300)]
        with unharmed(threads=350, memory=128):
            clients = [
                (MasterClient(victim.master_uri, name), uri) for name, uri in zip(names, uris, strict=True)
            ]
            for client, uri in clients:
                client.register_publisher("/in", STRING, uri)
            for number in range(20):
                into.publish(data=str(number))
                assert back.next(60).data == str(number)
            for client, uri in clients:
                client.unregister_publisher("/in", uri)
                client.close()
        assert list(master.get_system_state().publishers.get("/in", [])) == [bystander.node.name]


def test_a_crowd_of_publishers_is_cut_and_ousts_nobody() -> None:
    """`Limits.publishers` bounds the threads of one topic; the link that works stays, newcomers get what is left."""
    few = Limits(publishers=5)
    with (
        Master() as master,
        Node("/talker", master_uri=master.uri, intraprocess=False) as talker,
        Node("/hearer", master_uri=master.uri, limits=few, intraprocess=False) as hearer,
    ):
        publisher = talker.publisher("/crowded", STRING)
        subscriber = hearer.subscriber("/crowded", STRING)
        publisher.wait_for_connection(60)
        subscriber.wait_for_connection(60)
        crowd = [f"http://127.0.0.1:{port}/" for port in range(1, 500)]
        with Caller(
            ("127.0.0.1", hearer._parts.context.listening.endpoints.slave.port), "127.0.0.1"
        ) as update:
            update.call("publisherUpdate", "/master", "/crowded", [*crowd, talker.uri])
        assert len(subscriber.stats()) == 5
        assert subscriber.connections == 1
        publisher.publish(data="through the crowd")
        assert subscriber.next(60).data == "through the crowd"


@pytest.mark.promise("are checked with the master")
def test_parameter_updates_from_strangers(victim: Victim, bystander: Bystander, unharmed: Unharmed) -> None:
    """A thousand lies about a parameter the node follows: what the master has is what the program sees."""
    with MasterClient(victim.master_uri, "/setter") as master:
        master.set_param("/watched", "true value")
        eventually(lambda: victim.ask()["watched"][-1:] == ["true value"])
        with unharmed(), Caller(victim.node) as stranger:
            for number in range(1000):
                key = ("/watched", "/watched/", "/unknown", "/watched/deep")[number % 4]
                reply = stranger.call("paramUpdate", "/master", key, {"a": number} if number % 3 else number)
                assert reply[0] in (1, -1)
            for params in ((), ("/m", 5, 5), ("/m", "/watched"), ("/m", "watched", 1)):
                assert stranger.call("paramUpdate", *params)[0] == -1
        master.set_param("/watched", "another")
        eventually(lambda: victim.ask()["watched"][-1:] == ["another"])
        seen = victim.ask()["watched"]
        assert all(value in ({}, None, "true value", "another") for value in seen), seen
        assert stranger_says_unsubscribed(victim)


def stranger_says_unsubscribed(victim: Victim) -> bool:
    """Section 10: roscpp answers 1 for a key never subscribed, rospy -1; so do we."""
    with Caller(victim.node) as stranger:
        return bool(stranger.call("paramUpdate", "/master", "/never", 1)[0] == -1)


@pytest.mark.promise("`allow_shutdown=False` refuses `rosnode kill` too")
@pytest.mark.parametrize("who", ["/master", "/rosnode", "", "/victim", "master"])
@pytest.mark.parametrize("source", [STRANGER, "127.0.0.1"])
def test_shutdown_is_refused_where_it_is_not_allowed(
    who: str, source: str, victim: Victim, unharmed: Unharmed
) -> None:
    """allow_shutdown=False: fifty calls, each refused with a reason, in the master's name too (it has our URI)."""
    with unharmed(), Caller(victim.node, source) as caller:
        for _ in range(50):
            code, text, _ = caller.call("shutdown", who, "die")
            assert code != 1
            assert text


@pytest.mark.promise("The master ends a node whose name is")
def test_a_dead_nodes_port_in_new_hands() -> None:
    """31: the master sends away the old holder of a name; the node that has its port now lives on (ros_comm#2241)."""
    with Master() as master, RecordingNode(callerid=None) as old:
        port = old.port
        with MasterClient(master.uri, "/robot") as dead:
            dead.register_publisher("/t", STRING, old.uri)
        old.close()
        with (
            Node("/innocent", master_uri=master.uri, port=port, host="127.0.0.1") as innocent,
            Node("/robot", master_uri=master.uri) as successor,
        ):
            assert innocent._parts.context.listening.endpoints.slave.port == port
            successor.publisher("/t", STRING)
            assert master.flush(10)
            assert not innocent.wait(0.3)
            assert not innocent.closed
            assert successor.master.lookup_node("/robot") == successor.uri
            # And a forged or misdirected call is checked by the node itself.
            with closing(XmlRpcClient(innocent.uri)) as client:
                assert client.call("shutdown", "/master", "new node registered with same name")[0] == 0
            assert not innocent.wait(0.3)


def test_a_closed_peer_on_a_port_of_ours() -> None:
    """Port re-use the other way: requests for a node that is gone reach another one, which says no."""
    with Master() as master:
        with Node("/first", master_uri=master.uri) as first:
            first.publisher("/gone", STRING)
            port, tcpros = first._parts.context.listening.endpoints.slave.port, first.tcpros_address[1]
        with Node("/second", master_uri=master.uri, port=port, tcpros_port=tcpros) as second:
            with closing(XmlRpcClient(second.uri)) as client:
                assert client.call("requestTopic", "/x", "/gone", [["TCPROS"]])[0] != 1
            with attacks.connect(("127.0.0.1", tcpros), attacks.subscriber_header("/gone")) as sock:
                assert "does not publish" in attacks.read_header(sock)["error"]
            with attacks.connect(("127.0.0.1", tcpros), attacks.service_header("/gone")) as sock:
                assert "error" in attacks.read_header(sock)


@pytest.mark.promise("`requestTopic` may offer several protocols, and unknown ones")
@pytest.mark.parametrize(
    ("protocols", "code"),
    [
        ([["UDPROS", b"x", "h", 1, 1500], ["TCPROS"]], 1), ([["XYZ"], [], 5, "TCPROS", ["TCPROS", 1, 2]], 1),
        ([["UDPROS"]], 0), ([[]], 0), ([], -1), ("TCPROS", -1), ({}, -1), (5, -1), ([[["TCPROS"]]], 0),
        ([["x"]] * 5000 + [["TCPROS"]], 1),
    ],
    ids=range(10),
)  # fmt: skip
def test_request_topic_with_any_protocols(protocols: Any, code: int, victim: Victim) -> None:
    """26: the first we know counts, wherever it stands; the reply has the shape peers read."""
    with Caller(victim.node) as caller:
        reply = caller.call("requestTopic", "/x", "/tick", protocols)
        assert reply[0] == code
        if code == 1:
            assert reply[2] == ["TCPROS", "127.0.0.1", victim.tcpros[1]]
        assert caller.call("requestTopic", "/x", "/unpublished", [["TCPROS"]])[0] != 1


@pytest.mark.promise("gives a value or a documented error on *that one* connection")
def test_a_flood_of_every_slave_call(victim: Victim, unharmed: Unharmed) -> None:
    """Eight callers, each with a thousand calls of any method with any arguments: a triple or a fault for each."""
    methods = [
        "getBusStats", "getBusInfo", "getMasterUri", "getName", "getUri", "getPid", "getSubscriptions", "getPublications",
        "paramUpdate", "requestTopic", "shutdown", "publisherUpdate", "nothing", "__init__", "system.multicall",
    ]  # fmt: skip
    values: list[Any] = [
        "/x",
        "",
        "/in",
        0,
        -1,
        True,
        1.5,
        [],
        {},
        [[]],
        b"\xff",
        "~",
        ["http://127.0.0.1:1/"],
        "/" * 50,
    ]
    problems: list[BaseException] = []

    def flood(seed: int) -> None:
        chance = random.Random(seed)
        try:
            with Caller(victim.node) as caller:
                for _ in range(1000):
                    params = [chance.choice(values) for _ in range(chance.randrange(5))]
                    try:
                        reply = caller.call(chance.choice(methods), *params)
                    except Fault:
                        continue
                    assert isinstance(reply, list)
        except BaseException as error:
            problems.append(error)

    with unharmed(threads=60):
        threads = [threading.Thread(target=flood, args=(seed,), daemon=True) for seed in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(120)
            assert not thread.is_alive()
    assert not problems


@pytest.mark.slow
def test_a_flood_of_registrations(victim: Victim, unharmed: Unharmed) -> None:
    """A thousand names with dead, silent and senseless addresses: notifications to them delay nobody."""
    with (
        unharmed(threads=150, memory=96),
        BlackHole() as silent,
        MasterClient(victim.master_uri, "/flood") as client,
    ):
        uris = [silent.uri, "http://127.0.0.1:1/", "http://no.such.host.invalid:1/", "http://[::1]:1/"]
        for number in range(1000):
            for method in ("registerSubscriber", "registerPublisher"):
                try:
                    client._client.call(method, f"/flood{number}", "/flooded", STRING, uris[number % 4])
                except MasterError:
                    pass  # refused is fine as well
        for number in range(1000):
            uri = uris[number % 4]
            client._client.call("unregisterSubscriber", f"/flood{number}", "/flooded", uri)
            client._client.call("unregisterPublisher", f"/flood{number}", "/flooded", uri)
