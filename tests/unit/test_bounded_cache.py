"""The cache for what peers send stays within its limits."""

from __future__ import annotations

import pytest

from rosproto.bounded_cache import BoundedCache


@pytest.mark.promise("is bounded in number and length")
def test_the_entry_used_longest_ago_makes_room() -> None:
    kept: BoundedCache[str, int] = BoundedCache(2)
    kept.put("a", 1)
    kept.put("b", 2)
    assert kept.get("a") == 1
    kept.put("c", 3)
    assert [kept.get(key) for key in "abc"] == [1, None, 3]


def test_weights_count_together() -> None:
    """Replacing one takes its weight along; one that is too heavy alone ousts nobody."""
    kept: BoundedCache[str, int] = BoundedCache(10, weight=100)
    kept.put("a", 1, 60)
    kept.put("a", 1, 40)
    kept.put("b", 2, 60)
    kept.put("huge", 3, 101)
    assert [kept.get(key) for key in ("a", "b", "huge")] == [1, 2, None]
    kept.put("c", 4, 1)
    assert [kept.get(key) for key in "abc"] == [None, 2, 4]
