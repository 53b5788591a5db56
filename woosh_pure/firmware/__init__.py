"""Firmware versions of the chassis: their definitions, and how definitions of a robot are learned."""

from __future__ import annotations

from woosh_pure.firmware.versions import CURRENT, Firmware, firmware_names, revision_label, revision_of

__all__ = ["CURRENT", "Firmware", "firmware_names", "revision_label", "revision_of"]
