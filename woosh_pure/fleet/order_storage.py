"""The order machine on disk, and what is told while the disk takes nothing."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rosproto.logs import get_logger
from woosh_pure.fleet.messages.elements import Order
from woosh_pure.fleet.messages.schema import Invalid
from woosh_pure.fleet.order.errors import ErrorType, Level, Problem
from woosh_pure.fleet.order.limits import Limits
from woosh_pure.fleet.order.machine import OrderMachine
from woosh_pure.fleet.store import Store, StoreInUse

__all__ = ["OrderStorage"]

_log = get_logger("woosh_pure.fleet.order_storage")


class OrderStorage:
    """Keeps one machine.

    Args:
        store: The file; None keeps nothing.
        prefix: Of the vehicle's topics, for the log.
        failed: Called when the disk takes nothing, with the problem the first time, and then with None.
        recovered: Called when it takes the state again.

    Attributes:
        kept: What was to be kept last.
    """

    def __init__(
        self,
        store: Store | None,
        prefix: str,
        failed: Callable[[Problem | None], object],
        recovered: Callable[[], object],
    ) -> None:
        self._store, self._prefix = store, prefix
        self._failed, self._recovered = failed, recovered
        self._failing = False
        self.kept: dict[str, Any] = {}

    def lock(self) -> None:
        """Keep other vehicles from using the file; a disk that takes nothing is told with the first `save`.

        Raises:
            StoreInUse: Another one does.
        """
        try:
            if self._store is not None:
                self._store.lock()
        except StoreInUse:
            raise
        except OSError as error:
            _log.warning("! %s: %s cannot be locked: %s", self._prefix, self._store, error)

    def unlock(self) -> None:
        """Let other vehicles use the file."""
        if self._store is not None:
            self._store.unlock()

    def restore(self, limits: Limits) -> OrderMachine | None:
        """The machine that was kept; None where there is none."""
        kept = None if self._store is None else self._store.load()
        if kept is None or self._store is None:
            return None
        try:
            return OrderMachine.from_json(kept, limits)
        except (Invalid, KeyError, TypeError, ValueError, AttributeError) as error:
            self._store.put_aside(f"{type(error).__name__}: {error}")
            return None

    def save(self, machine: OrderMachine) -> None:
        """Put it on disk, when it differs from what is there."""
        if self._store is None:
            return
        self.kept = machine.to_json()
        try:
            self._store.save(self.kept)
        except OSError as error:
            self._tell(error)
            return
        if self._failing:
            self._failing = False
            _log.warning("! %s: the state is kept on disk again", self._prefix)
            self._recovered()

    def save_with(self, machine: OrderMachine, order: Order) -> OSError | None:
        """Put it on disk as it will be with an order, before the machine takes that; why it could not be."""
        if self._store is None:
            return None
        trial = machine.trial_copy()
        trial.receive(order)
        try:
            self._store.save(trial.to_json())
        except OSError as error:
            self._tell(error)
            return error
        return None

    def _tell(self, error: OSError) -> None:
        assert self._store is not None
        if self._failing:
            self._failed(None)
            return
        self._failing = True
        text = (
            f"the state cannot be kept in {self._store.path}: {error}; no order is taken and no action "
            "begins, because a restart would forget them"
        )
        _log.error("! %s: %s", self._prefix, text)
        hint = "make room, or let it be written; it is tried again and again"
        self._failed(Problem(ErrorType.STORAGE, text, (), Level.FATAL, hint))
