"""Status codes of the chassis: what each means, and which faults are active."""

from __future__ import annotations

from woosh_pure.faults.codes import (
    ActiveFaults,
    Department,
    FaultLevel,
    Faults,
    StatusCode,
    all_codes,
    decode_status_code,
)

__all__ = [
    "ActiveFaults",
    "Department",
    "FaultLevel",
    "Faults",
    "StatusCode",
    "all_codes",
    "decode_status_code",
]
