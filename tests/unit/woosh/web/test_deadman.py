"""The dead man's machine: its whole table, and that nothing prolongs a drive. Times are given."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from woosh_pure.web.live.deadman import (
    MAX_LATE_SECONDS,
    SILENCE_SECONDS,
    VALID_FOR,
    DeadManSwitch,
    State,
    Verdict,
)

ZERO = "zero"


def in_state(state: State) -> DeadManSwitch:
    """A hand in that state at time 10, by the shortest way; it has used the numbers up to 2."""
    man = DeadManSwitch()
    if state != "idle":
        assert man.press(1, 10.0, 0.2, 0.0, 10.0).act == "open"
    if state in ("driving", "ended"):
        assert man.opened(10.0) == Verdict("drive", 0.2, 0.0, valid_for=VALID_FOR)
    if state == "ended":
        assert man.end("released").act == ZERO
    assert man.state == state
    return man


def press(man: DeadManSwitch) -> Verdict:
    return man.press(3, 10.1, 0.1, 0.2, 10.1)


def beat(man: DeadManSwitch) -> Verdict:
    return man.beat(3, 10.1, 0.1, 0.2, 10.1)


EVENTS = {
    "press": press,
    "opened": lambda man: man.opened(10.1),
    "beat": beat,
    "let go": lambda man: man.end("released"),
    "silence": lambda man: man.tick(10.0 + SILENCE_SECONDS + 0.01),
    "time": lambda man: man.tick(10.1),
}
TABLE: dict[tuple[State, str], tuple[str, State]] = {
    ("idle", "press"): ("open", "opening"),
    ("idle", "opened"): (ZERO, "idle"),
    ("idle", "beat"): ("none", "idle"),
    ("idle", "let go"): ("none", "idle"),
    ("idle", "silence"): ("none", "idle"),
    ("idle", "time"): ("none", "idle"),
    ("opening", "press"): (ZERO, "ended"),
    ("opening", "opened"): ("drive", "driving"),
    ("opening", "beat"): ("none", "opening"),
    ("opening", "let go"): (ZERO, "ended"),
    ("opening", "silence"): (ZERO, "ended"),
    ("opening", "time"): ("none", "opening"),
    ("driving", "press"): (ZERO, "ended"),
    ("driving", "opened"): (ZERO, "driving"),
    ("driving", "beat"): ("drive", "driving"),
    ("driving", "let go"): (ZERO, "ended"),
    ("driving", "silence"): (ZERO, "ended"),
    ("driving", "time"): ("none", "driving"),
    ("ended", "press"): ("open", "opening"),
    ("ended", "opened"): (ZERO, "ended"),
    ("ended", "beat"): ("none", "ended"),
    ("ended", "let go"): ("none", "ended"),
    ("ended", "silence"): ("none", "ended"),
    ("ended", "time"): ("none", "ended"),
}


@pytest.mark.parametrize(("state", "event"), TABLE, ids=lambda part: str(part))
def test_the_whole_table(state: State, event: str) -> None:
    man = in_state(state)
    act, after = TABLE[state, event]
    assert (EVENTS[event](man).act, man.state) == (act, after)


def test_the_table_is_whole() -> None:
    assert len(TABLE) == 4 * len(EVENTS)


def test_beats_drive_at_what_they_say() -> None:
    assert beat(in_state("driving")) == Verdict("drive", 0.1, 0.2, valid_for=VALID_FOR)


def test_a_beat_while_it_is_opened_is_what_is_driven_then() -> None:
    man = in_state("opening")
    beat(man)
    verdict = man.opened(10.2)
    assert (verdict.act, verdict.vx, verdict.wz) == ("drive", 0.1, 0.2)
    assert verdict.valid_for == pytest.approx(VALID_FOR - 0.1), "from when the beat was sent"


def test_a_hand_that_let_go_before_it_was_open_drives_nothing() -> None:
    man = in_state("opening")
    man.end("released")
    assert man.opened(10.1).act == ZERO


def test_opening_that_took_too_long_drives_nothing() -> None:
    man = in_state("opening")
    assert man.opened(10.0 + SILENCE_SECONDS + 0.01) == Verdict(ZERO, reason="silent")


def test_silence_is_seen_by_a_beat_that_comes_after_it() -> None:
    man = in_state("driving")
    late = 10.0 + SILENCE_SECONDS + 0.01
    assert man.beat(3, late, 0.1, 0.0, late) == Verdict(ZERO, reason="silent")
    assert man.beat(4, late, 0.1, 0.0, late).act == "none", "and nothing resumes"


def test_a_late_beat_is_no_sign_of_life() -> None:
    man = in_state("driving")
    assert man.beat(3, 10.1, 0.1, 0.0, 10.1 + MAX_LATE_SECONDS + 0.01).act == "none"
    assert man.tick(10.0 + SILENCE_SECONDS + 0.01).act == ZERO


@pytest.mark.parametrize("late", [0.05, 0.2, MAX_LATE_SECONDS - 0.001])
def test_a_beat_counts_from_when_it_was_sent(late: float) -> None:
    """A busy server that reads it later drives for as much shorter, and is silent as much earlier."""
    man = in_state("driving")
    verdict = man.beat(3, 10.1, 0.1, 0.0, 10.1 + late)
    assert verdict.act == "drive"
    assert verdict.valid_for == pytest.approx(VALID_FOR - late)
    assert man.tick(10.1 + SILENCE_SECONDS - 0.01).act == "none"
    assert man.tick(10.1 + SILENCE_SECONDS + 0.01).act == ZERO


def test_what_took_long_to_open_waits_for_the_next_beat() -> None:
    man = in_state("opening")
    assert man.opened(10.0 + VALID_FOR + 0.01).act == "none"
    assert man.state == "driving"
    assert man.beat(3, 10.35, 0.2, 0.0, 10.35).act == "drive"


def test_a_heap_of_old_beats_prolongs_nothing() -> None:
    """What a network has kept for 0.39 s and delivers at once counts as far as it is fresh, not longer."""
    man = in_state("driving")
    acts = [man.beat(2 + i, 10.0 + 0.03 * i, 0.2, 0.0, 10.39).act for i in range(1, 13)]
    fresh = [10.0 + 0.03 * i >= 10.39 - MAX_LATE_SECONDS for i in range(1, 13)]
    assert acts == ["drive" if one else "none" for one in fresh]


def test_clocks_need_not_agree() -> None:
    man = DeadManSwitch()
    assert man.press(1, 5e5, 0.2, 0.0, 10.0).act == "open"
    man.opened(10.0)
    assert man.beat(2, 5e5 + 0.1, 0.2, 0.0, 10.12).act == "drive"


def test_a_clock_that_is_set_back_ends_the_drive() -> None:
    man = in_state("driving")
    for i in range(1, 4):
        assert man.beat(2 + i, 10.0 + 0.1 * i - 3600.0, 0.2, 0.0, 10.0 + 0.1 * i).act == "none"
    assert man.tick(10.0 + SILENCE_SECONDS + 0.01).act == ZERO


def test_a_clock_that_is_set_forward_makes_what_was_sent_before_late() -> None:
    man = in_state("driving")
    assert man.beat(3, 3610.1, 0.2, 0.0, 10.1).act == "drive"
    assert man.beat(4, 10.2, 0.2, 0.0, 10.2).act == "none"
    assert man.beat(5, 3610.3, 0.2, 0.0, 10.3).act == "drive"


def test_clocks_that_run_apart_are_forgiven_between_presses() -> None:
    """An hour at 100 ppm is 0.36 s."""
    man = in_state("ended")
    assert man.press(3, 3610.0 - 0.36, 0.2, 0.0, 3610.0).act == "open"


@pytest.mark.parametrize("seq", [1, 0])
def test_a_press_that_was_sent_before_opens_nothing(seq: int) -> None:
    man = in_state("ended")
    assert man.press(seq, 10.1, 0.2, 0.0, 10.1) == Verdict("none", reason="not a new press")


def test_a_press_that_comes_late_opens_nothing() -> None:
    man = in_state("ended")
    assert man.press(3, 10.1, 0.2, 0.0, 11.0) == Verdict("none", reason="late")


@pytest.mark.parametrize("wrong", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("place", range(3))
def test_what_is_no_number_ends_the_drive(wrong: float, place: int) -> None:
    man, numbers = in_state("driving"), [10.1, 0.1, 0.0]
    numbers[place] = wrong
    assert man.beat(3, *numbers, 10.1).act == ZERO


EVENT = st.tuples(
    st.sampled_from(["press", "opened", "beat", "end", "tick"]),
    st.integers(0, 40),
    st.floats(-0.5, 0.5),
    st.floats(0.0, 0.3),
)


@given(st.lists(EVENT, max_size=60))
def test_nothing_drives_longer_than_the_silence_after_the_last_fresh_beat(events: list) -> None:
    """Whatever comes in whatever order: when nothing comes any more, it is over within the silence."""
    man, now, driven = DeadManSwitch(), 100.0, False
    for kind, seq, skew, pause in events:
        now += pause
        if kind in ("press", "beat"):
            verdict = getattr(man, kind)(seq, now + skew, 0.2, 0.0, now)
        elif kind == "end":
            verdict = man.end("released")
        else:
            verdict = getattr(man, kind)(now)
        driven = verdict.act == "drive" or (driven and verdict.act != ZERO)
        assert not driven or man.state == "driving"
    if man.held:
        assert man.tick(now + SILENCE_SECONDS + 0.001).act == ZERO
    assert not man.held
    assert man.beat(1000, now + 1.0, 0.2, 0.0, now + 1.0).act == "none"
