"""Places at the server: who is let in, who is asked to leave, and that whoever is known always finds one."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosproto.transport.connection_slots import KNOWN_SECONDS, MAX_KNOWN, ConnectionSlots, Key

STRANGER, OWNER, HERE = "192.168.1.66", "192.168.1.7", "127.0.0.1"


class Door:
    """Places, with ports that count up and a list of who was ended."""

    def __init__(self, max_slots: int = 256, **options: float) -> None:
        self.slots = ConnectionSlots(max_slots, **options)  # type: ignore[arg-type]
        self.ended: list[Key] = []
        self._ports = itertools.count(1)

    def admit(self, address: str, now: float = 0.0) -> Key | None:
        key = (address, next(self._ports))
        return key if self.slots.admit(key, self.end_of(key), now) else None

    def end_of(self, key: Key) -> Callable[[], None]:
        return lambda: self.ended.append(key)

    def ask(self, key: Key, now: float = 0.0) -> None:
        self.slots.request_begins(key, now, authorized=True)


@pytest.mark.promise("A connection loses its place after ten seconds")
def test_who_says_nothing_leaves_after_a_while() -> None:
    door = Door(max_silence=10.0)
    key = door.admit(STRANGER, 0.0)
    assert key is not None
    door.slots.drop_silent(9.9)
    assert door.ended == []
    door.slots.drop_silent(10.1)
    assert door.ended == [key]
    assert len(door.slots) == 0


def test_a_request_under_way_is_no_silence_and_the_time_begins_anew_after_it() -> None:
    door = Door(max_silence=10.0)
    key = door.admit(STRANGER)
    assert key is not None
    door.slots.request_begins(key, 5.0, authorized=False)
    door.slots.drop_silent(100.0)
    assert door.ended == []
    door.slots.request_ends(key, 100.0, authorized=False)
    door.slots.drop_silent(109.0)
    assert door.ended == []
    door.slots.drop_silent(111.0)
    assert door.ended == [key]


@pytest.mark.promise("another address has 64 at most")
def test_one_address_has_so_many_and_then_its_own_newest_takes_the_place_of_its_own_oldest() -> None:
    door = Door(100, reserved=10, max_per_address=3)
    other = door.admit(OWNER)
    keys = [door.admit(STRANGER, float(i)) for i in range(3)]
    assert None not in keys
    assert door.admit(STRANGER, 4.0) is not None
    assert door.ended == [keys[0]]
    assert other not in door.ended


def test_one_address_that_asks_with_all_it_has_gets_no_more() -> None:
    door = Door(100, reserved=10, max_per_address=2)
    for _ in range(2):
        key = door.admit(STRANGER)
        assert key is not None
        door.ask(key)
    assert door.admit(STRANGER) is None
    assert door.ended == []


@pytest.mark.promise("There are 256 places for connections")
def test_strangers_cannot_take_the_reserved_places() -> None:
    door = Door(10, reserved=4, max_per_address=100)
    for n in range(6):
        key = door.admit(f"10.0.0.{n}")
        assert key is not None
        door.ask(key)
    assert door.admit("10.0.0.9") is None
    door.slots.remember(OWNER, 0.0)
    assert [door.admit(address) is not None for address in (OWNER, HERE, OWNER, OWNER)] == [True] * 4
    assert door.ended == []


@pytest.mark.promise("connection replaces the longest silent one")
def test_a_newcomer_takes_the_place_of_the_most_silent_of_the_largest_crowd() -> None:
    door = Door(6, reserved=0, max_per_address=100)
    alone = door.admit(OWNER, 0.0)
    crowd = [door.admit(STRANGER, float(n)) for n in range(1, 6)]
    assert door.admit("192.168.1.8", 6.0) is not None
    assert door.ended == [crowd[0]], "although the other one has been silent for longer"
    assert alone is not None


def test_who_is_known_is_forgotten_after_a_while_and_the_list_is_bounded() -> None:
    door = Door(2, reserved=1, max_per_address=9, max_silence=1e9)
    door.slots.remember(OWNER, 0.0)
    key = door.admit(STRANGER)
    assert key is not None
    door.ask(key)
    assert door.admit(STRANGER, KNOWN_SECONDS / 2) is None
    assert door.admit(OWNER, KNOWN_SECONDS + 1.0) is None, "no longer known"
    door.slots.remember(OWNER, 0.0)
    for n in range(MAX_KNOWN):
        door.slots.remember(f"10.0.{n // 256}.{n % 256}", 0.0)
    assert door.admit(OWNER, 1.0) is None, "others came later"


def test_the_end_of_an_old_connection_does_not_take_the_place_of_a_new_one_from_the_same_port() -> None:
    door = Door()
    key = (STRANGER, 7)
    old, new = door.end_of(key), door.end_of(key)
    assert door.slots.admit(key, old, 0.0)
    assert door.slots.admit(key, new, 1.0)
    door.slots.release(key, old)
    assert len(door.slots) == 1
    door.slots.release(key, new)
    assert len(door.slots) == 0


def test_what_is_no_connection_of_ours_is_no_matter() -> None:
    """Mounted in somebody's own server, requests come without a place."""
    slots = ConnectionSlots(256)
    slots.request_begins(("x", 1), 0.0, authorized=True)
    slots.request_ends(("x", 1), 0.0, authorized=True)
    slots.drop_silent(100.0)
    assert len(slots) == 0


@pytest.mark.parametrize("address", [OWNER, HERE])
@settings(max_examples=60)
@given(
    st.lists(
        st.tuples(st.integers(0, 3), st.sampled_from(["come", "ask", "stranger asks", "wait"])), max_size=120
    )
)
def test_whoever_is_known_finds_a_place_whatever_strangers_do(
    address: str, acts: list[tuple[int, str]]
) -> None:
    """As long as strangers are not let in: who has the token may use all places, and then it is their own crowd."""
    door, now = Door(8, reserved=2, max_per_address=4), 0.0
    door.slots.remember(OWNER, now)
    strangers: list[Key] = []
    for who, act in acts:
        now += 0.01
        if act == "come" and (key := door.admit(f"10.0.0.{who}", now)):
            strangers.append(key)
        elif act == "wait":
            door.slots.drop_silent(now)
        elif strangers:
            door.slots.request_begins(strangers[who % len(strangers)], now, authorized=False)
        assert len(door.slots) <= 8
    assert door.admit(address, now) is not None


def test_all_that_are_left_are_dropped_at_the_end_and_none_for_its_silence_without_a_limit() -> None:
    door = Door()
    keys = [door.admit(STRANGER), door.admit(OWNER)]
    door.slots.drop_silent(1e9)
    assert door.ended == []
    door.slots.drop_all()
    assert door.ended == keys
    assert (len(door.slots), door.slots.replaced) == (0, 0)
