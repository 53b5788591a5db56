"""Sends frames to one page as fast as the page reads them.

The page acknowledges each frame, and at most two frames are unacknowledged. A slow link therefore gets fewer
values, but new ones. A page that stops reading takes the memory of two frames, and is disconnected.
"""

from __future__ import annotations

import asyncio
import time
from collections import deque
from collections.abc import Callable, Mapping

from starlette.websockets import WebSocket

from rosproto.sentence import say
from woosh_pure.web.live.hub import STATE_PARTS, Hub
from woosh_pure.web.snapshot import lease_part, text_of

CREDITS = 2
MAX_ENTRIES = 50
NOTHING_READ, SEND_SECONDS = 15.0, 10.0
"""Seconds after which a page that acknowledges nothing, or accepts nothing, is disconnected."""
_AT_ONCE = ("lost",)
_ORDER = ("scan", "state", "map", "marks", "site", "plan", "obstacles", "journal")
_BINARY = ("color", "depth", "costmap")


class BadMessage(Exception):
    """An invalid message of a page; the text describes the error."""


class FrameSender:
    """Sends one page its own messages, and the newest content of each kind from the hub.

    Used in the event loop only.

    Args:
        hub: The content for all pages of this robot.
        name: The page's name, shown to others.
        is_page: Whether the holder of the lease with this name is a page, and not a program.

    Attributes:
        wake: Set when there is something new.
        watched: Cameras and costmap that are sent to this page.
    """

    def __init__(self, hub: Hub, name: str, is_page: Callable[[str], bool]) -> None:
        self._hub, self._robot, self._name, self._is_page = hub, hub.robot, name, is_page
        self.wake = asyncio.Event()
        self._sent = self._acked = 0
        self._under_way: deque[float] = deque()  # when each unacknowledged frame was sent
        self._round_trip = 0.0  # how long the last frame and its acknowledgement took
        self._heard = time.monotonic()  # the last acknowledgement, or when one became due
        self._versions: dict[str, int] = {}
        self._last_sent: dict[str, int] = {}  # for each kind, the number of its last frame
        self._journal = -1
        self._lease: object = None
        self._own_messages: deque[str] = deque(maxlen=32)
        self.watched: set[str] = set()
        self._parts: deque[bytes] = deque()  # of a costmap that is being sent

    def tell(self, document: Mapping[str, object]) -> None:
        """Send a message to this page only."""
        self._own_messages.append(text_of(document))
        self.wake.set()

    def tell_lease_again(self) -> None:
        """Send the lease again, also if it has not changed."""
        self._lease = None

    def drop_costmap(self) -> None:
        """Discard the rest of a costmap that is being sent."""
        self._parts.clear()

    async def send_all(self, socket: WebSocket) -> None:
        """Send frames until the page stops reading.

        Raises:
            TimeoutError: The page has stopped acknowledging or accepting frames.
        """
        while True:
            self.wake.clear()
            frame = self._next()
            if frame is None:
                if self._sent > self._acked and time.monotonic() - self._heard > NOTHING_READ:
                    raise TimeoutError("you have stopped reading; connect again")
                try:
                    await asyncio.wait_for(self.wake.wait(), 1.0)
                except asyncio.TimeoutError:
                    pass
                continue
            if self._sent == self._acked:
                self._heard = time.monotonic()  # from now on an acknowledgement is due
            self._sent += 1
            self._under_way.append(time.monotonic())
            is_bytes = isinstance(frame, bytes)
            event = {"type": "websocket.send", "bytes" if is_bytes else "text": frame}
            try:
                await asyncio.wait_for(socket.send(event), SEND_SECONDS)
            except asyncio.TimeoutError:
                raise TimeoutError("send timed out; reconnect") from None

    def acknowledge(self, number: object) -> None:
        """Note that the page has received `number` frames.

        Raises:
            BadMessage: `number` is not a number, or is outside the possible range.
        """
        if isinstance(number, bool) or not isinstance(number, int) or not self._acked <= number <= self._sent:
            raise BadMessage(
                say(
                    "n={number!r:.40}: expected the number of frames you have got, {sent} at most",
                    number=number,
                    sent=self._sent,
                )
            )
        now = time.monotonic()
        for _ in range(number - self._acked):
            self._round_trip = now - self._under_way.popleft()
        self._acked, self._heard = number, now
        self.wake.set()

    def round_trip(self) -> float:
        """Seconds from sending a frame to its acknowledgement, now."""
        oldest = time.monotonic() - self._under_way[0] if self._under_way else 0.0
        return max(self._round_trip, oldest)

    def _next(self) -> str | bytes | None:
        if self._own_messages:  # messages for this page are few and urgent
            return self._own_messages.popleft()
        if self._sent - self._acked >= CREDITS:
            return None
        lease = self._lease_news()
        if lease is not None:
            return lease
        for kind in self._in_turn():
            frame = self._state() if kind == "state" else self._news(kind)
            if frame is not None:
                self._last_sent[kind] = self._sent
                return frame
        return None

    def _in_turn(self) -> list[str]:
        """Return all kinds in the order of sending. Over a slow link, pose and scan change with every frame
        and must not displace the rest: the pose gets every other frame, and the others follow in turn.
        """
        looked_at = [kind for kind in _BINARY if kind in self.watched]
        others = sorted([*_ORDER, *looked_at], key=lambda kind: self._last_sent.get(kind, -1))
        # -2: a pose that was never sent is not the frame before the first one either.
        if self._last_sent.get("pose", -2) == self._sent - 1:
            return [*_AT_ONCE, *others, "pose"]
        return [*_AT_ONCE, "pose", *others]

    def _news(self, kind: str) -> str | bytes | None:
        if kind == "journal":
            return self._journal_news()
        if kind == "costmap" and self._parts:  # continue an unfinished costmap
            return self._parts.popleft()
        version, content = self._hub.newest.get(kind, (0, ""))
        if version <= self._versions.get(kind, 0):
            return None
        self._versions[kind] = version
        if isinstance(content, tuple):
            self._parts.extend(content)
            return self._parts.popleft()
        return content

    def _state(self) -> str | None:
        newest, parts = self._hub.newest, []
        for part in STATE_PARTS:
            version, content = newest.get(part, (0, ""))
            if version > self._versions.get(part, 0):
                self._versions[part] = version
                # The hub holds each part as JSON text, so a state is joined from texts.
                parts.append(f'"{part}":{content!s}')
        version, content = newest.get("ages", (0, ""))
        if not parts and version <= self._versions.get("ages", 0):
            return None
        self._versions["ages"] = version
        ages = content or "{}"
        return '{"t":"state",' + "".join(f"{part}," for part in parts) + f'"ages":{ages!s}}}'

    def _journal_news(self) -> str | None:
        journal = self._robot.journal
        if journal.version <= self._journal:
            return None
        since, self._journal = self._journal, journal.version
        return text_of(
            {"t": "journal", "entries": [entry.model_dump() for entry in journal.since(since)[-MAX_ENTRIES:]]}
        )

    def _lease_news(self) -> str | None:
        state = self._robot.chassis.lease.state
        # The seconds that are left count every five: every frame would be news otherwise.
        seen = (state.holder, state.asking, round(state.seconds) // 5)
        if seen == self._lease:
            return None
        self._lease = seen
        return text_of({"t": "lease", **lease_part(state, mine=self._name, is_page=self._is_page)})
