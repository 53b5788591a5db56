"""A firewall that lets nobody in to the laptop, as Windows has it: what works, and who says what does not."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.scenarios.network.conftest import (
    MASTER,
    Network,
    heard_again,
    soon,
    start_laptop,
    start_robot,
    wait,
)
from tests.support.air import is_tcp_opening

pytestmark = pytest.mark.slow


@pytest.fixture
def behind_a_firewall(network: Network) -> Network:
    network.air.there.passes = lambda packet: not is_tcp_opening(packet)
    return network


def test_what_we_ask_for_comes(behind_a_firewall: Network) -> None:
    """Topics that the robot publishes, its services and parameters; later and restarted publishers too."""
    robot, laptop, _ = behind_a_firewall
    talker = robot.another()
    start_robot(robot.python)
    robot.python.do("node.service_server('/set', 'std_srvs/SetBool', lambda r: {'success': r.data})")
    start_laptop(laptop.python)
    assert (
        laptop.python.ask("node.service_client('/set', 'std_srvs/SetBool').call(data=True).success") is True
    )
    laptop.python.do("later = Heard(node, '/later')")
    talk = f"from rosproto import Node\nnode = Node('/talker', master_uri={MASTER!r})\ntick = Ticker(node, '/later', 20)"
    talker.do(talk)
    laptop.python.eventually("later.messages", soon(8.0))  # the graph is compared every five seconds
    talker.kill()
    robot.another().do(talk)
    again = wait(0.0)
    laptop.python.eventually(f"later.first_sent_after({again!r})", soon(3.0))
    assert heard_again(laptop.python, again) < 1.0
    assert laptop.python.ask("tick.publisher.connections") == 0  # the robot would have to come in for that


def test_the_doctor_names_it(behind_a_firewall: Network) -> None:
    """`woosh doctor` says that the chassis does not reach us, where, and what to do; everything else is well."""
    robot, laptop, _ = behind_a_firewall
    robot.python.do(
        "from woosh_pure import SimulatedChassis\n"
        "sim = SimulatedChassis(host='10.77.0.1', port=11311)\n"
        "sim.__enter__()\n",
        60,
    )
    done = subprocess.run(
        [*laptop.prefix, sys.executable, "-m", "woosh_pure", "--chassis", "10.77.0.1", "doctor"],
        capture_output=True,
        text=True,
        timeout=90,
    )
    problems = [line for line in done.stdout.splitlines() if line.startswith("PROBLEM")]
    assert done.returncode == 1, done.stdout + done.stderr
    assert len(problems) == 1
    assert "we reach the chassis, but" in problems[0]
    assert "http://10.77.0.2:" in problems[0]
    assert "allow Python through the firewall" in done.stdout
    assert "topics were heard" in done.stdout
