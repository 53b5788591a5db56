"""`Settings`: the options of the simulated world."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from woosh_pure.geometry import Pose2D
from woosh_pure.sim.body import BodyLimits


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """Options of the simulated world; all times in simulated seconds.

    Attributes:
        seed: Random seed; equal seeds and commands give equal runs.
        start: Pose at power-up; None uses the site's.
        located: Whether the robot is localised at power-up.
        limits: Limits of the drives.
        radius: Radius of the round body, m.
        navigation_speed: Speed of tasks and /move_base, m/s.
        on_silence: Behaviour when velocity messages end: "keep" drives on (that of the real chassis is not
            documented, so the dangerous case is assumed), "stop" stops after `silence_seconds`.
        silence_seconds: See `on_silence`.
        obstacle_patience: Seconds for which a motion waits for an obstacle before it fails.
        battery_percent: Charge at power-up.
        battery_rate: Time factor of draining and charging.
        drift: Largest relative error of the odometry.
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
