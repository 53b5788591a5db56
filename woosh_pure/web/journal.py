"""What was done through the web, by whom, and how it ended. The last entries are shown to everybody."""

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
    """One entry of the journal.

    Attributes:
        id: Grows by one with each entry.
        at: When it began, s since 1970.
        who: The name of the client that asked for it.
        what: What was asked for, in words.
        state: "under way", or how it ended: "arrived", "failed", "cancelled", "done", "refused" ...
        text: The library's sentence about how it ended; "" before that.
        ended: When it ended, s since 1970; None before that.
        goal: Id of the goal that the entry is about; "" if it is not about a goal.
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
        """The entry as the API sends it."""
        return asdict(self)


class Journal:
    """The last entries; older ones are dropped. Safe from any thread.

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
        """Add an entry for something that was asked for; returns its number, to be given to `end`."""
        with self._lock:
            number = next(self._numbers)
            self._put(Entry(number, round(time.time(), 3), _short(who), _short(what), goal=goal))
            while len(self._entries) > self._length:
                oldest, _ = self._entries.popitem(last=False)
                self._changed.pop(oldest, None)
            return number

    def end(self, number: int, state: str, text: str = "") -> None:
        """Note how it ended. Does nothing if the entry has been dropped meanwhile."""
        with self._lock:
            entry = self._entries.get(number)
            if entry is not None:
                self._put(replace(entry, state=state, text=_short(text, 1000), ended=round(time.time(), 3)))

    def note(self, who: str, what: str, state: str = "done", text: str = "") -> None:
        """Add an entry for something that is done already."""
        self.end(self.begin(who, what), state, text)

    def entries(self) -> list[Entry]:
        """All entries, the oldest first."""
        with self._lock:
            return list(self._entries.values())

    def since(self, version: int) -> list[Entry]:
        """The entries that were added or changed after that version."""
        with self._lock:
            return [self._entries[number] for number, when in self._changed.items() if when > version]

    def _put(self, entry: Entry) -> None:
        self.version += 1
        self._entries[entry.id] = entry
        self._changed[entry.id] = self.version


def _short(text: str, most: int = 200) -> str:
    """One printable line of limited length, whatever a client has sent."""
    text = printable(text)
    return text if len(text) <= most else text[: most - 1] + "…"
