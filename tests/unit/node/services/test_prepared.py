"""A call that is ready before it is needed: its connection stands, its request is encoded."""

from __future__ import annotations

import sys
import threading

import pytest

from rosproto.errors import ConnectionLost, RosError, RosTimeout, ServiceError
from tests.support.waiting import until
from tests.unit.node.services.provided import SetBool, tell


def test_it_is_sent_once_and_answered(node):
    asked = []
    node.service_server("/set", SetBool, lambda request: asked.append(request.data) or tell(request))
    with node.service_client("/set", SetBool) as client:
        prepared = client.prepare(data=True)
        assert asked == []
        assert prepared.usable
        with pytest.raises(ConnectionLost, match="nothing was sent"):
            prepared.answer(1.0)
        assert prepared.send()
        assert prepared.send()
        assert prepared.answer(20.0).message == "data=True"
        assert prepared.answer(0.0).message == "data=True"
        assert asked == [True]
        assert not prepared.usable
        assert client.call(data=False).message == "data=False"  # the client goes on as before


def test_sending_makes_nothing(node):
    node.service_server("/set", SetBool, tell)
    prepared = node.service_client("/set", SetBool).prepare(data=True)
    seen: list[str] = []
    looking = [True]
    me = threading.get_ident()
    sys.addaudithook(
        lambda event, _: seen.append(event) if looking[0] and threading.get_ident() == me else None
    )
    prepared.send()
    looking[0] = False
    assert [event for event in seen if event.startswith(("open", "import", "socket", "_thread"))] == []
    assert prepared.answer(20.0).success


def test_a_provider_that_says_no_and_one_that_says_nothing(node):
    release = threading.Event()

    def refuse(request):
        if request.data:
            raise ValueError("not now")
        release.wait(20.0)
        return tell(request)

    node.service_server("/set", SetBool, refuse)
    client = node.service_client("/set", SetBool)
    no, late = client.prepare(data=True), client.prepare(data=False)
    assert no.send()
    with pytest.raises(ServiceError, match="not now"):
        no.answer(20.0)
    assert late.send()
    with pytest.raises(RosTimeout):
        late.answer(0.1)
    release.set()


def test_without_a_provider_nothing_is_prepared_and_a_dead_connection_sends_nothing(node):
    client = node.service_client("/set", SetBool)
    with pytest.raises(ServiceError):
        client.prepare(data=True)
    server = node.service_server("/set", SetBool, tell)
    prepared = client.prepare(data=True)
    server.close()
    until(lambda: not prepared.usable, what="the end of the connection")
    if prepared.send():  # the system may take what nobody reads
        with pytest.raises(RosError):
            prepared.answer(1.0)


def test_closing_the_client_ends_it(node):
    node.service_server("/set", SetBool, tell)
    client = node.service_client("/set", SetBool)
    prepared = client.prepare(data=True)
    client.close()
    assert not prepared.send()
