"""Firmwares of the chassis: their definitions, what each cannot be told, how new definitions are learned."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosproto.late import late_names

if TYPE_CHECKING:
    from woosh_pure.firmware.revisions import CURRENT, Firmware, firmware_names, revision_label, revision_of

__all__ = ["CURRENT", "Firmware", "firmware_names", "revision_label", "revision_of"]

__getattr__ = late_names(
    __name__,
    {
        "CURRENT": "revisions",
        "Firmware": "revisions",
        "firmware_names": "revisions",
        "revision_label": "revisions",
        "revision_of": "revisions",
    },
)
