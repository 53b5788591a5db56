"""The master's computer cannot be reached, and can again: as it was, or started anew."""

from __future__ import annotations

import pytest

from tests.scenarios.network.conftest import (
    LINK_SECONDS,
    MASTER_SECONDS,
    Network,
    heard_again,
    soon,
    start_robot,
    wait,
)

pytestmark = pytest.mark.slow


def test_the_same_master_again(connected: Network) -> None:
    """Calls fail in bounded time meanwhile; afterwards all of it stands within two seconds."""
    _, laptop, air = connected
    air.silence()
    gone = wait(0.0)
    laptop.python.do("try: node.master.get_pid(timeout=2)\nexcept Exception as error: said = str(error)\n")
    assert wait(0.0) - gone < soon(2.0)
    assert "no answer within 2 s" in laptop.python.ask("said")
    laptop.python.eventually("node.stats().master_lost")
    back = wait(3.0)
    air.clear()
    assert laptop.python.eventually("not node.stats().master_lost") - back < soon(MASTER_SECONDS)
    assert heard_again(laptop.python, back) < soon(LINK_SECONDS)


def test_a_registration_that_was_given_up_does_not_come_later(connected: Network) -> None:
    """Not even when the network is back before the system has given it up: what was asked for since would not count."""
    robot, laptop, air = connected
    laptop.python.do("node.master.get_pid()")  # a connection stands
    air.silence()
    laptop.python.do(
        "late = ('registerPublisher', '/late', 'std_msgs/String', node.uri)\n"
        "try: node.master.call(*late, timeout=1.0)\nexcept Exception as error: said = str(error)\n"
    )
    assert "no answer within 1 s" in laptop.python.ask("said")
    air.clear()
    wait(2.5)  # lost packets are repeated within that time
    assert robot.python.ask("'/back' in node.master.get_system_state().publishers")
    assert not robot.python.ask("'/late' in node.master.get_system_state().publishers")


def test_a_robot_that_was_switched_off_and_on(network: Network) -> None:
    """Its processes vanish while nobody hears it; the new ones get our registrations and links within two seconds."""
    robot, laptop, air = network
    old = robot.another()
    start_robot(old)
    laptop.python.do(
        "from rosproto import Node\n"
        "node = Node('/laptop', master_uri='http://10.77.0.1:11311')\n"
        "heard = Heard(node, '/t')\n"
        "tick = Ticker(node, '/back', 20)\n"
        "service = node.service_server('/echo', 'std_srvs/Empty', lambda r: None)\n"
        "node.params.subscribe('/key', print)\n"
    )
    laptop.python.eventually("heard.messages")
    air.silence()
    old.kill()
    wait(4.0)
    start_robot(robot.python)
    back = wait(0.0)
    air.clear()
    registered = robot.python.eventually(
        "'/laptop' in node.master.get_system_state().publishers.get('/back', ())"
        " and '/laptop' in node.master.get_system_state().subscribers.get('/t', ())"
        " and '/echo' in node.master.get_system_state().services"
    )
    assert registered - back < soon(MASTER_SECONDS)
    assert heard_again(laptop.python, back) < soon(MASTER_SECONDS + LINK_SECONDS)
    assert heard_again(robot.python, back) < soon(MASTER_SECONDS + LINK_SECONDS)


def test_laptops_that_are_out_of_reach_delay_nobody_at_the_robot(network: Network) -> None:
    """Ten nodes are told of a new publisher in vain; one at the robot hears it at once, and the master serves on."""
    robot, laptop, air = network
    start_robot(robot.python)
    laptop.python.do(
        "from rosproto import Node\n"
        "nodes = [Node(f'/laptop{n}', master_uri='http://10.77.0.1:11311') for n in range(10)]\n"
        "subscribers = [node.subscriber('/new', 'std_msgs/String') for node in nodes]\n",
        40,
    )
    robot.python.do(
        "near = Node('/near', master_uri=master.uri, intraprocess=False)\nheard2 = Heard(near, '/new')"
    )
    air.silence()
    began = wait(0.0)
    robot.python.do("tick2 = Ticker(node, '/new', 20)")
    assert robot.python.eventually("heard2.messages") - began < soon(1.0)
    for number in range(5):  # further changes pile up for those nodes, and for nobody else
        began = wait(0.0)
        robot.python.do(f"more{number} = Ticker(node, '/new{number}', 1); near.params['/key'] = {number}")
        assert wait(0.0) - began < soon(1.0)
    assert robot.python.ask("master.stats()['threads']") < 30
    air.clear()
    laptop.python.eventually("all(s.connections == 1 for s in subscribers)")
