"""The lease: one holder, asked for, granted, given back, lapsing by itself. The clock is given."""

from __future__ import annotations

import threading

import pytest

from woosh_pure.lease import MOST_ASKING, ChassisLease, Lease, LeaseState


def test_a_free_lease_is_taken_and_shown() -> None:
    lease = Lease()
    assert lease.acquire("anna", 60.0, now=0.0)
    assert lease.state(10.0) == LeaseState("anna", 50.0, ())


def test_nobody_takes_it_from_its_holder() -> None:
    lease = Lease()
    lease.acquire("anna", 60.0, 0.0)
    assert not lease.acquire("bert", 60.0, 1.0)
    assert lease.owner == "anna"


def test_it_lapses_by_itself_and_only_once() -> None:
    lease = Lease()
    lease.acquire("anna", 60.0, 0.0)
    assert not lease.lapse(59.9)
    assert lease.lapse(60.0)
    assert not lease.lapse(61.0)
    assert lease.acquire("bert", 60.0, 61.0)


def test_renewing_keeps_it_and_never_shortens_it() -> None:
    lease = Lease()
    lease.acquire("anna", 60.0, 0.0)
    assert lease.renew("anna", 5.0, 1.0)
    assert lease.expires == 60.0
    assert lease.renew("anna", 60.0, 30.0)
    assert lease.expires == 90.0
    assert not lease.renew("bert", 60.0, 31.0)
    assert not lease.renew("anna", 60.0, 90.0), "what has lapsed is not renewed"


def test_it_is_handed_over_only_to_somebody_who_asks() -> None:
    lease = Lease()
    lease.acquire("anna", 60.0, 0.0)
    assert not lease.grant("anna", "bert", 60.0, 1.0)
    assert lease.request("bert", 1.0)
    assert not lease.grant("carl", "bert", 60.0, 2.0), "not carl's to grant"
    assert lease.grant("anna", "bert", 60.0, 2.0)
    assert lease.state(2.0) == LeaseState("bert", 60.0, ())


def test_it_is_taken_over_only_by_who_has_asked_its_holder() -> None:
    lease = Lease()
    lease.acquire("a program", 60.0, 0.0)
    assert not lease.take_over("anna", "a program", 60.0, 1.0), "asked once is not asked twice"
    lease.request("anna", 1.0)
    assert not lease.take_over("anna", "another program", 60.0, 1.0), "it has changed hands meanwhile"
    assert lease.take_over("anna", "a program", 60.0, 2.0)
    assert lease.state(2.0) == LeaseState("anna", 60.0, ())
    assert not lease.renew("a program", 60.0, 3.0)


def test_it_is_shortened_for_its_holder_and_never_lengthened() -> None:
    lease = Lease()
    lease.acquire("anna", 60.0, 0.0)
    assert not lease.shorten("bert", 1.0, 0.0)
    assert lease.shorten("anna", 6.0, 10.0)
    assert lease.shorten("anna", 30.0, 10.0)
    assert lease.expires == 16.0
    assert lease.renew("anna", 60.0, 12.0), "who comes back keeps it"
    assert lease.expires == 72.0


def test_nobody_asks_for_a_free_one_or_for_ones_own() -> None:
    lease = Lease()
    assert not lease.request("bert", 0.0)
    lease.acquire("anna", 60.0, 0.0)
    assert not lease.request("anna", 0.0)


def test_who_asks_stands_in_the_list_once_and_can_take_it_back() -> None:
    lease = Lease()
    lease.acquire("anna", 60.0, 0.0)
    lease.request("bert", 1.0)
    lease.request("carl", 1.0)
    lease.request("bert", 1.0)
    assert lease.asking == ["bert", "carl"]
    assert not lease.release("bert", 2.0), "it was not bert's"
    assert lease.asking == ["carl"]


def test_the_list_of_those_who_ask_has_a_bound() -> None:
    lease = Lease()
    lease.acquire("anna", 60.0, 0.0)
    assert all(lease.request(f"guest {i}", 0.0) for i in range(MOST_ASKING))
    assert not lease.request("one more", 0.0)
    assert len(lease.asking) == MOST_ASKING


def test_a_question_is_taken_back_without_the_lease() -> None:
    lease = Lease()
    lease.acquire("anna", 10.0, 0.0)
    lease.request("bert", 1.0)
    assert lease.withdraw("bert")
    assert lease.asking == []
    assert not lease.withdraw("anna")
    assert lease.owner == "anna"


def test_giving_back_frees_it_and_keeps_those_who_ask() -> None:
    lease = Lease()
    lease.acquire("anna", 60.0, 0.0)
    lease.request("bert", 1.0)
    assert lease.release("anna", 2.0)
    assert lease.state(2.0) == LeaseState(None, 0.0, ("bert",))
    assert lease.acquire("bert", 60.0, 3.0)
    assert lease.asking == []


def test_listeners_hear_changes_and_a_lapse_that_somebody_sees() -> None:
    now = [0.0]
    lease, told = ChassisLease(lambda: now[0]), []
    off = lease.on(told.append)
    lease.acquire("anna", 60.0)
    lease.renew("anna")
    lease.acquire("bert")
    lease.request("bert")
    now[0] = 100.0
    assert lease.holder is None
    off()
    lease.acquire("carl")
    assert [state.holder for state in told] == ["anna", "anna", None]


def test_a_listener_that_fails_harms_nobody() -> None:
    lease, told = ChassisLease(), []
    lease.on(lambda state: 1 / 0)
    lease.on(told.append)
    assert lease.acquire("anna")
    assert len(told) == 1


@pytest.mark.parametrize("owner", ["", "  ", "x" * 201, None])
def test_an_owner_has_a_name(owner: str) -> None:
    with pytest.raises(ValueError, match="name that others can read"):
        ChassisLease().acquire(owner)


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("nan"), float("inf"), 3601.0])
def test_a_lease_has_an_end(seconds: float) -> None:
    with pytest.raises(ValueError, match="at most 3600"):
        ChassisLease().acquire("anna", seconds)


def test_of_many_who_take_it_at_once_one_gets_it() -> None:
    lease, got = ChassisLease(), []
    start = threading.Barrier(8)

    def take(name: str) -> None:
        start.wait(5.0)
        got.append(lease.acquire(name))

    threads = [threading.Thread(target=take, args=(f"guest {i}",)) for i in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(5.0)
    assert sorted(got) == [False] * 7 + [True]
