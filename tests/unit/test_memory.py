"""The memory measurement used by tests sees allocations, and hides no failure."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.memory import peak_of


@pytest.mark.parametrize("work", [lambda: bytes(10_000_000), lambda: np.zeros(10_000_000, np.uint8)])
def test_what_is_let_go_at_once_counts(work) -> None:
    assert 10_000_000 < peak_of(work) < 10_200_000


def test_a_failure_inside_is_a_failure() -> None:
    def fails() -> None:
        raise ValueError("no such thing")

    with pytest.raises((AssertionError, ValueError), match="no such thing"):
        peak_of(fails)
