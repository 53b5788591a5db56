"""Cuts messages into fragments for clients that want them, and joins fragments from clients.

Each fragment is a message `{"op": "fragment", "id", "data", "num", "total"}`; `data` is a piece of the JSON
text (ROSBRIDGE_PROTOCOL.md, 3.1.1). Incomplete messages of a client are bounded, and forgotten after a while.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field

from rosproto.json_values import JsonValue

MAX_SENT = 4096
"""Most fragments of a sent message; tiny pieces are made longer."""
MAX_RECEIVED = 1 << 16
INCOMPLETE = 16
"""Most incomplete messages of one client at a time."""
SECONDS = 600.0
"""Seconds without a fragment after which an incomplete message is forgotten, as in rosbridge."""
_OVERHEAD = 100  # bytes of memory of a fragment besides its text


class FragmentError(Exception):
    """A fragment is invalid; the text is a sentence for the client."""


def split(text: str, size: int, id: str | float) -> tuple[str, ...]:
    """Split a JSON text into fragments with `size` characters each; roslib ignores those with the id 0."""
    size = max(size, -(-len(text) // MAX_SENT))
    pieces = [text[start : start + size] for start in range(0, len(text), size)]
    total = len(pieces)
    return tuple(
        json.dumps({"op": "fragment", "id": id, "data": piece, "num": num, "total": total})
        for num, piece in enumerate(pieces)
    )


@dataclass(slots=True)
class _Incomplete:
    total: int
    seen: float
    pieces: dict[int, str] = field(default_factory=dict)


class Reassembly:
    """Joins the fragments of one client.

    Attributes:
        held: Approximate bytes of memory of incomplete messages.
    """

    def __init__(self, max_bytes: int) -> None:
        self._max_bytes = max_bytes
        self._waiting: dict[str | float, _Incomplete] = {}
        self.held = 0

    def __len__(self) -> int:
        return len(self._waiting)

    def add(self, message: dict[str, JsonValue], now: float) -> str | None:
        """Take a fragment; return the whole text if it is complete.

        Args:
            message: The fragment's fields, unchecked.
            now: Monotonic seconds.

        Raises:
            FragmentError: It is invalid, or too much is incomplete; its message is dropped.
        """
        self._forget_old(now)
        id, num, total, data = (message.get(key) for key in ("id", "num", "total", "data"))
        if not isinstance(id, (str, int)) or isinstance(id, bool):
            raise FragmentError("field id of a fragment is missing or neither a text nor a whole number")
        if not isinstance(data, str):
            raise FragmentError("field data of a fragment is missing or not a text")
        try:
            return self._add(id, _whole(num), _whole(total), data, now)
        except FragmentError:
            self._forget(id)
            raise

    def _add(self, id: str | float, num: int | None, total: int | None, data: str, now: float) -> str | None:
        if total is None or not 0 < total <= MAX_RECEIVED:
            raise FragmentError(f"field total of a fragment must be a whole number from 1 to {MAX_RECEIVED}")
        if num is None or not 0 <= num < total:
            raise FragmentError(f"field num of a fragment must be a whole number from 0 to {total - 1}")
        found = self._waiting.get(id)
        if found is None:
            if len(self._waiting) >= INCOMPLETE:
                raise FragmentError(f"{INCOMPLETE} messages are incomplete already; send one at a time")
            found = self._waiting[id] = _Incomplete(total, now)
        if found.total != total:
            raise FragmentError(f"a fragment has total {total}, an earlier one of its message {found.total}")
        if num in found.pieces:
            raise FragmentError(f"fragment {num} was received twice")
        found.pieces[num] = data
        found.seen = now
        self.held += _cost(data)
        if self.held > self._max_bytes:
            raise FragmentError(f"incomplete messages have more than the limit of {self._max_bytes} bytes")
        if len(found.pieces) < total:
            return None
        self._forget(id)
        return "".join(found.pieces[number] for number in range(total))

    def _forget_old(self, now: float) -> None:
        for id in [id for id, found in self._waiting.items() if now - found.seen > SECONDS]:
            self._forget(id)

    def _forget(self, id: str | float) -> None:
        found = self._waiting.pop(id, None)
        if found is not None:
            self.held -= sum(map(_cost, found.pieces.values()))


def _cost(data: str) -> int:
    return data.__sizeof__() + _OVERHEAD


def _whole(value: object) -> int | None:
    return value if type(value) is int else None
