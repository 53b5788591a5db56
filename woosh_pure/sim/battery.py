"""The simulated battery: drains by time and by driving, charges at the dock or by cable. Pure."""

from __future__ import annotations

import math

from woosh_pure.geometry import Velocity

__all__ = ["SimulatedBattery"]


class SimulatedBattery:
    """A 24 V, 40 Ah battery, as far as a client can see it.

    Attributes:
        percent: Charge, 0 to 100, with fractions.
        charging: Whether current flows in.
        automatic: Whether charging was started by a task (charge mode 1).
        rate: Time factor on draining and charging, for tests.
    """

    FULL_AH = 40.0

    def __init__(self, percent: float = 87.0, rate: float = 1.0) -> None:
        self.percent = percent
        self.charging = False
        self.automatic = False
        self.rate = rate
        self._current = -1.5

    def step(self, dt: float, velocity: Velocity) -> None:
        """Let `dt` s pass."""
        speed = math.hypot(velocity.vx, velocity.vy) + 0.3 * abs(velocity.wz)
        self._current = 15.0 if self.charging else -(1.5 + 8.0 * speed)
        change = self._current * dt / 3600.0 / self.FULL_AH * 100.0 * self.rate
        self.percent = min(100.0, max(0.0, self.percent + change))

    @property
    def voltage(self) -> float:
        """V."""
        return 22.4 + 0.05 * self.percent + (0.6 if self.charging else 0.0)

    @property
    def current(self) -> float:
        """A, negative when it drains."""
        return self._current

    @property
    def capacity(self) -> float:
        """Ah left."""
        return self.FULL_AH * self.percent / 100.0
