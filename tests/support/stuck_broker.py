"""A fake broker: accepts connections, may answer the first packet, and reads only on request."""

from __future__ import annotations

import socket
import threading
from types import TracebackType

__all__ = ["StuckBroker"]

CONNACK = b"\x20\x03\x00%c\x00"  # MQTT 5, without properties
OLD_CONNACK = b"\x20\x02\x00%c"  # MQTT 3.1.1
LEVEL = 8  # offset of the protocol level in a CONNECT shorter than 128 bytes; 9 in a longer one


class StuckBroker:
    """Use it in a `with` block.

    Args:
        answer: The code of its CONNACK, 0 to accept the client; None never answers.
        old: Support MQTT 3.1.1 only.

    Attributes:
        accepted: Number of accepted connections.
        names: Client ids, as their CONNECT says them.
        reading: Set while it reads; read data is discarded.
    """

    def __init__(self, answer: int | None = 0, *, old: bool = False) -> None:
        self.answer, self.old = answer, old
        self.accepted = 0
        self.names: list[str] = []
        self.reading = threading.Event()
        self.came = threading.Condition()
        self._closing = threading.Event()
        self._clients: list[socket.socket] = []
        self._server = socket.create_server(("127.0.0.1", 0))
        self.url = f"mqtt://127.0.0.1:{self._server.getsockname()[1]}"
        self._threads = [threading.Thread(target=self._accept, daemon=True)]

    def __enter__(self) -> StuckBroker:
        self._threads[0].start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._closing.set()
        self.reading.set()
        self._server.shutdown(socket.SHUT_RDWR)
        self._server.close()
        self.hang_up()
        for thread in self._threads:
            thread.join(5.0)

    def hang_up(self) -> None:
        """End all connections."""
        for client in self._clients:
            try:
                client.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass  # already disconnected
            client.close()
        self._clients.clear()

    def _accept(self) -> None:
        while not self._closing.is_set():
            try:
                client, _ = self._server.accept()
            except OSError:
                return
            self._clients.append(client)
            thread = threading.Thread(target=self._talk, args=(client,), daemon=True)
            self._threads.append(thread)
            with self.came:
                self.accepted += 1
                self.came.notify_all()
            thread.start()

    def _talk(self, client: socket.socket) -> None:
        try:
            found = client.recv(4096)
            if found and self.answer is not None:
                at = LEVEL + (found[1] >= 0x80)
                level = found[at]
                at += 4  # flags and keep-alive follow, in MQTT 5 the properties
                at += 1 + found[at] if level == 5 else 0
                length = int.from_bytes(found[at : at + 2], "big")
                with self.came:
                    self.names.append(found[at + 2 : at + 2 + length].decode())
                    self.came.notify_all()
                client.sendall(
                    OLD_CONNACK % (1 if level == 5 else self.answer) if self.old else CONNACK % self.answer
                )
            while not self._closing.is_set():
                self.reading.wait()
                if not client.recv(65536):
                    return
        except OSError:
            return  # closed by `hang_up`
