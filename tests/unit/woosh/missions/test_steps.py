"""How a step ends whose goal ends in one of the ways that there are."""

from __future__ import annotations

import itertools

import pytest

from woosh_pure.missions.machine import Result
from woosh_pure.missions.steps import result_of
from woosh_pure.outcome import NOT_CONFIRMED, Outcome, OutcomeKind

ENDS = [
    *itertools.product(OutcomeKind, (None, True, False), ("", "replaced by another command", NOT_CONFIRMED))
]


@pytest.mark.promise("a STOP while a mission is carried out")
@pytest.mark.parametrize(("kind", "stopped", "text"), ENDS)
def test_only_what_the_robot_or_this_program_explains_is_a_failure(
    kind: OutcomeKind, stopped: bool | None, text: str
) -> None:
    """Only a failure is tried again or leads on; all else ends the run, or asks a person."""
    outcome = Outcome(kind, "drive to A1", text=text, stopped=stopped)
    one, other = result_of(outcome, lambda: False), result_of(outcome, lambda: True)
    assert (one is Result.DONE) is (kind is OutcomeKind.ARRIVED)
    own = kind is OutcomeKind.TIMED_OUT and stopped is True
    rejected = kind is OutcomeKind.REJECTED and text != NOT_CONFIRMED
    assert (one is Result.FAILED) is (own or rejected)
    if one is not other:
        assert (kind, one, other) == (OutcomeKind.FAILED, Result.STOPPED, Result.FAILED)
    if kind in (OutcomeKind.CONNECTION_LOST, OutcomeKind.TIMED_OUT) and not own:
        assert one is Result.UNKNOWN
