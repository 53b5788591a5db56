"""The order machine does what it did when its traces were written: event for event."""

from __future__ import annotations

import pytest

from tests.support.fleet_traces import FILE, SEEDS, ReplayedMachine, lines


@pytest.mark.parametrize("seed", SEEDS)
def test_every_event_is_followed_by_what_was_recorded(seed: int) -> None:
    """A change that is meant to change them writes the file anew (see `tests/support/fleet_traces.py`), and its
    difference is read like that of the source."""
    recorded = FILE.read_text("utf-8").split(f"seed {seed}\n", 1)[1].split("\nseed ", 1)[0].splitlines()
    assert lines(seed, ReplayedMachine())[1:] == recorded
