"""The lease: one holder, asked for, granted, given back, lapsing by itself. The clock is given."""

from __future__ import annotations

import threading

import pytest

from woosh_pure.lease import MAX_ASKING, ChassisLease, LeaseState


class At:
    """A clock that the test sets."""

    now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def at() -> At:
    return At()


@pytest.fixture
def lease(at: At) -> ChassisLease:
    return ChassisLease(at)


def test_a_free_lease_is_taken_and_shown(lease: ChassisLease, at: At) -> None:
    assert lease.acquire("anna", 60.0)
    at.now = 10.0
    assert lease.state == LeaseState("anna", 50.0, ())


def test_nobody_takes_it_from_its_holder(lease: ChassisLease) -> None:
    lease.acquire("anna", 60.0)
    assert not lease.acquire("bert", 60.0)
    assert lease.holder == "anna"


def test_it_lapses_by_itself_and_only_once(lease: ChassisLease, at: At) -> None:
    told: list[LeaseState] = []
    lease.acquire("anna", 60.0)
    lease.on(told.append)
    at.now = 59.9
    assert lease.holder == "anna"
    at.now = 60.0
    assert lease.holder is None
    at.now = 61.0
    assert lease.holder is None
    assert [state.holder for state in told] == [None]
    assert lease.acquire("bert", 60.0)


def test_renewing_keeps_it_and_never_shortens_it(lease: ChassisLease, at: At) -> None:
    lease.acquire("anna", 60.0)
    at.now = 1.0
    assert lease.renew("anna", 5.0)
    assert lease.state.seconds == 59.0
    at.now = 30.0
    assert lease.renew("anna", 60.0)
    assert lease.state.seconds == 60.0
    assert not lease.renew("bert", 60.0)
    at.now = 90.0
    assert not lease.renew("anna", 60.0), "what has lapsed is not renewed"


def test_it_is_handed_over_only_to_somebody_who_asks(lease: ChassisLease) -> None:
    lease.acquire("anna", 60.0)
    assert not lease.grant("anna", "bert", 60.0)
    assert lease.request("bert")
    assert not lease.grant("carl", "bert", 60.0), "not carl's to grant"
    assert lease.grant("anna", "bert", 60.0)
    assert lease.state == LeaseState("bert", 60.0, ())


def test_it_is_taken_over_only_by_who_has_asked_its_holder(lease: ChassisLease) -> None:
    lease.acquire("a program", 60.0)
    assert not lease.take_over("anna", "a program", 60.0), "asked once is not asked twice"
    lease.request("anna")
    assert not lease.take_over("anna", "another program", 60.0), "it has changed hands meanwhile"
    assert lease.take_over("anna", "a program", 60.0)
    assert lease.state == LeaseState("anna", 60.0, ())
    assert not lease.renew("a program", 60.0)


def test_it_is_shortened_for_its_holder_and_never_lengthened(lease: ChassisLease, at: At) -> None:
    lease.acquire("anna", 60.0)
    assert not lease.shorten("bert", 1.0)
    at.now = 10.0
    assert lease.shorten("anna", 6.0)
    assert lease.shorten("anna", 30.0)
    assert lease.state.seconds == 6.0
    at.now = 12.0
    assert lease.renew("anna", 60.0), "who comes back keeps it"
    assert lease.state.seconds == 60.0


def test_nobody_asks_for_a_free_one_or_for_ones_own(lease: ChassisLease) -> None:
    assert not lease.request("bert")
    lease.acquire("anna", 60.0)
    assert not lease.request("anna")


def test_who_asks_stands_in_the_list_once_and_can_take_it_back(lease: ChassisLease) -> None:
    lease.acquire("anna", 60.0)
    lease.request("bert")
    lease.request("carl")
    lease.request("bert")
    assert lease.state.asking == ("bert", "carl")
    assert not lease.release("bert"), "it was not bert's"
    assert lease.state.asking == ("carl",)


def test_the_list_of_those_who_ask_has_a_bound(lease: ChassisLease) -> None:
    lease.acquire("anna", 60.0)
    assert all(lease.request(f"guest {i}") for i in range(MAX_ASKING))
    assert not lease.request("one more")
    assert len(lease.state.asking) == MAX_ASKING


def test_a_question_is_taken_back_without_the_lease(lease: ChassisLease) -> None:
    lease.acquire("anna", 10.0)
    lease.request("bert")
    assert lease.withdraw("bert")
    assert lease.state.asking == ()
    assert not lease.withdraw("anna")
    assert lease.holder == "anna"


def test_giving_back_frees_it_and_keeps_those_who_ask(lease: ChassisLease) -> None:
    lease.acquire("anna", 60.0)
    lease.request("bert")
    assert lease.release("anna")
    assert lease.state == LeaseState(None, 0.0, ("bert",))
    assert lease.acquire("bert", 60.0)
    assert lease.state.asking == ()


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
    with pytest.raises(ValueError, match="printable name"):
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
