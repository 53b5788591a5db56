"""`woosh doctor`: why it does not work, in plain words. Nothing is moved and nothing is sent to the robot."""

from __future__ import annotations

from woosh_pure.doctor.checks import Finding, Level
from woosh_pure.doctor.examination import examine

__all__ = ["Finding", "Level", "examine"]
