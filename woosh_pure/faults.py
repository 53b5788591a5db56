"""Status codes: the meaning of a number on /status_code, and the active faults. Pure: no clock, no network.

A code has 12 decimal digits: version (1), department (1), module (2), submodule (2), function state (5),
level (1). Level 0 means normal or recovered and clears the other codes of the same submodule; submodule 00
clears its module.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache
from importlib import resources
from typing import Any

from rosproto.sentence import both, say
from woosh_pure.enums import RobotState
from woosh_pure.hints import FAULTS, Hints
from woosh_pure.language import Spoken

__all__ = [
    "ActiveFaults",
    "Department",
    "FaultLevel",
    "Faults",
    "StatusCode",
    "all_codes",
    "chinese",
    "decode_status_code",
    "english",
    "with_words",
]


@lru_cache(maxsize=1)
def _words() -> dict[str, dict[str, str]]:
    """The words of the identifiers, by language. Only words whose spelling does not read as plain English are
    listed for English. The vendor's misspellings (ABNOR, SEANNER, SUCESS, ININT ...) are keys, because the
    identifiers contain them.
    """
    words: dict[str, dict[str, str]] = _data("status_words.json")
    return words


def _data(name: str) -> Any:
    return json.loads(resources.files("woosh_pure").joinpath(f"data/{name}").read_text(encoding="utf-8"))


def _split(word: str) -> tuple[str, str]:
    stem = word.rstrip("0123456789")
    return stem, word[len(stem) :]


def english(words: list[str]) -> str:
    """The words of an identifier as an English phrase."""
    parts = []
    for word in words:
        stem, number = _split(word)
        parts.append(_words()["english"].get(stem, stem.lower()) + (f" {number}" if number else ""))
    return " ".join(p for p in parts if p)


def chinese(words: list[str]) -> str:
    """The words of an identifier as a Chinese phrase; a word without translation stays as it is."""
    return "".join(_words()["chinese"].get(stem, stem) + number for stem, number in map(_split, words))


class FaultLevel(IntEnum):
    """Last digit of a code (our reading of the table)."""

    NORMAL = 0
    NOTICE = 1
    WARNING = 2
    SEVERE = 3


class Department(IntEnum):
    """Second digit of a code: the part of the robot."""

    UNKNOWN = 0
    ELECTRICAL = 1
    EMBEDDED = 2
    SYSTEM = 3
    APPLICATION = 4


@dataclass(frozen=True, slots=True)
class _VendorWords:
    """The words of a status code: the vendor's table has them in both languages."""

    english: str
    chinese: str

    def __str__(self) -> str:
        return self.english

    def said(self, language: str) -> str:
        """Return the text in a language of `woosh_pure.language`."""
        return self.chinese if language == "zh" else self.english


@dataclass(frozen=True, slots=True)
class StatusCode:
    """One decoded code.

    Attributes:
        code: The number on the wire.
        identifier: The vendor's name for it, "" when the table has none.
        english, chinese: One short sentence.
        derived: True when the sentence is made from the identifier (or from the number) alone.
        level: Its severity.
        department: The part of the robot.
        module, submodule: Two digits each.
        function_state: Five digits.
        version: First digit.
        other_identifiers: Further names of the same number (one code of the table has two).
    """

    code: int
    identifier: str
    english: str
    chinese: str
    derived: bool
    level: FaultLevel
    department: Department
    module: int
    submodule: int
    function_state: int
    version: int
    other_identifiers: tuple[str, ...] = ()

    @property
    def known(self) -> bool:
        """True when the vendor's table has this code."""
        return bool(self.identifier)

    @property
    def is_fault(self) -> bool:
        """True for warnings and severe codes."""
        return self.level >= FaultLevel.WARNING

    @property
    def source(self) -> tuple[int, int, int, int]:
        """(version, department, module, submodule): what a level-0 code clears."""
        return (self.version, self.department, self.module, self.submodule)

    def __str__(self) -> str:
        return say("{words} ({code})", words=_VendorWords(self.english, self.chinese), code=self.code)


@lru_cache(maxsize=1)
def _table() -> dict[int, list[object]]:
    return {int(code): entry for code, entry in _data("status_codes.json").items()}


def all_codes() -> Iterator[StatusCode]:
    """Every code of the vendor's table, decoded."""
    return map(decode_status_code, _table())


@lru_cache(maxsize=1024)
def decode_status_code(code: int) -> StatusCode:
    """Decode a number of /status_code; any uint64 is valid, and unknown ones have `known` False."""
    entry = _table().get(code)
    identifiers, en, zh, derived = _texts(code, entry)
    digits = f"{code:012d}"
    regular = len(digits) == 12
    level = int(digits[11]) if regular else FaultLevel.NOTICE
    return StatusCode(
        code=code,
        identifier=identifiers[0] if identifiers else "",
        english=en,
        chinese=zh,
        derived=derived,
        level=FaultLevel(level) if level <= FaultLevel.SEVERE else FaultLevel.WARNING,
        department=_department(digits) if regular else Department.UNKNOWN,
        module=int(digits[2:4]) if regular else 0,
        submodule=int(digits[4:6]) if regular else 0,
        function_state=int(digits[6:11]) if regular else 0,
        version=int(digits[0]) if regular else 0,
        other_identifiers=tuple(identifiers[1:]),
    )


def with_words(text: str) -> str:
    """Return a chassis's text about a goal with the words of its code ("status code 110201000013")."""
    found = re.fullmatch(r"status code (\d{6,20})", text)
    if found is None:
        return text
    code = decode_status_code(int(found[1]))
    words = _VendorWords(code.english, code.chinese)
    return say("status code {code} ({words})", code=found[1], words=words)


def _department(digits: str) -> Department:
    number = int(digits[1])
    return Department(number) if number <= Department.APPLICATION else Department.UNKNOWN


def _texts(code: int, entry: list[object] | None) -> tuple[list[str], str, str, bool]:
    if entry is None:
        return [], f"unknown code {code}", f"未知状态码 {code}", True
    identifiers = [str(name) for name in entry[0]]  # type: ignore[attr-defined]
    if len(entry) == 3:
        return identifiers, str(entry[1]), str(entry[2]), False
    words = [name.split("_")[1:] for name in identifiers]
    return identifiers, " or ".join(map(english, words)), "或".join(map(chinese, words)), True


class Faults(tuple[StatusCode, ...], Spoken, Hints):
    """Received faults that have not ended, the worst first, and whether there are no others.

    Codes are sent on change only, so earlier ones are not received. The state of the robot shows whether
    there are any: a robot that is idle or has a task has no fault.

    Attributes:
        robot_state: The last reported state, None if none was received.
    """

    _hints = FAULTS
    robot_state: RobotState | None

    def __new__(cls, codes: Iterable[StatusCode] = (), robot_state: RobotState | None = None) -> Faults:
        made = super().__new__(cls, codes)
        made.robot_state = robot_state
        return made

    @property
    def known(self) -> bool:
        """True when the robot's state shows that there are no other faults."""
        state = self.robot_state
        return state is not None and state.known and state not in _NOT_WELL

    @property
    def present(self) -> bool | None:
        """Whether there is a fault: True, False, or None when that is not known."""
        if self or self.robot_state in (RobotState.WARNING, RobotState.FAULT):
            return True
        return False if self.known else None

    def __str__(self) -> str:
        """Describe the faults in one line."""
        if self:
            return both(*map(str, self))
        if self.present:
            return say(
                "the robot reports a {state}; its code was not heard, look at its display",
                state=self.robot_state,
            )
        return "none" if self.known else NOT_KNOWN


_NOT_WELL = (RobotState.UNDEFINED, RobotState.UNINITIALISED, RobotState.WARNING, RobotState.FAULT)
NOT_KNOWN = (
    "not known: no code was heard (they are sent on change only), and the robot has not reported its state"
)


MAX_FAULTS = 1000
"""No robot has so many at once (the vendor's table has 405): more are made up, by number."""


class ActiveFaults:
    """The set of currently active faults, kept from the codes as they come; at most `MAX_FAULTS`.

    Several nodes publish on /status_code; each code stands for its submodule, so merging them is safe.
    Not thread-safe: the owner holds a lock.
    """

    def __init__(self) -> None:
        self._active: dict[int, tuple[StatusCode, frozenset[object]]] = {}
        self._before: dict[int, StatusCode] = {}

    def receive(self, code: int, links: frozenset[object] = frozenset()) -> StatusCode:
        """Take in one code and return it decoded; its end would come over one of `links`."""
        decoded = decode_status_code(code)
        if decoded.known and decoded.level is FaultLevel.NORMAL:
            self._clear(decoded.source)
        elif decoded.is_fault:
            self._before.pop(code, None)
            self._active[code] = decoded, links
            if len(self._active) + len(self._before) > MAX_FAULTS:
                self._forget_one()
        return decoded

    def _clear(self, source: tuple[int, int, int, int]) -> None:
        # Submodule 00 speaks for its whole module (140200000000 "initialisation done" ends the 1402xx
        # failures).
        depth = 4 if source[3] else 3
        self._active = {c: f for c, f in self._active.items() if f[0].source[:depth] != source[:depth]}
        self._before = {c: f for c, f in self._before.items() if f.source[:depth] != source[:depth]}

    def _forget_one(self) -> None:
        """Remove the oldest of the least severe faults, first of those that may be over."""
        known = self._before or {code: fault for code, (fault, _) in self._active.items()}
        (self._before or self._active).pop(min(known, key=lambda code: known[code].level))

    def keep_links(self, up: frozenset[object]) -> None:
        """Keep only the faults received over a link in `up` as active.

        The others may be over: their end may have been missed, or the robot was restarted.
        """
        for code, (fault, links) in list(self._active.items()):
            if not links <= up:
                del self._active[code]
                self._before[code] = fault

    def forget_before(self) -> None:
        """Remove the faults that may be over, because the robot reports that it has none."""
        self._before.clear()

    @property
    def before(self) -> tuple[StatusCode, ...]:
        """Faults that may be over."""
        return tuple(self._before.values())

    @property
    def active(self) -> tuple[StatusCode, ...]:
        """Active faults, the worst first, then in order of arrival."""
        return tuple(sorted((fault for fault, _ in self._active.values()), key=lambda fault: -fault.level))
