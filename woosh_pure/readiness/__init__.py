"""Whether the chassis would move now, and the known reasons why it would not."""

from __future__ import annotations

from woosh_pure.readiness.readiness_state import assess, status_shows_fitness, triggered_keys
from woosh_pure.reasons import Readiness, Ready, Reason, ReasonKey

__all__ = ["Readiness", "Ready", "Reason", "ReasonKey", "assess", "status_shows_fitness", "triggered_keys"]
