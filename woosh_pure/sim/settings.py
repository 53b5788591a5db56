"""How a simulated chassis is set up."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from woosh_pure.geometry import Pose2D
from woosh_pure.sim.body import BodyLimits


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """Options of the simulated world; all times in simulated seconds.

    Attributes:
        seed: Of everything random; equal seeds and equal commands give equal runs.
        start: Pose at power-up; None takes the site's.
        located: Whether the robot knows its position at power-up.
        limits: Of the drives.
        radius: Of the round body, m.
        navigation_speed: Of tasks and of /move_base, m/s.
        on_silence: What the base does when velocity messages end: "keep" drives on (the real chassis is not
            documented, so the dangerous case is assumed), "stop" stops after `silence_seconds`.
        silence_seconds: See `on_silence`.
        obstacle_patience: How long a motion waits for an obstacle before it fails, s.
        battery_percent: At power-up.
        battery_rate: Time factor of draining and charging.
        drift: Relative error of the odometry, at most.
    """

    seed: int = 0
    start: Pose2D | None = None
    located: bool = True
    limits: BodyLimits = field(default_factory=BodyLimits)
    radius: float = 0.3
    navigation_speed: float = 0.8
    on_silence: Literal["keep", "stop"] = "keep"
    silence_seconds: float = 0.5
    obstacle_patience: float = 10.0
    battery_percent: float = 87.0
    battery_rate: float = 1.0
    drift: float = 0.01
