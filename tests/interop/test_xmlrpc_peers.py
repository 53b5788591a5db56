"""XML-RPC with other implementations: Python's own, Debian's rosmaster (Python), and roscpp nodes (C++)."""

from __future__ import annotations

import threading
import xmlrpc.client as stdlib_client
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from xmlrpc.server import SimpleXMLRPCRequestHandler, SimpleXMLRPCServer

import pytest

from rosproto.errors import MasterError, RemoteProtocolError
from rosproto.protocol import xmlrpc
from rosproto.transport import XmlRpcClient, XmlRpcServer, unpack
from tests.support import ros

VALUES = [
    "",
    "  blanks  ",
    "<&>\"' ]]>",
    "line\nline\ttab",
    "Grüße 机器人 😀",
    0,
    -(2**31),
    2**31 - 1,
    True,
    False,
    0.1,
    -1.5e-300,
    1.7976931348623157e308,
    [],
    [1, [2.5, [True, "x"]], []],
    {"a": 1, "b": {"c": [1, 2], "d": "text"}},
]


def same(one: object, other: object) -> bool:
    return one == other and repr(one) == repr(other)


# -- Python's xmlrpc


def test_pythons_client_gets_back_what_it_sends_and_keeps_its_connection() -> None:
    def echo(_method: str, params: list[object], _peer: str) -> object:
        return params

    with XmlRpcServer("127.0.0.1", 0, echo) as server, stdlib_client.ServerProxy(server.uri) as proxy:
        for value in VALUES:
            assert same(proxy.echo(value), [value])
        assert proxy.echo(stdlib_client.Binary(b"\0\xff"))[0].data == b"\0\xff"
        assert server.stats.accepted == 1


def test_pythons_multicall_and_faults_are_understood() -> None:
    def dispatch(method: str, params: list[object], _peer: str) -> object:
        if method == "bad":
            raise xmlrpc.Fault(5, "no")
        return [1, method, params]

    with XmlRpcServer("127.0.0.1", 0, dispatch) as server, stdlib_client.ServerProxy(server.uri) as proxy:
        with pytest.raises(stdlib_client.Fault, match="5: 'no'"):
            proxy.bad()
        calls = stdlib_client.MultiCall(proxy)
        calls.unregisterPublisher("/me", "/topic")
        calls.bad()
        results = calls()
        assert results[0] == [1, "unregisterPublisher", ["/me", "/topic"]]
        with pytest.raises(stdlib_client.Fault, match="5: 'no'"):
            results[1]


@pytest.mark.parametrize("version", ["HTTP/1.0", "HTTP/1.1"])
def test_our_client_gets_back_what_it_sends_to_pythons_server(version: str) -> None:
    class Handler(SimpleXMLRPCRequestHandler):
        protocol_version = version

        def log_message(self, *_: object) -> None: ...

    with SimpleXMLRPCServer(("127.0.0.1", 0), Handler) as server:
        server.register_function(lambda *values: list(values), "echo")
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        try:
            with XmlRpcClient(f"http://127.0.0.1:{server.server_address[1]}/") as client:
                for value in VALUES:
                    assert same(client.call("echo", value), [value])
                with pytest.raises(MasterError, match="not supported"):
                    client.call("nothing")
        finally:
            server.shutdown()
            thread.join(5)


# -- Debian's rosmaster


def test_rosmaster_keeps_parameters_of_every_type(real_roscore: str) -> None:
    with XmlRpcClient(real_roscore) as client:
        for value in VALUES:
            unpack("setParam", client.call("setParam", "/me", "/value", value))
            assert same(unpack("getParam", client.call("getParam", "/me", "/value")), value)
        for name in ("/b", "/bytes"):
            unpack("setParam", client.call("setParam", "/me", name, b"\0\xff"))
            assert unpack("getParam", client.call("getParam", "/me", name)) == b"\0\xff"


def test_rosmasters_refusals_and_faults_are_master_errors(real_roscore: str) -> None:
    with XmlRpcClient(real_roscore) as client:
        with pytest.raises(MasterError, match="is not set") as caught:
            unpack("getParam", client.call("getParam", "/me", "/nothing"), real_roscore)
        assert caught.value.code == -1
        with pytest.raises(MasterError):
            client.call("noSuchMethod")
        with pytest.raises(RemoteProtocolError, match="404"), XmlRpcClient(real_roscore + "foo") as other:
            other.call("getPid", "/me")


def test_rosmasters_multicall_is_used(real_roscore: str) -> None:
    with XmlRpcClient(real_roscore) as client:
        calls = [{"methodName": "getUri", "params": ["/me"]}, {"methodName": "nothing", "params": []}]
        results = client.call("system.multicall", calls)
        assert isinstance(results, list)
        assert unpack("getUri", results[0][0])
        assert "faultCode" in results[1]


# -- roscpp, through a master that passes every call on to rosmaster


@contextmanager
def passing_on(uri: str) -> Iterator[tuple[str, list[str]]]:
    """URI of our server in front of a real master, and the methods that were called."""
    methods: list[str] = []
    with XmlRpcClient(uri) as client:

        def dispatch(method: str, params: list[object], _peer: str) -> object:
            methods.append(method)
            return client.call(method, *params)

        with XmlRpcServer("127.0.0.1", 0, dispatch, name="between") as server:
            yield server.uri, methods


def test_roscpp_reads_and_writes_every_type(roscpp_peer: Path, real_roscore: str) -> None:
    values = {f"v{number}": value for number, value in enumerate([*VALUES, b"\0\xff"])}
    with passing_on(real_roscore) as (uri, methods), XmlRpcClient(uri) as client:
        client.call("setParam", "/me", "/names", sorted(values))
        for name, value in values.items():
            client.call("setParam", "/me", f"/in/{name}", value)
        with ros.start_program(roscpp_peer, uri, "parameter_echo") as running:
            running.wait_for("done")
            assert "cannot read" not in running.output
            back = unpack("getParam", client.call("getParam", "/me", "/out"))
            assert isinstance(back, dict)
            for name, value in values.items():
                assert same(back[name], value), name
            _ask_roscpp_slave(client)
            running.interrupt()
            running.wait()
        assert {"registerPublisher", "unregisterPublisher", "getParam", "setParam"} <= set(methods)


def _ask_roscpp_slave(master: XmlRpcClient) -> None:
    """The slave API of the running roscpp node answers; getBusStats is malformed and still read."""
    uri = unpack("lookupNode", master.call("lookupNode", "/me", "/parameter_echo"))
    assert isinstance(uri, str)
    with XmlRpcClient(uri) as slave:
        assert unpack("getPid", slave.call("getPid", "/me"))
        assert unpack("getPublications", slave.call("getPublications", "/me")) == [
            ["/rosout", "rosgraph_msgs/Log"]
        ]
        slave.call("getBusStats", "/me")
        assert unpack("getBusInfo", slave.call("getBusInfo", "/me")) == []
        reply = unpack("requestTopic", slave.call("requestTopic", "/me", "/rosout", [["UDPX"], ["TCPROS"]]))
        assert isinstance(reply, list)
        assert reply[0] == "TCPROS"
        with pytest.raises(MasterError):
            slave.call("noSuchMethod")
