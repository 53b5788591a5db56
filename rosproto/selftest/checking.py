"""What a check is, and how it is run: with a time limit, and with its failure as a sentence."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Iterator
from enum import Enum
from typing import NamedTuple

from rosproto.sentence import say

LIMIT = 15.0
"""Seconds that a check may take; on a quiet machine the longest takes two."""


class CheckFailed(Exception):
    """What was found is not what must hold; the text says both."""


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
        name: A word for it.
        work: Runs the check and returns a sentence on what it has shown. Raises CheckFailed, NotApplicable, or
            any error of the code under test.
    """

    name: str
    work: Callable[[], str]


class Outcome(NamedTuple):
    """The result of a check.

    Attributes:
        name: Of the check.
        state: Fine, failed, or nothing to check here (which is no success, and no failure either).
        seconds: What it took.
        text: What was shown, or what is wrong.
    """

    name: str
    state: State
    seconds: float
    text: str


def run(checks: Iterable[Check], *, limit: float = LIMIT) -> Iterator[Outcome]:
    """Run them one after the other; each outcome as soon as it is there."""
    for check in checks:
        began = time.monotonic()
        state, text = _bounded(check, limit)
        yield Outcome(check.name, state, time.monotonic() - began, text)


def _bounded(check: Check, limit: float) -> tuple[State, str]:
    """In a thread, which is left alone when it hangs: a check that waits for ever is a finding, too."""
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
    except Exception as error:  # a check finds out what goes wrong, whatever that is
        return State.FAILED, f"{type(error).__name__}: {error}"
