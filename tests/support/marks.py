"""Conditions that tests of several folders share."""

from __future__ import annotations

import sys

import pytest

__all__ = ["needs_rst"]

needs_rst = pytest.mark.skipif(
    sys.platform == "win32", reason="Wine sends FIN where SO_LINGER 0 asks for RST"
)
