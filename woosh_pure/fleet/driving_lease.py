"""One driver at a time: while an order is carried out the chassis's lease belongs to the fleet manager."""

from __future__ import annotations

import time
from collections.abc import Callable

from woosh_pure.chassis import Chassis

_LEASE_SECONDS = 60.0
_RENEW_SECONDS = _LEASE_SECONDS / 3.0


class DrivingLease:
    """The lease of one chassis, as its fleet manager has it.

    Args:
        chassis: The chassis.
        serial: Of the vehicle; part of the owner's name.
        due: When something is to be done; "lease" in it is when `renew` is to be called.
    """

    def __init__(self, chassis: Chassis, serial: str, due: dict[str, float]) -> None:
        self._lease, self._owner = chassis.lease, f"fleet manager of {serial}"
        self._due = due

    def on_change(self, call: Callable[[], object]) -> Callable[[], None]:
        """Call back when the holder changes or somebody asks; what is returned ends that."""
        return self._lease.on(lambda state: call())

    @property
    def local_driver(self) -> str:
        """Who else has the robot; "" while nobody has."""
        holder = self._lease.holder
        return "" if holder in (None, self._owner) else str(holder)

    def hand_over(self) -> None:
        """A local driver who asks for the lease gets it: MANUAL, and the order is cleared."""
        asking = self._lease.state.asking
        if self._lease.holder == self._owner and asking:
            self._lease.grant(self._owner, asking[0])

    def hold(self, executing: bool) -> None:
        """Take it while an order is carried out, and give it back afterwards."""
        if not executing:
            self.release()
        elif "lease" not in self._due:
            self._due["lease"] = 0.0

    def renew(self, executing: bool) -> bool:
        """Keep it; False while a local driver has it."""
        if not executing:
            del self._due["lease"]
            return True
        self._due["lease"] = time.monotonic() + _RENEW_SECONDS
        return bool(self._lease.acquire(self._owner, _LEASE_SECONDS))

    def release(self) -> None:
        """Give it back."""
        self._due.pop("lease", None)
        if self._lease.holder == self._owner:
            self._lease.release(self._owner)
