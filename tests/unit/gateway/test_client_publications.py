"""The first messages of a client's publication, which subscribers may still miss."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest

from rosproto.codec import message_class
from rosproto.gateway.client_publications import ClientPublications
from rosproto.gateway.velocity_watchdog import VelocityWatchdog
from rosproto.master import Master
from rosproto.node import Node, Publisher

Int32 = message_class("std_msgs/Int32")


@pytest.fixture
def nodes() -> Iterator[tuple[Node, Node]]:
    with (
        Master() as master,
        Node("/gateway", master_uri=master.uri, rosout=False, intraprocess=False) as gateway,
        Node("/robot", master_uri=master.uri, rosout=False, intraprocess=False) as robot,
    ):
        yield gateway, robot


def test_a_subscriber_that_has_just_connected_gets_the_missed_messages_first(
    nodes: tuple[Node, Node], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also when the client publishes before the notice of the connection is handled."""
    gateway, robot = nodes
    publishers: list[Publisher] = []
    handle = threading.Event()
    real = gateway.publisher

    def publisher(*args: object, on_connect: object, **options: object) -> Publisher:
        def late(caller_id: str) -> None:
            assert handle.wait(20)
            on_connect(caller_id)  # type: ignore[operator]

        publishers.append(real(*args, on_connect=late, **options))  # type: ignore[arg-type]
        return publishers[0]

    monkeypatch.setattr(gateway, "publisher", publisher)
    monkeypatch.setattr("rosproto.gateway.client_publications.EARLY_SECONDS", 60.0)
    publications = ClientPublications(gateway, VelocityWatchdog())
    publication = publications.open("a client", "/count", Int32)
    for number in range(3):
        publication.publish(Int32(data=number))
    heard = robot.subscriber("/count", Int32, queue_size=100)
    publishers[0].wait_for_connection(20)
    publication.publish(Int32(data=3))
    handle.set()
    publication.publish(Int32(data=4))
    assert [heard.next(10).data for _ in range(5)] == list(range(5))
    publications.close()
