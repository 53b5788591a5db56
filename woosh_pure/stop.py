"""The name that programs import: it is in `woosh_pure.stopping.report`."""

from __future__ import annotations

from woosh_pure.stopping.report import StopReport

__all__ = ["StopReport"]
