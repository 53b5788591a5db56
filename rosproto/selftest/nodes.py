"""Check a master and two nodes on this machine: a topic, a service, a parameter, an action."""

from __future__ import annotations

import threading
from typing import Any

from rosproto.selftest.checking import CheckFailed
from rosproto.sentence import say

_WAIT = 5.0  # seconds for each step: on one machine each takes milliseconds


def expect(what: str, found: object, wanted: object) -> None:
    """Raise CheckFailed if the two differ."""
    if found != wanted:
        raise CheckFailed(
            say("{what}: {found!r} came, expected {wanted!r}", what=what, found=found, wanted=wanted)
        )


def check_master() -> str:
    """Call a master over HTTP, as other programs do."""
    from rosproto.master import Master
    from rosproto.node import MasterClient

    with Master(host="127.0.0.1", port=0) as master, MasterClient(master.uri, "/selftest") as client:
        client.set_param("/selftest", [1, 2.5, "三"])
        expect("a parameter", client.get_param("/selftest"), [1, 2.5, "三"])
        client.register_publisher("/selftest", "std_msgs/String", "http://127.0.0.1:1/")
        expect("the topics", client.get_topic_types(), {"/selftest": "std_msgs/String"})
        return say("it answered at {uri}", uri=master.uri)


def check_nodes() -> str:
    """Let two nodes of this process communicate over real sockets."""
    from rosproto.master import Master
    from rosproto.node import Node

    with (
        Master(host="127.0.0.1", port=0) as master,
        Node("/selftest_a", master_uri=master.uri, host="127.0.0.1", rosout=False) as one,
        Node("/selftest_b", master_uri=master.uri, host="127.0.0.1", rosout=False) as other,
    ):
        _topic(one, other)
        _service(one, other)
        one.params["/selftest/number"] = 42
        expect("a parameter", other.params["/selftest/number"], 42)
        _action(one, other)
    return "a topic, a service, a parameter and an action between two nodes"


def _topic(one: Any, other: Any) -> None:
    heard: list[bytes] = []
    came = threading.Event()

    def hear(message: Any) -> None:
        heard.append(bytes(message.data))
        came.set()

    image = bytes(range(256)) * 4096  # 1 MiB: more than a socket takes at once
    with (
        other.subscriber("/selftest/data", "std_msgs/UInt8MultiArray", callback=hear),
        one.publisher("/selftest/data", "std_msgs/UInt8MultiArray", queue_size=2) as publisher,
    ):
        publisher.wait_for_connection(timeout=_WAIT)
        publisher.publish(data=image)
        if not came.wait(_WAIT):
            raise CheckFailed(say("a message did not arrive within {seconds:g} s", seconds=_WAIT))
    expect("a message of 1 MiB", len(heard[0]), len(image))
    expect("the message's bytes", heard[0] == image, True)


def _service(one: Any, other: Any) -> None:
    def answer(request: Any) -> dict[str, object]:
        return {"success": request.data, "message": "好"}

    with (
        one.service_server("/selftest/set", "std_srvs/SetBool", answer),
        other.service_client("/selftest/set", "std_srvs/SetBool") as client,
    ):
        reply = client.call(data=True, timeout=_WAIT)
    expect("a service's answer", (reply.success, reply.message), (True, "好"))


def _action(one: Any, other: Any) -> None:
    from rosproto.action import ActionClient, ActionServer

    def work(goal: Any) -> None:
        goal.succeed({"result": goal.goal.goal * 2})

    with (
        ActionServer(one, "/selftest/work", "actionlib/TestAction", work),
        ActionClient(other, "/selftest/work", "actionlib/TestAction") as client,
    ):
        client.wait_for_server(timeout=_WAIT)
        handle = client.send_goal({"goal": 21})
        expect("an action's result", handle.wait(timeout=_WAIT).result, 42)
