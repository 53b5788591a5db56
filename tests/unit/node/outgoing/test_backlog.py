"""When what is on its way to a subscriber is too old. The moments and the system's answers are made up."""

from __future__ import annotations

from collections.abc import Iterable

import pytest

from rosproto.node.outgoing.link_monitor import BULK_BYTES, CHECK_SECONDS, MAX_AGE_SECONDS, Backlog
from rosproto.transport.unsent_bytes import UnsentBytes


def cut_at(looks: Iterable[tuple[int, int]], *, large: bool = False, in_flight: bool = True) -> float | None:
    """Seconds from the first byte until it is too old; each look sees (bytes written, bytes that are there)."""
    backlog, now = Backlog(100.0), 100.0
    for written, there in looks:
        now += CHECK_SECONDS
        if backlog.look(now, written, UnsentBytes(written - there, in_flight), large=large):
            return now - 100.0
    return None


@pytest.mark.promise(
    "What TCP has taken is delivered whenever the",
    "disconnected when data on its way to it is four seconds old",
)
def test_velocities_into_silence() -> None:
    """Twenty a second, none acknowledged: four seconds after the first."""
    assert cut_at((520 * n, 0) for n in range(1, 60)) == pytest.approx(MAX_AGE_SECONDS)


def test_one_small_message_is_enough() -> None:
    """A goal that waits for the network is as late as a velocity."""
    assert cut_at((100, 0) for _ in range(60)) == pytest.approx(MAX_AGE_SECONDS)


def test_what_arrives_a_second_late_all_the_time_is_not_too_old() -> None:
    assert cut_at((500 * n, 500 * max(0, n - 2)) for n in range(1, 200)) is None


def test_an_end_of_silence_in_time() -> None:
    """Three seconds without an answer, then everything; and the same again: each is a new beginning."""
    once = [(500 * n, 0) for n in range(1, 6)] + [(3500, 3000)]
    again = [(3500 + 500 * n, 3500) for n in range(1, 6)] + [(7000, 6900)]
    assert cut_at([*once, *again]) is None


def test_small_messages_that_trickle_through_are_too_old_all_the_same() -> None:
    """A network that carries a tenth: something arrives at each look, and it is ever older."""
    cut = cut_at((500 * n, 50 * n) for n in range(1, 100))
    assert cut is not None
    assert MAX_AGE_SECONDS <= cut <= MAX_AGE_SECONDS + 2 * CHECK_SECONDS


def test_a_burst_gets_on_as_long_as_some_of_it_arrives() -> None:
    """A megabyte of small messages to a subscriber that takes its time; cut when it takes no more."""
    size = 4 * BULK_BYTES
    behind = [(size, 1000 * n) for n in range(1, 40)]
    assert cut_at(behind, in_flight=False) is None
    assert cut_at([(size, 1000)] * 60, in_flight=False) == pytest.approx(
        MAX_AGE_SECONDS + CHECK_SECONDS, abs=CHECK_SECONDS
    )


def test_large_messages_to_a_slow_subscriber_are_its_own_affair() -> None:
    """An hour for one image; but when its computer does not even acknowledge, it is the network."""
    assert cut_at([(1 << 20, 1 << 19)] * 7200, large=True, in_flight=False) is None
    cut = cut_at([(1 << 20, 1 << 19)] * 60, large=True, in_flight=True)
    assert cut == pytest.approx(MAX_AGE_SECONDS, abs=2 * CHECK_SECONDS)


def test_a_map_over_a_slow_network_arrives() -> None:
    """Ten minutes of it."""
    assert cut_at(((10 << 20, 8000 * n) for n in range(1, 1200)), large=True) is None


def test_a_publisher_that_did_not_get_to_run_does_not_misjudge_what_it_wrote_since() -> None:
    """Ten seconds without a look, then bytes that were written a moment ago."""
    backlog = Backlog(100.0)
    assert not backlog.look(100.5, 100, UnsentBytes(100, True), large=False)
    assert not backlog.look(110.5, 5000, UnsentBytes(100, True), large=False)
    assert not backlog.look(111.0, 5100, UnsentBytes(100, True), large=False)
    assert not backlog.look(114.5, 5100, UnsentBytes(100, True), large=False)  # late again
    assert "does not answer" in backlog.look(115.0, 5100, UnsentBytes(100, True), large=False)


def test_the_reason_says_how_much_and_how_old() -> None:
    backlog = Backlog(0.0)
    for n in range(1, 8):
        assert not backlog.look(n * CHECK_SECONDS, 100, UnsentBytes(100, False), large=False)
    why = backlog.look(4.0, 100, UnsentBytes(100, False), large=False)
    assert why == "100 bytes, the oldest 4.0 s old, have not arrived; it does not read"
