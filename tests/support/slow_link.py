"""A TCP proxy that simulates a poor radio link: limited rate, latency and outages, without loss as in TCP.

with SlowLink("127.0.0.1", server.port, latency=0.2, rate=30_000) as link:
    link.outage(2.0)       # delivers nothing for 2 s; sent data waits
"""

from __future__ import annotations

import asyncio
import threading
import time
from contextlib import suppress

__all__ = ["SlowLink"]

PIECE = 1460
"""Bytes per piece, as in a packet: the connections share the line piece by piece."""


class SlowLink:
    """Forwards connections to a target.

    Attributes:
        latency: Delay of each piece in seconds, in each direction. May be changed at any time.
        rate: Bytes per second in each direction, for all connections together. May be changed at any time.
        port: The listening port on 127.0.0.1.
        down: Bytes received from the target so far.
    """

    def __init__(self, host: str, port: int, *, latency: float, rate: float) -> None:
        self._target, self.latency, self.rate = (host, port), latency, rate
        self._free = {"up": 0.0, "down": 0.0}
        self._dark_until = 0.0
        self.port = self.down = 0
        self._loop = asyncio.new_event_loop()
        self._ready = threading.Event()
        self._tasks: set[asyncio.Task[None]] = set()
        self._thread = threading.Thread(target=self._run, name="slow link", daemon=True)

    def __enter__(self) -> SlowLink:
        self._thread.start()
        assert self._ready.wait(10)
        return self

    def __exit__(self, *_: object) -> None:
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(10)

    def outage(self, seconds: float) -> None:
        """Deliver nothing for `seconds` from now on."""
        self._dark_until = time.monotonic() + seconds

    def _run(self) -> None:
        loop = self._loop
        server = loop.run_until_complete(asyncio.start_server(self._take, "127.0.0.1", 0))
        self.port = server.sockets[0].getsockname()[1]
        self._ready.set()
        loop.run_forever()
        server.close()
        tasks = asyncio.all_tasks(loop)
        for task in tasks:
            task.cancel()
        if tasks:
            loop.run_until_complete(asyncio.wait(tasks))
        loop.close()

    def _take(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = self._loop.create_task(self._connected(reader, writer))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await asyncio.sleep(2 * self.latency)  # the handshake
        with suppress(OSError):
            there, back = await asyncio.open_connection(*self._target)
            try:
                await asyncio.gather(self._forward("up", reader, back), self._forward("down", there, writer))
            finally:
                back.close()
        writer.close()

    async def _forward(
        self, direction: str, source: asyncio.StreamReader, sink: asyncio.StreamWriter
    ) -> None:
        under_way: asyncio.Queue[tuple[float, bytes]] = asyncio.Queue()
        arriving = asyncio.ensure_future(self._deliver(under_way, sink))
        try:
            data = b"."
            while data:
                with suppress(ConnectionError):
                    data = b""
                    data = await source.read(PIECE)
                begun = max(time.monotonic(), self._free[direction], self._dark_until)
                self._free[direction] = sent = begun + len(data) / self.rate
                await asyncio.sleep(sent - time.monotonic())
                under_way.put_nowait((sent + self.latency, data))
                if direction == "down":
                    self.down += len(data)
            await arriving
        finally:
            arriving.cancel()

    async def _deliver(
        self, under_way: asyncio.Queue[tuple[float, bytes]], sink: asyncio.StreamWriter
    ) -> None:
        """Deliver pieces in order, each at its due time; an empty piece closes the other side."""
        with suppress(ConnectionError):
            while True:
                due, data = await under_way.get()
                while (left := max(due, self._dark_until) - time.monotonic()) > 0:
                    await asyncio.sleep(left)
                if not data:
                    sink.close()
                    return
                sink.write(data)
                await sink.drain()
