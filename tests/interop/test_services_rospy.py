"""Services with rospy: it calls ours, we call its; errors, persistence, wrong definitions, probes."""

from __future__ import annotations

import json
from collections.abc import Iterator

import pytest

from rosproto.codec import service_class
from rosproto.errors import ConnectionLost, Md5sumMismatch, ServiceError
from rosproto.node import Node
from tests.support import ros

SetBool = service_class("std_srvs/SetBool")
Trigger = service_class("std_srvs/Trigger")

SERVER = r"""
import os, rospy
from std_srvs.srv import SetBool, SetBoolResponse, Empty, EmptyResponse
rospy.init_node("rospy_server", disable_signals=True)
def set_bool(request):
    if request.data:
        return SetBoolResponse(True, "set to %s" % request.data)
    raise ValueError("not \xfc today")
rospy.Service("/set", SetBool, set_bool)
rospy.Service("/refuse", SetBool, lambda request: None)
rospy.Service("/empty", Empty, lambda request: EmptyResponse())
rospy.Service("/long", SetBool, lambda request: SetBoolResponse(True, "x" * 300000))
rospy.Service("/die", Empty, lambda request: os._exit(0))
print("ready", flush=True)
rospy.spin()
"""

CLIENT = r"""
import json, sys, time
import rospy
from std_srvs.srv import SetBool, Trigger, Empty
rospy.init_node("rospy_client", disable_signals=True)
out = {}
rospy.wait_for_service("/ours", timeout=60)
for persistent in (False, True):
    proxy = rospy.ServiceProxy("/ours", SetBool, persistent=persistent)
    answers = [proxy(True).message for _ in range(3)]
    errors = []
    for _ in range(2):
        try:
            proxy(False)
        except rospy.ServiceException as error:
            errors.append(str(error))
    after = proxy(True).message
    out["persistent" if persistent else "once"] = [answers, errors, after]
try:
    rospy.ServiceProxy("/ours", Trigger)()
except rospy.ServiceException as error:
    out["mismatch"] = str(error)
out["empty"] = str(rospy.ServiceProxy("/empty", Empty)())
out["long"] = len(rospy.ServiceProxy("/long", SetBool)(True).message)
print(json.dumps(out))
"""


@pytest.fixture
def node(any_master: str) -> Iterator[Node]:
    with Node("/ours_node", master_uri=any_master) as ours:
        yield ours


def test_we_call_rospy(node, any_master, genpy_packages):
    with ros.start_rospy(SERVER, any_master, packages=genpy_packages) as server:
        node.wait_for_service("/set", timeout=60)
        server.wait_for("ready")
        for persistent in (False, True):
            with node.service_client("/set", SetBool, persistent=persistent) as client:
                assert [client.call(data=True).message for _ in range(3)] == ["set to True"] * 3
                with pytest.raises(ServiceError) as caught:
                    client.call(data=False)
                assert caught.value.text == "error processing request: not \xfc today"
                assert client.call(data=True).success
                assert client.stats()["connects"] == (1 if persistent else 5)
        with pytest.raises(ServiceError, match="service handler returned None"):
            node.service_client("/refuse", SetBool).call(data=True)
        node.service_client("/empty", "std_srvs/Empty").call()
        assert len(node.service_client("/long", None).call(data=True).message) == 300_000
        with pytest.raises(Md5sumMismatch) as mismatch:
            node.service_client("/set", Trigger).call()
        assert (mismatch.value.md5sum, mismatch.value.remote_md5sum) == (Trigger._md5sum, SetBool._md5sum)
        assert mismatch.value.remote_type == "std_srvs/SetBool"

        kept = node.service_client("/set", SetBool, persistent=True)
        kept.call(data=True)
        with pytest.raises(ConnectionLost):
            node.service_client("/die", "std_srvs/Empty").call(timeout=60)
        server.wait(60)
        with pytest.raises(ConnectionLost):
            kept.call(data=True, timeout=60)


def test_rospy_calls_us(node, any_master, genpy_packages, caplog):
    def handler(request):
        if not request.data:
            raise RuntimeError("no \xfc")
        return True, f"from {request._connection_header['callerid']}"

    node.service_server("/ours", SetBool, handler)
    node.service_server("/empty", "std_srvs/Empty", lambda request: None)
    node.service_server("/long", SetBool, lambda request: (True, "y" * 400_000))
    answers = json.loads(ros.run_rospy(CLIENT, any_master, packages=genpy_packages).stdout.splitlines()[-1])
    for kind in ("once", "persistent"):
        said, errors, after = answers[kind]
        assert said == ["from /rospy_client"] * 3
        assert after == "from /rospy_client"
        assert all("RuntimeError: no" in error for error in errors)
    assert SetBool._md5sum in answers["mismatch"]
    assert Trigger._md5sum in answers["mismatch"]
    assert answers["empty"] == ""
    assert answers["long"] == 400_000
    complaints = [r.getMessage() for r in caplog.records if r.levelname == "WARNING" and "rosproto" in r.name]
    assert all("md5sum" in text for text in complaints), complaints


def test_a_restarted_rospy_provider_is_found_again(node, any_master, genpy_packages):
    client = node.service_client("/set", SetBool)
    kept = node.service_client("/set", SetBool, persistent=True)
    for _ in range(2):
        with ros.start_rospy(SERVER, any_master, packages=genpy_packages) as server:
            server.wait_for("ready")
            assert client.call(data=True, timeout=60).success
            assert kept.call(data=True, timeout=60).success
            server.kill()
