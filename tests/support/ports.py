"""A port for a server that cannot take port 0, or that must come back on the one it had."""

from __future__ import annotations

import random
import socket

__all__ = ["unused_port"]

# Below the ephemeral ports of Linux, macOS and Windows (from 32768 or 49152 on), so that no other program gets the
# port between check and use.
_RANGE = range(10_000, 32_000)


def unused_port(host: str = "127.0.0.1") -> int:
    """Return an unused port outside the ephemeral range."""
    chance = random.SystemRandom()  # tests that run beside this one have the same seed
    while True:
        port = chance.choice(_RANGE)
        with socket.socket() as probe:
            try:
                probe.bind((host, port))
            except OSError:
                continue
            return port
