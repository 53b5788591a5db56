"""Run the checks: a time limit for each, and failures as sentences."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Iterator
from enum import Enum
from typing import NamedTuple

from rosproto.sentence import say

LIMIT = 60.0
"""Seconds that a check may take: the longest takes two on a quiet machine, forty on a busy one."""


class CheckFailed(Exception):
    """A check found something else than expected; the text says both."""


class NotApplicable(Exception):
    """There is nothing to check on this machine; the text says what is missing."""


class State(Enum):
    """How a check ended."""

    FINE = "fine"
    FAILED = "FAILED"
    NOT_HERE = "not here"


class Check(NamedTuple):
    """One check.

    Attributes:
        name: One word for it.
        work: Runs the check and returns a sentence on what it has shown. Raises CheckFailed, NotApplicable,
            or any error of the code under test.
    """

    name: str
    work: Callable[[], str]


class Outcome(NamedTuple):
    """The result of a check.

    Attributes:
        name: The check's name.
        state: Fine, failed, or not applicable (neither success nor failure).
        seconds: How long it took.
        text: What was shown, or what is wrong.
    """

    name: str
    state: State
    seconds: float
    text: str


def run(checks: Iterable[Check], *, limit: float = LIMIT) -> Iterator[Outcome]:
    """Run the checks one after the other; yield each outcome as soon as it is known."""
    for check in checks:
        began = time.monotonic()
        state, text = _bounded(check, limit)
        yield Outcome(check.name, state, time.monotonic() - began, text)


def _bounded(check: Check, limit: float) -> tuple[State, str]:
    """Run in a thread that is abandoned when it hangs: a check that never ends has failed."""
    found: list[tuple[State, str]] = []
    thread = threading.Thread(
        target=lambda: found.append(_outcome_of(check)), name=f"rosproto:selftest:{check.name}", daemon=True
    )
    thread.start()
    thread.join(limit)
    return found[0] if found else (State.FAILED, say("it did not end within {seconds:g} s", seconds=limit))


def _outcome_of(check: Check) -> tuple[State, str]:
    try:
        return State.FINE, check.work()
    except NotApplicable as reason:
        return State.NOT_HERE, str(reason)
    except CheckFailed as failure:
        return State.FAILED, str(failure)
    except Exception as error:  # any error is the result of the check
        return State.FAILED, f"{type(error).__name__}: {error}"


def expect(what: str, found: object, wanted: object) -> None:
    """Raise CheckFailed if the two differ."""
    if found != wanted:
        raise CheckFailed(
            say("{what}: received {found!r}, expected {wanted!r}", what=what, found=found, wanted=wanted)
        )
