"""What clients and servers of services offer beside the call: header fields, refusals, an end from outside."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Mapping
from queue import SimpleQueue
from typing import Any

import pytest

from rosproto.codec import service_class
from rosproto.errors import ConnectionLost, Md5sumMismatch, RemoteProtocolError
from rosproto.master import Master
from rosproto.node import Node
from rosproto.node.services.link import Cancellation

SetBool, Trigger = service_class("std_srvs/SetBool"), service_class("std_srvs/Trigger")


@pytest.fixture
def pair() -> Iterator[tuple[Node, Node]]:
    with (
        Master() as master,
        Node("/client", master_uri=master.uri, rosout=False) as client,
        Node("/server", master_uri=master.uri, rosout=False) as server,
    ):
        yield client, server


def test_fields_of_the_header_are_told_from_the_next_connection_on(pair: tuple[Node, Node]) -> None:
    a, b = pair
    seen: list[Mapping[str, str]] = []

    def handle(request: Any) -> Any:
        seen.append(request._connection_header)
        return SetBool.Response(success=True)

    b.service_server("/s", SetBool, handle)
    with a.service_client("/s", SetBool) as client:
        client.call(data=True)
        client.add_headers({"cookies": "oatmeal"})
        client.call(data=True)
    assert [header.get("cookies") for header in seen] == [None, "oatmeal"]
    assert seen[1]["callerid"] == "/client"


def test_a_server_tells_whom_it_refused(pair: tuple[Node, Node]) -> None:
    """With the header of the client, and why; the client gets its error, maybe before."""
    a, b = pair
    refused: SimpleQueue[tuple[Mapping[str, str], RemoteProtocolError]] = SimpleQueue()
    server = b.service_server("/s", Trigger, lambda request: Trigger.Response(success=True))
    server.on_refused = lambda header, error: refused.put((header, error))
    with a.service_client("/s", SetBool) as client, pytest.raises(Md5sumMismatch):
        client.call(data=True)
    header, error = refused.get(timeout=20)
    assert (header["callerid"], header["md5sum"]) == ("/client", SetBool._md5sum)
    assert isinstance(error, Md5sumMismatch)
    assert server.stats()["calls"] == 0


@pytest.mark.parametrize("persistent", [False, True], ids=["one-shot", "persistent"])
def test_a_call_can_be_ended_from_outside(pair: tuple[Node, Node], persistent: bool) -> None:
    """The caller goes on at once, and so does the client; the server finishes what it began."""
    a, b = pair
    came, go_on = threading.Event(), threading.Event()

    def handle(request: Any) -> Any:
        if request.data:
            came.set()
            go_on.wait(20)
        return SetBool.Response(success=request.data)

    b.service_server("/s", SetBool, handle)
    with a.service_client("/s", SetBool, persistent=persistent) as client:
        cancellation = Cancellation()

        def cancel() -> None:
            came.wait(20)
            cancellation.cancel()

        thread = threading.Thread(target=cancel)
        thread.start()
        try:
            with pytest.raises(ConnectionLost):
                client.call_cancellable(cancellation, data=True, timeout=20)
            assert came.is_set()
            assert client.call_cancellable(Cancellation(), data=False, timeout=20).success is False
        finally:
            go_on.set()
            thread.join(20)


def test_a_call_that_was_ended_before_is_not_sent(pair: tuple[Node, Node]) -> None:
    a, b = pair
    server = b.service_server("/s", SetBool, lambda request: SetBool.Response(success=True))
    cancellation = Cancellation()
    cancellation.cancel()
    with (
        a.service_client("/s", SetBool) as client,
        pytest.raises(ConnectionLost, match="cancelled before its request was sent"),
    ):
        client.call_cancellable(cancellation, data=True)
    assert server.stats()["calls"] == 0
