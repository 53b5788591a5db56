"""What was done through the web, by whom, and how it ended: the last entries, for all to see."""

from __future__ import annotations

import itertools
import threading
import time
from collections import OrderedDict
from dataclasses import asdict, dataclass, replace
from typing import Any

from rosproto.text import printable

__all__ = ["Entry", "Journal"]

LENGTH = 200


@dataclass(frozen=True, slots=True)
class Entry:
    """One line of it.

    Attributes:
        id: Grows by one with each entry.
        at: When it began, s since 1970.
        who: Who asked for it, as others see them.
        what: What was asked, in words.
        state: "under way", or how it ended: "arrived", "failed", "cancelled", "done", "refused" ...
        text: The library's sentence about its end; "" before.
        ended: When it ended, s since 1970; None before.
        goal: Id of the goal it is about, "" when it is about none.
    """

    id: int
    at: float
    who: str
    what: str
    state: str = "under way"
    text: str = ""
    ended: float | None = None
    goal: str = ""

    def as_json(self) -> dict[str, Any]:
        """As it is sent."""
        return asdict(self)


class Journal:
    """The last entries, safe from any thread. Bounded: the oldest go.

    Attributes:
        version: Grows with each change.
    """

    def __init__(self, length: int = LENGTH) -> None:
        self._length = length
        self._lock = threading.Lock()
        self._numbers = itertools.count(1)
        self._entries: OrderedDict[int, Entry] = OrderedDict()
        self._changed: OrderedDict[int, int] = OrderedDict()
        self.version = 0

    def begin(self, who: str, what: str, goal: str = "") -> int:
        """Something was asked for; its number, for `end`."""
        with self._lock:
            number = next(self._numbers)
            self._put(Entry(number, round(time.time(), 3), _short(who), _short(what), goal=goal))
            while len(self._entries) > self._length:
                oldest, _ = self._entries.popitem(last=False)
                self._changed.pop(oldest, None)
            return number

    def end(self, number: int, state: str, text: str = "") -> None:
        """How it ended; of an entry that has gone, nothing is kept."""
        with self._lock:
            entry = self._entries.get(number)
            if entry is not None:
                self._put(replace(entry, state=state, text=_short(text, 1000), ended=round(time.time(), 3)))

    def note(self, who: str, what: str, state: str = "done", text: str = "") -> None:
        """Something that was done at once."""
        self.end(self.begin(who, what), state, text)

    def entries(self) -> list[Entry]:
        """All of them, the oldest first."""
        with self._lock:
            return list(self._entries.values())

    def since(self, version: int) -> list[Entry]:
        """Those that changed after that version."""
        with self._lock:
            return [self._entries[number] for number, when in self._changed.items() if when > version]

    def _put(self, entry: Entry) -> None:
        self.version += 1
        self._entries[entry.id] = entry
        self._changed[entry.id] = self.version


def _short(text: str, most: int = 200) -> str:
    """One line, whatever somebody has put into it."""
    text = printable(text)
    return text if len(text) <= most else text[: most - 1] + "…"
