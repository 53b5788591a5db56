"""The connections with the broker: bounded queues, waits that grow. Brokers here are none."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import pytest

from tests.support.stuck_broker import StuckBroker
from tests.support.waiting import until
from woosh_pure.fleet import broker_connection as mqtt
from woosh_pure.fleet.broker_connection import MAX_WAITING, BrokerConnection
from woosh_pure.fleet.config import Broker

pytest.importorskip("paho.mqtt.client", reason="paho-mqtt is not installed")
STATE = {"text": "x" * 2600}  # as long as a state with 18 nodes ahead


class RecordedConnection:
    """A connection that records its `changed` calls."""

    def __init__(self, url: str, serial: str = "1") -> None:
        self.told: list[bool] = []
        self.came = threading.Condition()
        self.connection = BrokerConnection(
            Broker(url), f"uagv/v2/W/{serial}", lambda s: {"connectionState": s}, lambda *_: None, self._on
        )

    def _on(self, stands: bool) -> None:
        with self.came:
            self.told.append(stands)
            self.came.notify_all()

    def until(self, accept: Callable[[], bool], seconds: float = 10.0) -> None:
        deadline = time.monotonic() + seconds
        with self.came:
            while not accept():
                assert self.came.wait(deadline - time.monotonic()), self.told


@pytest.fixture
def opened() -> Iterator[Callable[..., RecordedConnection]]:
    with ExitStack() as stack:

        def make(url: str, serial: str = "1") -> RecordedConnection:
            heard = RecordedConnection(url, serial)
            stack.callback(heard.connection.close, 0.1)
            heard.connection.open()
            return heard

        yield make


@pytest.mark.promise("at most 200 messages or 1 MB for a vehicle")
def test_a_broker_that_does_not_read_costs_a_bounded_amount(opened: Any) -> None:
    """Surplus messages are dropped and counted; `changed` is called when the broker reads again, for a new state."""
    with StuckBroker() as broker:
        heard = opened(broker.url)
        heard.until(lambda: heard.told == [True])
        pause, dropped = threading.Event(), 0
        while dropped < 100:  # one after the other: then the system's buffers are full, too
            dropped = 0 if heard.connection.send("state", STATE) else dropped + 1
            pause.wait(0.001 if dropped else 0.0)
        assert heard.connection.dropped >= 100
        assert heard.connection.waiting <= MAX_WAITING
        told = len(heard.told)
        broker.reading.set()
        heard.until(lambda: len(heard.told) > told)
        assert heard.told[-1]
        assert heard.connection.send("state", STATE)


def test_a_broker_that_answers_no_ping_is_left(opened: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """After two keep-alives; then it is tried anew."""
    monkeypatch.setattr(mqtt, "_KEEP_ALIVE", 1)
    with StuckBroker() as broker:
        heard = opened(broker.url)
        heard.until(lambda: heard.told == [True, False, True])
        assert broker.accepted == 2


def test_a_broker_that_never_answers_is_left(
    opened: Any, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """The connection alone is not a line."""
    monkeypatch.setattr(mqtt, "_KEEP_ALIVE", 1)
    monkeypatch.setattr(mqtt, "_REJECTED_WAITS", (0.01, 2.0, 0.02, 0.0))
    with StuckBroker(answer=None) as broker:
        heard = opened(broker.url)
        with broker.came:
            assert broker.came.wait_for(lambda: broker.accepted == 2, 10.0)
        assert heard.told == []
    assert "did not answer" in caplog.text


def test_who_is_refused_knocks_ever_more_rarely(
    opened: Any, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """A wrong password must not lock the account."""
    monkeypatch.setattr(mqtt, "_REJECTED_WAITS", (0.05, 4.0, 30.0, 0.0))
    with StuckBroker(answer=0x87) as broker:
        began = time.monotonic()
        heard = opened(broker.url)
        with broker.came:
            assert broker.came.wait_for(lambda: broker.accepted == 4, 10.0)
        assert time.monotonic() - began > 0.05 + 0.2 + 0.8
        assert heard.told == []
    assert caplog.text.count("refused us") == 1


def test_a_broker_of_before_mqtt_5_is_spoken_to_in_its_version(
    opened: Any, caplog: pytest.LogCaptureFixture
) -> None:
    """It refuses the version once; that is said, and the next connection stands."""
    with StuckBroker(old=True) as broker:
        heard = opened(broker.url)
        heard.until(lambda: heard.told == [True])
        assert broker.accepted == 2
    assert caplog.text.count("3.1.1 is used") == 1


def test_a_failure_of_our_own_does_not_end_the_connection(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """It is logged, and what comes next is heard."""
    with StuckBroker() as broker:
        heard = RecordedConnection(broker.url)
        told: list[bool] = []

        def fails(stands: bool) -> None:
            told.append(stands)
            raise RuntimeError("ours")

        monkeypatch.setattr(heard.connection, "_changed", fails)
        heard.connection.open()
        try:
            until(lambda: told == [True], what="the connection")
            broker.hang_up()
            until(lambda: told[:3] == [True, False, True], what="the next connection")
        finally:
            heard.connection.close(0.1)
    assert "ours" in caplog.text


def test_a_file_number_that_select_does_not_take_is_told(
    opened: Any, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """The sentence says how many vehicles a process may have."""
    monkeypatch.setattr(mqtt, "_MAX_FILES", 0)
    with StuckBroker() as broker:
        heard = opened(broker.url)
        heard.until(lambda: heard.told == [True])
    assert "25 whole chassis" in caplog.text


def test_a_broker_that_hangs_up_at_once_is_not_stormed(
    opened: Any, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """As one does that has another client of our name."""
    monkeypatch.setattr(mqtt, "_REJECTED_WAITS", (5.0, 2.0, 30.0, 0.0))
    with StuckBroker() as broker:
        heard = opened(broker.url)
        heard.until(lambda: heard.told == [True])
        broker.hang_up()
        heard.until(lambda: heard.told == [True, False])
        with broker.came:
            assert not broker.came.wait_for(lambda: broker.accepted > 1, 1.5), "the usual wait is 1 s"
    assert "does another process say" in caplog.text


def test_the_name_stays_and_every_broker_takes_it(opened: Any) -> None:
    """So a broker ends the connection of before when the next one comes."""
    with StuckBroker() as broker:
        for serial in ("1", "1", "2" * 300):
            heard = opened(broker.url, serial)
            heard.until(lambda heard=heard: heard.told == [True])
        names = broker.names
    assert len(names) == 3
    assert names[0] == names[1] != names[2]
    assert all(name.isalnum() and len(name) <= 23 for name in names)
