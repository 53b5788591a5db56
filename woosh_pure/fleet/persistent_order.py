"""One vehicle's order, in a file: the way of an event through the machine and the disk.

What is acknowledged is there after a restart, and what has begun does not begin again: the state is written
before anything is told or begun. When the disk takes nothing, `DiskFailed` happens to the state of before,
and the event to the state after that: it rejects orders and begins nothing, while what stops the vehicle goes
on as ever.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Protocol

from rosproto.logs import get_logger
from woosh_pure.fleet.messages.schema import Invalid
from woosh_pure.fleet.order.errors import ErrorType, Level, Problem
from woosh_pure.fleet.order.events import (
    DiskFailed,
    DiskRecovered,
    Effect,
    Event,
    PublishState,
    Restarted,
    SaveState,
    stops,
)
from woosh_pure.fleet.order.machine import step
from woosh_pure.fleet.order.state import OrderState, first_state, read_state
from woosh_pure.fleet.order.vehicle_limits import Capabilities

_log = get_logger("woosh_pure.fleet.persistent_order")


class StateFile(Protocol):
    """Where the state is kept: `store.Store`, or a stand-in of a test."""

    def load(self) -> dict[str, Any] | None:
        """What was saved last; None where nothing was."""

    def save(self, data: dict[str, Any]) -> None:
        """Replace it; OSError when the disk takes nothing."""

    def put_aside(self, why: str) -> None:
        """Keep an unusable file under another name."""


class PersistentOrder:
    """The state of one vehicle's order, which every event passes. Not for several threads at a time.

    Args:
        limits: What the vehicle is able to obey.
        store: The file; None keeps nothing.
        name: Of the vehicle, for the log.

    Attributes:
        state: As it is now; any thread may read it.
        failing: The disk takes nothing; `write` is to be called again after a while.
        owed: The state was not written and told yet; `write` does it.
    """

    def __init__(self, limits: Capabilities, store: StateFile | None, name: str) -> None:
        self.state = first_state(limits)
        self.failing = self.owed = False
        self._store, self._name = store, name

    def restore(self) -> list[Effect]:
        """Take what was kept, before anything happens; the effects of it."""
        kept = None if self._store is None else self._store.load()
        if kept is not None and self._store is not None:
            try:
                self.state = read_state(kept, self.state.limits)
            except (Invalid, KeyError, TypeError, ValueError, AttributeError) as error:
                self._store.put_aside(f"{type(error).__name__}: {error}")
            else:
                return [*self.happens(Restarted())]
        return []

    def happens(self, event: Event, *, later: bool = False) -> Iterator[Effect]:
        """Let an event happen; each effect is to be carried out before the next one is asked for.

        Args:
            event: What happens.
            later: Write and tell it with the next event, or `write`, if nothing begins because of it.
        """
        before = self.state
        after, effects = step(before, event)
        done = [effect for effect in effects if stops(effect)]
        yield from done  # what stops waits for no disk
        begins = [
            effect
            for effect in effects
            if not (stops(effect) or isinstance(effect, (SaveState, PublishState)))
        ]
        if later and not begins:
            self.state, self.owed = after, self.owed or len(effects) > len(done)
            return
        tells = self.owed or PublishState() in effects
        if (self.owed or SaveState() in effects) and not self.failing:
            problem = self._save(after)
            if problem is not None:
                self.failing = tells = True
                without, _ = step(before, DiskFailed(problem))
                after, effects = step(without, event)
                begins = [
                    each
                    for each in effects
                    if each not in done and not isinstance(each, (SaveState, PublishState))
                ]
        self.state, self.owed = after, False
        if tells:
            yield PublishState()
        yield from begins

    def write(self) -> list[Effect]:
        """Write the state as it is, with what was put off, or once more on a disk that took nothing; the
        effects."""
        problem = self._save(self.state)
        told: list[Effect] = [PublishState()] if self.owed else []
        failed, self.failing, self.owed = self.failing, problem is not None, False
        if problem is not None and not failed:
            return [*self.happens(DiskFailed(problem))]
        if problem is None and failed:
            _log.warning("! %s: the state is kept on disk again", self._name)
            return [*self.happens(DiskRecovered())]
        return told

    def _save(self, state: OrderState) -> Problem | None:
        """Why it cannot be written; None when it is."""
        if self._store is None:
            return None
        try:
            self._store.save(state.to_json())
            return None
        except OSError as error:
            text = (
                f"the state cannot be kept in {self._store}: {error}; no order is taken and no action "
                "begins, because a restart would forget them"
            )
        if not self.failing:
            _log.error("! %s: %s", self._name, text)
        hint = "make room, or let it be written; it is tried again and again"
        return Problem(ErrorType.STORAGE, text, (), Level.FATAL, hint)
