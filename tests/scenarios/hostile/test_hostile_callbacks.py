"""Programs that misbehave inside: callbacks and handlers that raise or never return, readers that are slow."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from rosproto.codec import message_class
from rosproto.errors import RosTimeout, ServiceError
from rosproto.master import Master
from rosproto.node import Node
from tests.support import attacks
from tests.support.load import crowd
from tests.support.victim import eventually

STRING = "std_msgs/String"


@pytest.fixture(scope="module")
def master() -> Iterator[Master]:
    with Master() as master:
        yield master


@pytest.fixture(params=[False, True], ids=["tcp", "local"])
def nodes(master: Master, request: pytest.FixtureRequest) -> Iterator[tuple[Node, Node]]:
    """A publishing node and a subscribing one."""
    options: Any = {"master_uri": master.uri, "rosout": False, "intraprocess": request.param}
    with Node("/says", **options) as a, Node("/hears", **options) as b:
        yield a, b


class Worse(BaseException):
    """What a careless program raises."""


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt, SystemExit, RecursionError, Worse])
def test_a_callback_that_raises_gets_the_next_message(
    error: type[BaseException], nodes: tuple[Node, Node]
) -> None:
    """The link lives, another subscriber of the topic hears everything."""
    a, b = nodes
    publisher = a.publisher("/raise", STRING)
    called: list[str] = []

    def callback(message: Any) -> None:
        called.append(message.data)
        raise error("no")

    bad = b.subscriber("/raise", STRING, callback)
    fine = b.subscriber("/raise", STRING, queue_size=100)
    publisher.wait_for_connection(60)
    for number in range(20):
        publisher.publish(data=str(number))
    assert [fine.next(60).data for _ in range(20)] == [str(n) for n in range(20)]
    eventually(lambda: called[-1:] == ["19"], what="the last callback")
    assert bad.stats()[0].reconnects == 0


def test_callbacks_about_connections_that_raise(master: Master) -> None:
    """on_connect, on_error, on_event, on_shutdown: logged, and everything goes on."""

    def raises(*_: Any) -> None:
        raise ValueError("no")

    options: Any = {"master_uri": master.uri, "rosout": False, "intraprocess": False, "on_event": raises}
    with Node("/p1", **options) as a, Node("/p2", **options) as b:
        a.on_shutdown(raises)
        publisher = a.publisher("/events", STRING, latch=True, on_connect=raises)
        publisher.publish(data="x")
        wrong = b.subscriber("/events", STRING, on_error=raises)
        assert wrong.next(60).data == "x"
        attacks.connect(
            ("127.0.0.1", a.tcpros_address[1]),
            attacks.subscriber_header("/events", md5sum="0" * 32),
        ).close()
        subscription = b._parts.topics.subscription("/events")
        assert subscription is not None
        subscription.reconnect()
        assert wrong.next(60).data == "x"
    assert a.closed


def test_a_callback_that_never_returns_holds_up_nobody(nodes: tuple[Node, Node]) -> None:
    """Its own queue keeps the newest; other topics, subscribers, services and close() go on."""
    a, b = nodes
    release = threading.Event()
    try:
        publisher, other = a.publisher("/block", STRING, queue_size=1000), a.publisher("/free", STRING)
        a.service_server("/ask", "std_srvs/Empty", lambda request: {})
        stuck = b.subscriber("/block", STRING, lambda message: release.wait(200), queue_size=5)
        free = b.subscriber("/free", STRING, queue_size=1000)
        publisher.wait_for_connection(60)
        other.wait_for_connection(60)
        slowest = 0.0
        for number in range(300):
            began = time.monotonic()
            publisher.publish(data="x" * 1000)
            slowest = max(slowest, time.monotonic() - began)
            other.publish(data=str(number))
        assert [free.next(60).data for _ in range(300)] == [str(n) for n in range(300)]
        b.service_client("/ask", "std_srvs/Empty").call(timeout=60)
        assert slowest < 1.0 * crowd()
        began = time.monotonic()
        stuck.close()
        b.close()
        assert time.monotonic() - began < 8 * crowd()
    finally:
        release.set()


def test_publish_never_waits_for_a_slow_subscriber_and_a_fast_one_gets_all(master: Master) -> None:
    """Big messages, one subscriber that reads nothing, one that reads slowly, one of ours that is quick."""
    with (
        Node("/source", master_uri=master.uri, rosout=False) as a,
        Node("/sink", master_uri=master.uri, rosout=False, intraprocess=False) as b,
    ):
        publisher = a.publisher("/big", "std_msgs/UInt8MultiArray", queue_size=4)
        fast = b.subscriber("/big", "std_msgs/UInt8MultiArray", queue_size=100)
        header = attacks.subscriber_header("/big", type="*", md5sum="*")
        with attacks.many(("127.0.0.1", a.tcpros_address[1]), 12, header) as slow:
            publisher.wait_for_connection(60, 13)
            reading = threading.Thread(target=_sip, args=(slow[0],), daemon=True)
            reading.start()
            data = np.zeros(200_000, "u1")
            slowest = 0.0
            for number in range(60):
                data[:] = number
                began = time.monotonic()
                publisher.publish(data=data)
                slowest = max(slowest, time.monotonic() - began)
                assert fast.next(60).data[-1] == number
            assert slowest < 1.0 * crowd()
            stats = publisher.stats()
            assert sum(link.dropped for link in stats if link.peer == "/attacker") > 300
            assert all(link.queued <= 5 for link in stats)
            assert [link.dropped for link in stats if link.peer == "/sink"] == [0]


def _sip(sock: Any) -> None:
    try:
        while sock.recv(1000):
            time.sleep(0.01)
    except OSError:
        pass  # closed by the test


def test_queue_size_one_is_the_newest(nodes: tuple[Node, Node]) -> None:
    """However many came before: the next message taken is the last one published, and drops are counted."""
    a, b = nodes
    publisher = a.publisher("/newest", STRING, queue_size=100_000)
    subscriber = b.subscriber("/newest", STRING, queue_size=1)
    publisher.wait_for_connection(60)
    for round_ in range(3):
        for number in range(2000):
            publisher.publish(data=f"{round_}:{number}")
        last = f"{round_}:1999"
        eventually(lambda last=last: subscriber.latest is not None and subscriber.latest.data == last)  # type: ignore[misc]
        assert subscriber.next(60).data == last
        with pytest.raises(RosTimeout):
            subscriber.next(0.05)
    assert subscriber.dropped == 3 * 1999


def test_handlers_that_never_return_hold_up_their_own_callers_only(master: Master) -> None:
    """Fifty calls hang; other calls of the same service, its node's topics, and close() do not."""
    release = threading.Event()
    with Node("/server", master_uri=master.uri, rosout=False) as server:
        try:
            server.service_server(
                "/hang",
                "std_srvs/SetBool",
                lambda r: release.wait(200) and {} if r.data else {"message": "ok"},
            )
            server.publisher("/alive", STRING, latch=True).publish(data="yes")
            with Node("/client", master_uri=master.uri, rosout=False, intraprocess=False) as client:
                problems: list[Exception] = []

                def hang() -> None:
                    try:
                        client.service_client("/hang", "std_srvs/SetBool").call(data=True, timeout=1.0)
                    except RosTimeout as error:
                        problems.append(error)

                threads = [threading.Thread(target=hang, daemon=True) for _ in range(50)]
                for thread in threads:
                    thread.start()
                quick = client.service_client("/hang", "std_srvs/SetBool")
                for _ in range(20):
                    assert quick.call(data=False, timeout=60).message == "ok"
                assert client.subscriber("/alive", STRING).next(60).data == "yes"
                for thread in threads:
                    thread.join(120)
                assert len(problems) == 50
            began = time.monotonic()
            server.close()
            assert time.monotonic() - began < 8 * crowd()
        finally:
            release.set()


@pytest.mark.parametrize("error", [ValueError, SystemExit, KeyboardInterrupt, Worse])
def test_handlers_that_raise(error: type[BaseException], master: Master) -> None:
    """The caller gets the text, the next call is answered."""
    with (
        Node("/server", master_uri=master.uri, rosout=False) as server,
        Node("/client", master_uri=master.uri, rosout=False) as client,
    ):

        def handler(request: Any) -> Any:
            if request.data:
                raise error("the reason")
            return {"message": "ok"}

        server.service_server("/raises", "std_srvs/SetBool", handler)
        for persistent in (True, False):
            caller = client.service_client("/raises", "std_srvs/SetBool", persistent=persistent)
            for _ in range(3):
                with pytest.raises(ServiceError, match="the reason"):
                    caller.call(data=True, timeout=60)
                assert caller.call(data=False, timeout=60).message == "ok"


@pytest.mark.parametrize("error", [ValueError, SystemExit])
def test_goal_handlers_and_timers_that_raise(error: type[BaseException], master: Master) -> None:
    """The goal is aborted with the text, the next one succeeds; feedback callbacks and timers go on."""
    from rosproto.action import ActionClient, ActionServer

    def handler(goal: Any) -> None:
        goal.publish_feedback(message_class("actionlib/TestFeedback")())
        if goal.goal.goal == 0:
            raise error("the reason")
        goal.succeed(message_class("actionlib/TestResult")())

    def raises(*_: Any) -> None:
        raise error("no")

    ticks: list[int] = []
    with (
        Node("/acts", master_uri=master.uri, rosout=False) as server,
        Node("/asks", master_uri=master.uri, rosout=False) as client,
        ActionServer(server, "/raising", "actionlib/Test", handler),
        ActionClient(client, "/raising", "actionlib/Test") as asking,
        client.clock.timer(0.01, lambda event: (ticks.append(1), raises())),
    ):
        asking.wait_for_server(10)
        bad = asking.send_goal(asking.type.goal(goal=0), feedback=raises, transition=raises)
        bad.wait(60)
        assert bad.status.name == "ABORTED"
        assert "the reason" in bad.text
        good = asking.send_goal(asking.type.goal(goal=1))
        good.wait(60)
        eventually(lambda: len(ticks) > 3)
