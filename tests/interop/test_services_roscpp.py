"""Services with roscpp: it calls ours, we call its."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosproto.codec import service_class
from rosproto.errors import ConnectionLost, Md5sumMismatch, ServiceError
from rosproto.node import Node
from tests.support import ros

SetBool = service_class("std_srvs/SetBool")
Trigger = service_class("std_srvs/Trigger")


def test_we_call_roscpp(any_master: str, roscpp_peer: Path) -> None:
    with (
        Node("/ours_node", master_uri=any_master) as node,
        ros.start_program(roscpp_peer, any_master, "service_server") as server,
    ):
        node.wait_for_service("/set", timeout=60)
        server.wait_for("ready")
        for persistent in (False, True):
            with node.service_client("/set", SetBool, persistent=persistent) as client:
                assert [client.call(data=True).message for _ in range(3)] == ["set"] * 3
                with pytest.raises(ServiceError, match="the wheel is off"):
                    client.call(data=False)
                assert client.call(data=True).success
                assert client.stats()["connects"] == (1 if persistent else 5)
        with pytest.raises(ServiceError):
            node.service_client("/refuse", SetBool).call(data=True)
        with pytest.raises(Md5sumMismatch) as mismatch:
            node.service_client("/set", Trigger).call()
        assert (mismatch.value.md5sum, mismatch.value.remote_md5sum) == (Trigger._md5sum, SetBool._md5sum)
        with pytest.raises(ConnectionLost):
            node.service_client("/die", "std_srvs/Empty").call(timeout=60)


def test_roscpp_calls_us(any_master: str, roscpp_peer: Path) -> None:
    def handler(request):
        if not request.data:
            raise RuntimeError("not today")
        return True, "ours"

    with Node("/ours_node", master_uri=any_master) as node:
        server = node.service_server("/ours", SetBool, handler)
        with ros.start_program(roscpp_peer, any_master, "service_client") as client:
            client.wait_for("^done")
            lines = client.output.splitlines()
        for persistent in (0, 1):
            for i in range(4):
                expected = f"call {persistent} {i} 0 " if i == 2 else f"call {persistent} {i} 1 ours"
                assert expected in lines
        assert "wait 1" in lines
        assert "valid 1 1" in lines
        assert "wrong 0" in lines
        assert "not today" in client.output
        assert server.stats()["calls"] == 8
        assert server.stats()["errors"] == 2
