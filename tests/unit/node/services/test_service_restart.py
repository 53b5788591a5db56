"""Services and parameter subscriptions of a node come back by themselves when its master restarts."""

from __future__ import annotations

import threading
import time

from rosproto.master import Master
from rosproto.node import Node
from tests.support.ports import unused_port


def test_after_a_restart_of_the_master_services_are_found_and_parameters_followed():
    changed, seen = threading.Event(), []

    def told(key, value):
        seen.append((key, value))
        if value == "new":
            changed.set()

    port = unused_port()
    with Master(port=port) as first:
        uri = first.uri
        node = Node("/provider", master_uri=uri, rosout=False)
        caller = Node("/caller", master_uri=uri, rosout=False)
        node.service_server("/set", "std_srvs/SetBool", lambda request: (request.data, "here"))
        kept = caller.service_client("/set", "std_srvs/SetBool", persistent=True)
        assert kept.call(data=True).success
        caller.params["/robot"] = "old"
        subscription = node.params.subscribe("/robot", told)
        assert subscription.value == "old"
    with node, caller:
        assert kept.call(data=True, timeout=20).success  # an open link needs no master
        with Master(port=port):
            caller.wait_for_service("/set", timeout=20.0)
            assert caller.service_client("/set", "std_srvs/SetBool").call(data=True).message == "here"
            deadline = time.monotonic() + 20
            while not changed.is_set() and time.monotonic() < deadline:
                caller.params["/robot"] = "new"
                changed.wait(0.1)
            assert subscription.value == "new"
            assert ("/robot", None) in seen or seen == [("/robot", "new")]
