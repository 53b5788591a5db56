"""Connecting keeps to the time it was given."""

from __future__ import annotations

import socket

import pytest

from rosproto.errors import RosTimeout
from woosh_pure import Chassis


def test_a_master_that_says_nothing_is_given_up_in_the_time_of_the_chassis() -> None:
    """`timeout=` counts for connecting, too, not only for services."""
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        with pytest.raises(RosTimeout, match=r"no answer within 0\.2 s"):
            Chassis(f"127.0.0.1:{silent.getsockname()[1]}", timeout=0.2).__enter__()
