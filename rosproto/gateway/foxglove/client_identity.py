"""Tells the client the proxy has let in from another program that connects to its SDK server's port.

The proxy's first frames on that port advertise a channel whose name is a secret, and take it back at once.
The SDK reports the advertisement with its number for that connection, which then is the client.
"""

from __future__ import annotations

import hmac
import json
import secrets
import threading

from rosproto.gateway.foxglove import handshake

__all__ = ["ClientIdentity"]

CHANNEL = 0xFFFFFFFF  # number of the channel that carries the secret


class ClientIdentity:
    """The SDK's number for the one client of a session, once it is known.

    Attributes:
        introduction: The frames that the proxy sends ahead of the client's own.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._secret = secrets.token_hex(32)
        self._client: int | None = None
        channel = {"id": CHANNEL, "topic": self._secret, "encoding": "json", "schemaName": ""}
        self.introduction = handshake.text_frame(
            json.dumps({"op": "advertise", "channels": [channel]})
        ) + handshake.text_frame(json.dumps({"op": "unadvertise", "channelIds": [CHANNEL]}))

    def introduced(self, client: int, topic: str) -> bool:
        """Whether an advertisement carries the secret; the first client that does is the one."""
        if not hmac.compare_digest(topic.encode(), self._secret.encode()):
            return False
        with self._lock:
            self._client = client if self._client is None else self._client
        return True

    def is_client(self, client: int) -> bool:
        """Whether this is the client that the proxy let in."""
        with self._lock:
            return self._client == client
