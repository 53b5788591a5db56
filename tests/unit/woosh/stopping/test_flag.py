"""An event that can be set over any frame."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from woosh_pure.stopping.stop_executor import Flag


def test_it_wakes_everybody_and_stays_set() -> None:
    flag, woken = Flag(), []
    threads = [threading.Thread(target=lambda: woken.append(flag.wait(20.0))) for _ in range(5)]
    for thread in threads:
        thread.start()
    assert not flag.is_set
    flag.set()
    flag.set()
    for thread in threads:
        thread.join(5.0)
    assert woken == [True] * 5
    assert flag.wait(0.0)


def test_a_wait_ends_in_time() -> None:
    began = time.monotonic()
    assert not Flag().wait(0.15)
    assert 0.14 <= time.monotonic() - began < 5.0  # clocks of Windows go by steps


def test_a_wait_ends_although_its_time_runs_out_within_the_call() -> None:
    """Waiting in a `SimpleQueue` hung there: within seconds, at thousands of tiny waits."""
    assert ends(lambda: Flag().wait(1e-6))


def ends(wait: Callable[[], object]) -> bool:
    """Whether ten thousand waits in a thread end."""
    thread = threading.Thread(target=lambda: [wait() for _ in range(10_000)], daemon=True)
    thread.start()
    thread.join(60.0)
    return not thread.is_alive()
