"""cv_bridge.boost.cv_bridge_boost: the functions that programs import."""

from ..encodings import converted as cvtColor2
from ..encodings import cv_type as getCvType

__all__ = ["cvtColor2", "getCvType"]
