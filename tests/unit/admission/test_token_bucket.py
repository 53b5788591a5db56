"""Rate limits."""

from __future__ import annotations

from rosproto.admission import MAX_ADDRESSES, AddressBuckets, TokenBucket


def test_a_bucket_does_not_fill_beyond_its_burst_or_by_a_clock_that_goes_back() -> None:
    bucket = TokenBucket(1.0, 2.0)
    assert [bucket.take(1e6) for _ in range(3)] == [True, True, False]
    assert not bucket.take(0.0)
    assert [bucket.take(2e6) for _ in range(3)] == [True, True, False]


def test_each_address_has_its_own() -> None:
    buckets = AddressBuckets(rate=5.0, burst=2.0)
    assert [buckets.take("a", 0.0) for _ in range(3)] == [True, True, False]
    assert buckets.take("b", 0.0)
    assert [buckets.take("a", 0.2) for _ in range(2)] == [True, False]


def test_addresses_do_not_pile_up() -> None:
    """Of as many others an address is remembered, of one more it is not."""
    for others, remembered in ((MAX_ADDRESSES - 1, True), (MAX_ADDRESSES, False)):
        buckets = AddressBuckets(rate=1.0, burst=1.0)
        assert buckets.take("a", 0.0)
        for i in range(others):
            buckets.take(f"{i}", 0.0)
        assert buckets.take("a", 0.0) is not remembered
