"""`*.mission.toml`: read a mission from its text, with the line of each fault, and write it."""

from __future__ import annotations

import bisect
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rosproto.files import read_text, save_file
from rosproto.profile import directory
from rosproto.sentence import led, say
from woosh_pure.missions import mission as model
from woosh_pure.missions.mission import Mission, MissionError, mission_of
from woosh_pure.toml_text import toml_values

MAX_BYTES = 64 << 10
SUFFIX = ".mission.toml"
_BARE = re.compile(r"[A-Za-z0-9_-]+")


def parse(text: str, name: str = "mission") -> Mission:
    """Read a mission from the text of its file.

    Args:
        name: Of the file, for errors.

    Raises:
        MissionError: It is faulty: line, column, what was found, what is allowed.
        ImportError: Python 3.10 without the extra `missions`.
    """
    if len(text.encode()) > MAX_BYTES:
        raise MissionError(say("{name}: more than {max_bytes} bytes", name=name, max_bytes=MAX_BYTES))
    try:
        data = toml_values(text, "missions")
    except ValueError as error:
        place = re.search(r"line (\d+), column (\d+)", str(error))
        line, column = map(int, place.groups()) if place else (text.count("\n") + 1, 1)
        wrong = re.sub(r" \(at .*\)$", "", str(error))
        raise _at(MissionError(say("not TOML: {error}", error=wrong), (), line, column), name) from None
    try:
        return mission_of(data)
    except MissionError as error:
        error.line, error.column = _place(text, error.path)
        raise _at(error, name) from None


@dataclass(frozen=True, slots=True)
class StoredMission:
    """One file of the folder, by its name without the suffix; `mission` is None if it is faulty: `error`."""

    file: str
    mission: Mission | None
    error: str = ""


class MissionFiles:
    """The folder of the mission files.

    Attributes:
        files: The folder, the user's; another one may be set.
    """

    def __init__(self) -> None:
        self.files = directory() / "missions"

    def list(self) -> Sequence[StoredMission]:
        """The files of the folder of missions, sorted by name."""
        found = []
        for path in sorted(self.files.glob(f"*{SUFFIX}"), key=lambda path: path.name):
            name = path.name.removesuffix(SUFFIX)
            try:
                found.append(StoredMission(name, self.load(path, path.name)))
            except (MissionError, OSError) as error:
                found.append(StoredMission(name, None, getattr(error, "strerror", "") or str(error)))
        return found

    def path(self, file: str | Path) -> Path:
        """A file that exists: a path, or a name in the folder of missions, with or without its suffix.

        Raises:
            MissionError: There is none.
        """
        for path in (Path(file), self.files / file, self.files / f"{file}{SUFFIX}"):
            if path.is_file():
                return path
        wrong = "{file}: there is no such file, also not in {folder}"
        raise MissionError(say(wrong, file=file, folder=self.files))

    def load(self, file: str | Path, name: str = "") -> Mission:
        """Read a file, see `path`.

        Args:
            name: For errors; "" is its path.

        Raises:
            MissionError: It is faulty, or there is none.
            OSError: It cannot be read.
        """
        path = self.path(file)
        name = name or str(path)
        try:
            text = read_text(path, limit=MAX_BYTES)
        except ValueError:
            wrong = "{name} is not text in UTF-8 of at most {max_bytes} bytes"
            raise MissionError(say(wrong, name=name, max_bytes=MAX_BYTES)) from None
        return parse(text, name)

    def save(self, file: str, mission: Mission | Mapping[str, Any]) -> StoredMission:
        """Write a file of the folder of missions: a mission, or its `data()`.

        Raises:
            MissionError: It is faulty, or `file` is not a name. Nothing is written.
            OSError: It cannot be written.
        """
        checked, path = mission if isinstance(mission, Mission) else mission_of(mission), self._named(file)
        save_file(path, text_of(checked).encode(), durable=True)
        return StoredMission(file.removesuffix(SUFFIX), checked)

    def remove(self, file: str) -> None:
        """Delete a file of the folder of missions. Raises MissionError if there is none."""
        self.path(self._named(file)).unlink()

    def _named(self, file: str) -> Path:
        name = file.removesuffix(SUFFIX)
        if not re.fullmatch(r"[\w][\w .-]{0,99}", name):
            raise MissionError(say("{file!r}: expected a name of letters, digits, blanks, _ . -", file=file))
        return self.files / f"{name}{SUFFIX}"


def text_of(mission: Mission) -> str:
    """The file of a mission. Comments of a file that was read are not kept."""
    data = mission.data()
    lines = [f"{key} = {_toml(data[key])}" for key in ("mission", "name", "description") if key in data]
    for table in ("parameters", "guards"):
        if table in data:
            lines += ["", f"[{table}]", *_pairs(data[table])]
    for table in ("step", "on_abort"):
        for step in data.get(table, ()):
            lines += ["", f"[[{table}]]", *_pairs(step)]
    return "\n".join(lines) + "\n"


def _pairs(table: Mapping[str, Any]) -> list[str]:
    return [f"{_key(key)} = {_toml(value)}" for key, value in table.items()]


def _key(key: str) -> str:
    return key if _BARE.fullmatch(key) else _toml(key)


def _toml(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{ " + ", ".join(_pairs(value)).replace("\n", " ") + " }" if value else "{}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_toml, value)) + "]"
    # A basic string of TOML is one of JSON, except that TOML has no DEL and no surrogates in it.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def _at(error: MissionError, name: str) -> MissionError:
    where = say("{name}, line {line}, column {column}", name=name, line=error.line, column=error.column)
    return MissionError(led(where, str(error)), error.path, error.line, error.column)


def _place(text: str, path: model.Path) -> tuple[int, int]:
    """Line and column at which the statement begins that gives a key.

    tomllib keeps no places. But the lines up to the end of a statement are TOML, too; so the line is that
    with which the key appears. A key that is missing has the place of its table's header.
    """
    lines = text.splitlines(keepends=True)

    def known(count: int) -> bool:
        """Whether the key is there with the statement that ends in or after this line."""
        while True:
            try:
                values: Any = toml_values("".join(lines[:count]), "missions")
            except ValueError:
                count += 1  # within a text or list of several lines
                continue
            try:
                for part in path:
                    values = values[part]
            except (KeyError, IndexError, TypeError):
                return False
            return True

    if not path or not known(len(lines)):
        return _place(text, path[:-1]) if path else (1, 1)
    line = bisect.bisect_left(range(1, len(lines) + 1), True, key=known) + 1
    found = lines[line - 1]
    return line, len(found) - len(found.lstrip()) + 1
