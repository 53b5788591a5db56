"""The name that programs import: all of it is in `woosh_pure.stopping.stop`."""

from __future__ import annotations

from woosh_pure.stopping.stop import StopReport

__all__ = ["StopReport"]
