"""The name that programs import: all of it is in `woosh_pure.maps.marks`."""

from __future__ import annotations

from woosh_pure.maps.marks import MarkFile, UserMark

__all__ = ["MarkFile", "UserMark"]
