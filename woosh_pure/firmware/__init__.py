"""Firmwares of the chassis: their definitions, what each cannot be told, how new definitions are learned."""

from __future__ import annotations

from woosh_pure.firmware.versions import CURRENT, Firmware, firmware_names, revision_label, revision_of

__all__ = ["CURRENT", "Firmware", "firmware_names", "revision_label", "revision_of"]
