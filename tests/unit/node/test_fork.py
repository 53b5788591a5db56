"""A fork while a node is open: the node stays its parent's, and the child can open its own."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")

OPEN = """
import os, signal, sys, warnings
warnings.simplefilter("ignore", DeprecationWarning)  # from 3.12 on Python itself warns of threads and fork
import rosproto
from rosproto import LocalProtocolError, RosError

def child(body):
    # Runs `body` in a fork that ends as programs end, with atexit; its exit code.
    sys.stdout.flush()
    pid = os.fork()
    if pid:
        return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    signal.alarm(20)  # rather than hang
    body()
    sys.exit(7)

def refused(what, *arguments, **more):
    try:
        what(*arguments, **more)
    except RosError as error:
        return str(error)
    raise AssertionError(f"{what} was carried out")

def serve(request):
    return {"success": True, "message": str(os.getpid() == parent)}

parent = os.getpid()
master = rosproto.Master()
talker = rosproto.Node("/talker", master_uri=master.uri, intraprocess=False)
listener = rosproto.Node("/listener", master_uri=master.uri, intraprocess=False)
publisher = talker.publisher("/words", "std_msgs/String")
subscriber = listener.subscriber("/words", "std_msgs/String")
server = talker.service_server("/serve", "std_srvs/SetBool", serve)
client = listener.service_client("/serve", "std_srvs/SetBool", persistent=True)
publisher.wait_for_connection(20)
client.call(data=True, timeout=10)
links = [link.id for link in publisher._publication.all_links]
"""
CLOSE = """
# Nothing of the parent's was touched: the same connection, the same registrations.
assert [link.id for link in publisher._publication.all_links] == links
publisher.publish(data="after")
assert subscriber.next(20).data == "after"
assert client.call(data=True, timeout=10).message == "True"
assert master.stats()["registrations"] == before, master.stats()
listener.close(); talker.close(); master.close()
print("whole")
"""


def run(body: str) -> str:
    code = OPEN + 'before = master.stats()["registrations"]\n' + body + CLOSE
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Traceback" not in done.stderr, done.stderr
    assert done.stdout.endswith("whole\n"), done.stdout
    return done.stdout


def test_a_child_that_closes_and_ends_takes_nothing_with_it() -> None:
    """`with` blocks unwound, objects closed and `atexit` run in the child: the parent does not notice."""
    run(
        "def body():\n"
        "    for opened in (client, server, subscriber, publisher, listener, talker, master):\n"
        "        opened.close()\n"
        "    assert talker.closed\n"
        "assert child(body) == 7\n"
        "assert child(lambda: None) == 7\n"
    )


def test_a_child_that_goes_on_with_its_parents_node_is_told() -> None:
    """Both would write into one connection, and no thread of the library lives in the child."""
    shown = run(
        "def body():\n"
        "    print(refused(publisher.publish, data='mixed up'))\n"
        "    print(refused(subscriber.next, 5))\n"
        "    print(refused(client.call, data=True, timeout=5))\n"
        "    print(refused(talker.publisher, '/other', 'std_msgs/String'))\n"
        "    print(refused(lambda: talker.params['/run_id']))\n"
        "assert child(body) == 7\n"
    )
    assert shown.count(" closed") == 5, shown
    assert "/talker is closed (it was opened by another process" in shown


def test_a_chassis_in_a_child_says_why_nothing_comes() -> None:
    """At once, not after the time for waiting; closing it leaves the parent's."""
    run(
        "from woosh_pure import Chassis\n"
        "chassis = Chassis(master.uri)\n"
        "battery = chassis.battery.open()\n"
        "before = master.stats()['registrations']\n"
        "def body():\n"
        "    assert 'is a fork of it' in refused(battery.wait, None)\n"
        "    chassis.close()\n"
        "assert child(body) == 7\n"
    )


def test_a_child_opens_a_node_of_its_own() -> None:
    """It reaches its parent's nodes over the network, also those that speak without sockets to each other."""
    shown = run(
        "def body():\n"
        "    with rosproto.Node('/child', master_uri=master.uri) as node:\n"
        "        with node.subscriber('/near', 'std_msgs/String') as heard:\n"
        "            print(heard.next(20).data)\n"
        "        with node.service_client('/serve', 'std_srvs/SetBool') as ask:\n"
        "            print(ask.call(data=True, timeout=10).message)\n"
        "with rosproto.Node('/near', master_uri=master.uri) as near:\n"
        "    near.publisher('/near', 'std_msgs/String', latch=True).publish(data='hello child')\n"
        "    assert child(body) == 7\n"
    )
    assert "hello child\nTrue\n" in shown
