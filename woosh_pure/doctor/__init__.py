"""`woosh doctor`: finds out why a connection does not work. Nothing is moved or sent to the robot."""

from __future__ import annotations

from woosh_pure.doctor.checks import Finding, Level
from woosh_pure.doctor.examination import examine

__all__ = ["Finding", "Level", "examine"]
