"""The fleet manager's lease of the chassis: held during an order, and given to a local driver who asks."""

from __future__ import annotations

import time
from collections.abc import Callable

from woosh_pure.chassis import Chassis

_LEASE_SECONDS = 60.0
_RENEW_SECONDS = _LEASE_SECONDS / 3.0


class DrivingLease:
    """The fleet manager's lease of one chassis.

    Args:
        chassis: The chassis.
        serial: The vehicle's serial number, part of the owner's name.
        due: Due times; "lease" is the time of the next `renew`.
    """

    def __init__(self, chassis: Chassis, serial: str, due: dict[str, float]) -> None:
        self._lease, self._owner = chassis.lease, f"fleet manager of {serial}"
        self._due = due

    def on_change(self, call: Callable[[], object]) -> Callable[[], None]:
        """Call back when the holder changes or somebody asks for it; return a function that ends this."""
        return self._lease.on(lambda state: call())

    @property
    def local_driver(self) -> str:
        """The local driver who holds the lease; "" if none does."""
        holder = self._lease.holder
        return "" if holder in (None, self._owner) else str(holder)

    def hand_over(self) -> None:
        """Grant the lease to a local driver who asks; the mode becomes MANUAL, and the order is cleared."""
        asking = self._lease.state.asking
        if self._lease.holder == self._owner and asking:
            self._lease.grant(self._owner, asking[0])

    def hold(self, executing: bool) -> None:
        """Take the lease during an order, and release it afterwards."""
        if not executing:
            self.release()
        elif "lease" not in self._due:
            self._due["lease"] = 0.0

    def renew(self, executing: bool) -> bool:
        """Renew the lease; False while a local driver holds it."""
        if not executing:
            del self._due["lease"]
            return True
        self._due["lease"] = time.monotonic() + _RENEW_SECONDS
        return bool(self._lease.acquire(self._owner, _LEASE_SECONDS))

    def release(self) -> None:
        """Release the lease."""
        self._due.pop("lease", None)
        if self._lease.holder == self._owner:
            self._lease.release(self._owner)
