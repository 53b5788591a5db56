"""Services with roscpp (C++ built in the test): it calls ours, we call its."""

from __future__ import annotations

import pytest

from rosproto.codec import service_class
from rosproto.errors import ConnectionLost, Md5sumMismatch, ServiceError
from rosproto.node import Node
from tests.support import ros

SetBool = service_class("std_srvs/SetBool")
Trigger = service_class("std_srvs/Trigger")

SERVER = r"""
#include <ros/ros.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Empty.h>
#include <cstdlib>
bool set(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response) {
  if (!request.data) throw std::runtime_error("the wheel is off");
  response.success = true;
  response.message = "set";
  return true;
}
bool refuse(std_srvs::SetBool::Request&, std_srvs::SetBool::Response&) { return false; }
bool die(std_srvs::Empty::Request&, std_srvs::Empty::Response&) { _exit(0); }
int main(int argc, char** argv) {
  ros::init(argc, argv, "roscpp_server");
  ros::NodeHandle node;
  auto a = node.advertiseService("/set", set);
  auto b = node.advertiseService("/refuse", refuse);
  auto c = node.advertiseService("/die", die);
  puts("ready"); fflush(stdout);
  ros::spin();
}
"""

CLIENT = r"""
#include <ros/ros.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>
int main(int argc, char** argv) {
  ros::init(argc, argv, "roscpp_client");
  ros::NodeHandle node;
  printf("wait %d\n", (int)ros::service::waitForService("/ours", 20000));
  for (int persistent = 0; persistent < 2; ++persistent) {
    ros::ServiceClient client = node.serviceClient<std_srvs::SetBool>("/ours", persistent);
    for (int i = 0; i < 4; ++i) {
      std_srvs::SetBool call;
      call.request.data = (i != 2);
      bool ok = client.call(call);
      printf("call %d %d %d %s\n", persistent, i, (int)ok, call.response.message.c_str());
    }
    printf("valid %d %d\n", persistent, (int)client.isValid());
  }
  std_srvs::Trigger wrong;
  printf("wrong %d\n", (int)ros::service::call("/ours", wrong));
  puts("done"); fflush(stdout);
}
"""


def test_we_call_roscpp(any_master, build_roscpp):
    program = build_roscpp("service_server", SERVER)
    with Node("/ours_node", master_uri=any_master) as node, ros.start_program(program, any_master) as server:
        node.wait_for_service("/set", timeout=30.0)
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
            node.service_client("/die", "std_srvs/Empty").call(timeout=30.0)


def test_roscpp_calls_us(any_master, build_roscpp):
    def handler(request):
        if not request.data:
            raise RuntimeError("not today")
        return True, "ours"

    program = build_roscpp("service_client", CLIENT)
    with Node("/ours_node", master_uri=any_master) as node:
        server = node.service_server("/ours", SetBool, handler)
        with ros.start_program(program, any_master) as client:
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
