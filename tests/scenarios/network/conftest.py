"""A robot and a laptop with a network between them that a test spoils (tests/support/hosts.py)."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.support.air import Air
from tests.support.hosts import ROBOT, Host, two_hosts
from tests.support.load import crowd
from tests.support.remote import Remote

HERE = Path(__file__).resolve().parent
MASTER = f"http://{ROBOT}:11311/"
LINK_SECONDS = 1.0  # what is promised for a link, from the moment the network is back
MASTER_SECONDS = 2.0  # and for registrations
SLACK = 1.0  # on top, for a processor that is in use; `tests.benchmarks network` prints the real figures
FRESH = 0.5  # seconds; a message that is older when it comes was kept somewhere


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Silence takes its time, and on a busy computer so does every process on either side of it."""
    for item in items:
        if HERE in item.path.parents:
            item.add_marker(pytest.mark.timeout(300))


def soon(seconds: float) -> float:
    """A promise of so many seconds, as this computer can keep it now."""
    return (seconds + SLACK) * crowd()


class Network(NamedTuple):
    """Two computers. `air.there` leads from the robot to the laptop, `air.back` the other way."""

    robot: Host
    laptop: Host
    air: Air


@pytest.fixture
def network() -> Iterator[Network]:
    with two_hosts() as (robot, laptop, air):
        yield Network(robot, laptop, air)


def start_robot(robot: Remote, uri: str = MASTER, host: str = ROBOT) -> None:
    """A master, and a node that publishes /t at 20 Hz and hears /back."""
    robot.do(
        "from rosproto import Master, Node\n"
        f"master = Master(host={host!r}, port=11311)\n"
        f"node = Node('/robot', master_uri={uri!r})\n"
        "tick = Ticker(node, '/t', 20)\n"
        "heard = Heard(node, '/back')\n"
    )


def start_laptop(laptop: Remote, uri: str = MASTER) -> None:
    """A node that hears /t and publishes /back at 20 Hz."""
    laptop.do(
        "from rosproto import Node\n"
        f"node = Node('/laptop', master_uri={uri!r})\n"
        "heard = Heard(node, '/t')\n"
        "tick = Ticker(node, '/back', 20)\n"
    )
    laptop.eventually("heard.messages")


@pytest.fixture
def connected(network: Network) -> Network:
    """Both nodes run and hear each other."""
    start_robot(network.robot.python)
    start_laptop(network.laptop.python)
    network.robot.python.eventually("heard.messages")
    return network


def heard_again(remote: Remote, moment: float, timeout: float = 60.0) -> float:
    """Seconds from a moment until a message came that was sent after it."""
    remote.eventually(f"heard.first_sent_after({moment!r})", timeout)
    return float(remote.ask(f"heard.first_sent_after({moment!r})")) - moment


def wait(seconds: float) -> float:
    """Let the world go on; the time afterwards."""
    time.sleep(seconds)
    return time.monotonic()
