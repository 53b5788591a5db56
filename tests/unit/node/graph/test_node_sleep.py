"""A node on a computer that slept: everything is looked at as soon as it wakes, by clocks set by hand."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest

from rosproto.master import Master
from rosproto.node import MasterClient, Node, master_monitor
from rosproto.transport.deadline import SleepDetector
from tests.support.victim import eventually

String = "std_msgs/String"


class Sleep:
    """Stands for the clocks of nodes that are made from now on: the computer "sleeps" when told.

    Attributes:
        asked: How often they were looked at.
    """

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.asked = 0
        self._asleep = 0.0
        self._lock = threading.Lock()
        monkeypatch.setattr(
            master_monitor, "SleepDetector", lambda: SleepDetector(time.monotonic, self._with_sleep)
        )

    def _with_sleep(self) -> float:
        with self._lock:
            self.asked += 1
            return time.monotonic() + self._asleep

    def for_seconds(self, seconds: float) -> None:
        with self._lock:
            self._asleep += seconds


@pytest.fixture
def master() -> Iterator[Master]:
    with Master() as master:
        yield master


def test_links_to_publishers_are_made_anew_and_links_to_subscribers_are_kept(
    master: Master, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One link in, made again with a fresh requestTopic; one out, untouched: rospy would not come back."""
    got: list[str] = []
    robot = Node("/robot", master_uri=master.uri, rosout=False, intraprocess=False)
    sleep = Sleep(monkeypatch)
    with robot, Node("/laptop", master_uri=master.uri, rosout=False, intraprocess=False) as laptop:
        scan, cmd = robot.publisher("/scan", String), laptop.publisher("/cmd", String)
        laptop.subscriber("/scan", String, lambda message: got.append(message.data)).wait_for_connection()
        robot.subscriber("/cmd", String).wait_for_connection()
        cmd.wait_for_connection()
        sleep.for_seconds(3600)

        def incoming() -> Any:
            return next(link for link in laptop.stats().links if link.direction == "in")

        eventually(lambda: incoming().reconnects == 1 and incoming().connected)
        scan.publish(data="awake")
        eventually(lambda: got == ["awake"])
        (outgoing,) = [link for link in laptop.stats().links if link.direction == "out"]
        assert (outgoing.connected, outgoing.reconnects) == (True, 0)
        assert [link.reconnects for link in robot.stats().links if link.direction == "in"] == [0]


def test_a_registration_that_was_lost_meanwhile_is_made_again_at_once(
    master: Master, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not only with the next regular comparison of the graph."""
    sleep = Sleep(monkeypatch)
    with (
        Node("/laptop", master_uri=master.uri, rosout=False) as laptop,
        MasterClient(master.uri, "/laptop") as thief,
    ):
        laptop.publisher("/cmd", String)
        laptop.watch_master(period=1.0, full_check_every=1000)  # the regular comparison is far away
        thief.unregister_publisher("/cmd", laptop.uri)
        assert thief.get_system_state().publishers == {}
        sleep.for_seconds(60)
        eventually(lambda: thief.get_system_state().publishers == {"/cmd": ["/laptop"]})


def test_a_short_pause_changes_nothing(master: Master, monkeypatch: pytest.MonkeyPatch) -> None:
    robot = Node("/robot", master_uri=master.uri, rosout=False, intraprocess=False)
    sleep = Sleep(monkeypatch)
    with robot, Node("/laptop", master_uri=master.uri, rosout=False, intraprocess=False) as laptop:
        robot.publisher("/scan", String)
        laptop.subscriber("/scan", String).wait_for_connection()
        sleep.for_seconds(2.0)
        asked = sleep.asked
        eventually(lambda: sleep.asked >= asked + 2)
        assert [link.reconnects for link in laptop.stats().links] == [0]
