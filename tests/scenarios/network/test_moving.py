"""The laptop moves: another address, no address for a while, the cable out and in; and a network with IPv6 only."""

from __future__ import annotations

import pytest

from tests.scenarios.network.conftest import (
    FRESH,
    LINK_SECONDS,
    MASTER,
    MASTER_SECONDS,
    Network,
    heard_again,
    soon,
    start_laptop,
    start_robot,
    wait,
)
from tests.support.hosts import LAPTOP, LAPTOP6, ROBOT, ROBOT6, two_hosts
from tests.support.load import crowd
from tests.support.ros import PYTHON, environment, require_ros

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("without", [0.0, 3.0], ids=["at once", "after three seconds without one"])
def test_another_address(without: float, connected: Network) -> None:
    """Wi-Fi roam, DHCP: the node listens on the new address, registers it, and is heard; nothing comes late."""
    robot, laptop, _ = connected
    laptop.run("ip", "address", "flush", "dev", laptop.device)
    wait(without)
    laptop.set_addresses("10.77.0.33/24")
    there = wait(0.0)
    assert heard_again(laptop.python, there) < soon(MASTER_SECONDS)
    assert heard_again(robot.python, there) < soon(MASTER_SECONDS)
    assert laptop.python.ask("node.uri").startswith("http://10.77.0.33:")
    assert robot.python.ask("node.master.lookup_node('/laptop')") == laptop.python.ask("node.uri")
    for host in (laptop, robot):
        assert host.python.ask(f"heard.latest_after({there!r})") < FRESH * crowd()
    assert "ADDRESS_CHANGED" in laptop.python.ask("[event.kind.name for event in node._parts.context.events]")


def test_another_address_at_a_real_master(network: Network) -> None:
    """rosmaster calls the node at its old address and waits: registering again must not wait for that."""
    require_ros("rosmaster")
    robot, laptop, _ = network
    env = environment(MASTER, extra={"ROS_IP": ROBOT})
    robot.start(PYTHON, "/usr/bin/rosmaster", "--core", "-p", "11311", env=env)
    robot.python.eventually(f"reachable({ROBOT!r}, 11311)")
    laptop.python.do(
        "from rosproto import Node\n"
        f"node = Node('/laptop', master_uri={MASTER!r})\n"
        "node.service_server('/echo', 'std_srvs/Empty', lambda r: None)\n"
    )
    laptop.run("ip", "address", "flush", "dev", laptop.device)
    laptop.set_addresses("10.77.0.34/24")
    there = wait(0.0)
    robot.python.do(f"from rosproto.node import MasterClient\nclient = MasterClient({MASTER!r}, '/test')")
    moment = robot.python.eventually("'10.77.0.34' in client.lookup_service('/echo')")
    assert moment - there < soon(MASTER_SECONDS)
    assert "10.77.0.34" in robot.python.ask("client.lookup_node('/laptop')")


@pytest.mark.parametrize("seconds", [1.0, 6.5])
def test_the_cable_out_and_in(seconds: float, connected: Network) -> None:
    """With the same address afterwards: heard again within a second, whether the links lived or not."""
    robot, laptop, _ = connected
    laptop.down()
    wait(seconds)
    laptop.up()
    there = wait(0.0)
    assert heard_again(laptop.python, there) < soon(LINK_SECONDS)
    assert heard_again(robot.python, there) < soon(LINK_SECONDS)
    if seconds > 5:
        assert laptop.python.ask(f"heard.latest_after({there!r})") < FRESH * crowd()


def test_no_way_is_told_at_once(connected: Network) -> None:
    """Without an address calls fail in no time, with what to check; close() is quick."""
    _, laptop, _ = connected
    laptop.python.do("client = node.service_client('/nothing', 'std_srvs/Empty')")
    laptop.down()
    laptop.python.eventually("node.stats().master_lost")
    laptop.python.do(
        "began = time.monotonic()\n"
        "try: client.call(timeout=10)\n"
        "except Exception as error: said = str(error)\n"
        "called = time.monotonic() - began\n"
        "node.close()\n"
        "closed = time.monotonic() - began - called\n"
    )
    assert "check this computer's network address, the cable or Wi-Fi" in laptop.python.ask("said")
    assert laptop.python.ask("called") < soon(2.0)
    assert laptop.python.ask("closed") < soon(5.0)


def test_ipv6_only() -> None:
    """No IPv4 anywhere: topics both ways, services and parameters."""
    with two_hosts(robot=[f"{ROBOT6}/64"], laptop=[f"{LAPTOP6}/64"]) as (robot, laptop, _):
        uri = f"http://[{ROBOT6}]:11311/"
        start_robot(robot.python, uri, ROBOT6)
        robot.python.do("node.service_server('/set', 'std_srvs/SetBool', lambda r: {'success': r.data})")
        start_laptop(laptop.python, uri)
        robot.python.eventually("heard.messages")
        assert laptop.python.ask("node.uri").startswith(f"http://[{LAPTOP6}]:")
        assert laptop.python.ask(
            "node.service_client('/set', 'std_srvs/SetBool').call(data=True).success is True"
        )
        laptop.python.do("node.params['/key'] = [1, 2]")
        assert robot.python.ask("node.params['/key']") == [1, 2]


def test_from_ipv4_to_another_network(connected: Network) -> None:
    """Another subnet altogether, as from Wi-Fi to cable."""
    robot, laptop, _ = connected
    assert laptop.python.ask("node.uri").startswith(f"http://{LAPTOP}:")
    laptop.set_addresses("192.168.9.7/24")
    there = wait(0.0)
    assert heard_again(robot.python, there) < soon(MASTER_SECONDS)
    assert laptop.python.ask("node.uri").startswith("http://192.168.9.7:")
