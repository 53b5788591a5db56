"""`PersistentOrder`: the order machine of one vehicle, with its state saved on disk.

The state is saved before it is published and before anything begins. So an acknowledged order survives a
restart, and an action that has begun does not begin again. If the disk fails, `DiskFailed` is applied to the
old state, and
the event to the result: orders are rejected and nothing begins, but stopping the vehicle works as always.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from rosproto.logs import get_logger
from woosh_pure.fleet.messages.parsing import Invalid
from woosh_pure.fleet.order.errors import ErrorType, Level, Problem
from woosh_pure.fleet.order.events import (
    DiskFailed,
    DiskRecovered,
    Effect,
    Event,
    PublishState,
    Restarted,
)
from woosh_pure.fleet.order.machine import step
from woosh_pure.fleet.order.state import OrderState, changed, first_state, read_state
from woosh_pure.fleet.order.vehicle_limits import Capabilities

if TYPE_CHECKING:
    from woosh_pure.state_file import Store

_log = get_logger("woosh_pure.fleet.persistent_order")


class PersistentOrder:
    """One vehicle's order and its file. Not for several threads at a time.

    Args:
        limits: The vehicle's capabilities.
        store: The file; None saves nothing.
        name: The vehicle's name, for the log.

    Attributes:
        state: The current state; any thread may read it.
        failing: The disk fails; call `write` again after a while.
        unsaved: The state has not been saved and published yet; call `write`.
    """

    def __init__(self, limits: Capabilities, store: Store | None, name: str) -> None:
        self.state = first_state(limits)
        self.failing = self.unsaved = False
        self._store, self._name = store, name
        self._saved: OrderState | None = None  # what was saved last

    def restore(self) -> list[Effect]:
        """Restore the saved state, before any other event; return the effects."""
        kept = [] if self._store is None else self._store.load()
        if kept and self._store is not None:
            try:
                self.state = read_state(changed(kept[0], kept[1:]), self.state.limits)
            except (Invalid, KeyError, TypeError, ValueError, AttributeError) as error:
                self._store.put_aside(f"{type(error).__name__}: {error}")
            else:
                return [*self.apply(Restarted())]
        return []

    def apply(self, event: Event, *, later: bool = False) -> Iterator[Effect]:
        """Apply an event. Carry out each effect before taking the next one.

        Args:
            event: The event.
            later: If nothing begins, save and publish with the next event, or with `write`.
        """
        before = self.state
        after, effects = step(before, event)
        yield from effects.stops  # before anything is written on disk
        if later and not effects.begins:
            self.state = after
            self.unsaved = self.unsaved or effects.saves or effects.publishes
            return
        publishes, begins = self.unsaved or effects.publishes, effects.begins
        if (self.unsaved or effects.saves) and not self.failing:
            problem = self._save(after)
            if problem is None:
                after = after._replace(actions_to_save=frozenset())
            else:
                self.failing = publishes = True
                without, _ = step(before, DiskFailed(problem))
                after, again = step(without, event)
                begins = [each for each in (*again.stops, *again.begins) if each not in effects.stops]
        self.state, self.unsaved = after, False
        if publishes:
            yield PublishState()
        yield from begins

    def write(self) -> list[Effect]:
        """Save the current state, if it was put off or the disk has failed; return the effects."""
        problem = self._save(self.state)
        if problem is None:
            self.state = self.state._replace(actions_to_save=frozenset())
        effects: list[Effect] = [PublishState()] if self.unsaved else []
        failed, self.failing, self.unsaved = self.failing, problem is not None, False
        if problem is not None and not failed:
            return [*self.apply(DiskFailed(problem))]
        if problem is None and failed:
            _log.warning("! %s: the state is kept on disk again", self._name)
            return [*self.apply(DiskRecovered())]
        return effects

    def _save(self, state: OrderState) -> Problem | None:
        """Save a state; the problem if it cannot be saved."""
        if self._store is None:
            return None
        try:
            if self._saved is None or not self._store.add(state.change_since(self._saved)):
                self._store.save(state.to_json())
            self._saved = state
            return None
        except OSError as error:
            text = (
                f"the state cannot be kept in {self._store}: {error}; no order is taken and no action "
                "begins, because a restart would forget them"
            )
        if not self.failing:
            _log.error("! %s: %s", self._name, text)
        hint = "make room, or let it be written; it is tried again and again"
        return Problem(ErrorType.STORAGE, text, level=Level.FATAL, hint=hint)
