"""paho-mqtt's client, imported late, with a limit for what comes in."""

from __future__ import annotations

import functools
from typing import Any

__all__ = ["client_class", "paho"]


def paho() -> Any:
    """paho.mqtt.client.

    Raises:
        ImportError: It is not installed; the text names the extra.
    """
    try:
        import paho.mqtt.client as client
    except ImportError as error:
        raise ImportError('VDA 5050 needs paho-mqtt 2: pip install ".[fleet]"', name="paho") from error
    return client


@functools.cache
def client_class() -> Any:
    """The class of our clients."""

    class Client(paho().Client):  # type: ignore[misc]
        """paho's, which has no limit of its own and takes packets of up to 256 MB."""

        @property
        def incoming(self) -> int:
            """Bytes of the packet that is being read."""
            try:
                return int(self._in_packet["remaining_length"])
            except (AttributeError, KeyError):
                return 0  # a later paho that does it otherwise: then without a limit

    return Client
