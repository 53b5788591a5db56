"""An event that can be set over any frame."""

from __future__ import annotations

import threading
import time

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
    assert 0.15 <= time.monotonic() - began < 5.0
