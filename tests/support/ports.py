"""A port for a server that cannot take port 0, or that must come back on the one it had."""

from __future__ import annotations

import random
import socket

__all__ = ["unused_port"]

# Below what Linux, macOS and Windows give out by themselves (from 32768 or 49152 on): nobody else who asks for any
# port, or connects to somewhere, gets it between our look and our use.
_RANGE = range(10_000, 32_000)


def unused_port(host: str = "127.0.0.1") -> int:
    """A port where nobody listens, and which the system gives to nobody by itself."""
    chance = random.SystemRandom()  # tests that run beside this one have the same seed
    while True:
        port = chance.choice(_RANGE)
        with socket.socket() as probe:
            try:
                probe.bind((host, port))
            except OSError:
                continue
            return port
