"""A user's own list of marks: name, pose, note. Marks cannot be listed over the chassis's ROS interface.

The file is JSON: `{"A1": {"x": 3.0, "y": 1.0, "yaw": 1.57, "note": "shelf"}}`; x, y in m, yaw in rad, map
frame.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path

from rosproto.files import read_text, write_file
from rosproto.sentence import say
from woosh_pure.geometry import Pose2D

__all__ = ["MarkFile", "UserMark"]


@dataclass(frozen=True, slots=True)
class UserMark:
    """One mark of the user's list; the pose may be unknown."""

    name: str
    pose: Pose2D | None = None
    note: str = ""


class MarkFile:
    """The marks of one site, kept in a file.

    Attributes:
        path: The file; it need not exist yet.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._marks: dict[str, UserMark] = {}
        if self.path.exists():
            self._load()

    def _load(self) -> None:
        try:
            entries = json.loads(read_text(self.path))
            self._marks = {name: _mark(name, entry) for name, entry in entries.items()}
        except (ValueError, TypeError, AttributeError, KeyError) as error:
            example = '{"A1": {"x": 3.0, "y": 1.0, "yaw": 1.57}}'
            raise ValueError(
                say(
                    "{path}: not a mark file ({error}); expected {example}",
                    path=self.path,
                    error=error,
                    example=example,
                )
            ) from error

    def __iter__(self) -> Iterator[UserMark]:
        return iter(self._marks.values())

    def __len__(self) -> int:
        return len(self._marks)

    def __contains__(self, name: str) -> bool:
        return name in self._marks

    def __getitem__(self, name: str) -> UserMark:
        try:
            return self._marks[name]
        except KeyError:
            near = ", ".join(get_close_matches(name, self._marks, 3, 0.4)) or "none is near"
            raise KeyError(
                say(
                    "mark {name!r} is not in {path}; near names: {near}", name=name, path=self.path, near=near
                )
            ) from None

    @property
    def names(self) -> list[str]:
        """All names, sorted, for completion on a command line."""
        return sorted(self._marks)

    def put(self, name: str, pose: Pose2D | None = None, note: str = "") -> UserMark:
        """Add or replace a mark; `save` writes the file."""
        if not name.strip():
            raise ValueError("a mark needs a name")
        mark = UserMark(name, None if pose is None else replace(pose.require_finite(), frame="map"), note)
        self._marks[name] = mark
        return mark

    def remove(self, name: str) -> None:
        """Take a mark off."""
        del self._marks[self[name].name]

    def save(self) -> None:
        """Write the file; an interrupted write leaves the old one."""
        entries = {m.name: _entry(m) for m in self._marks.values()}
        text = json.dumps(entries, indent=2, ensure_ascii=False, sort_keys=True) + "\n"
        self.path.parent.mkdir(parents=True, exist_ok=True)
        temporary = self.path.with_name(self.path.name + ".new")
        write_file(temporary, text.encode())
        os.replace(temporary, self.path)


def _mark(name: str, entry: dict[str, object]) -> UserMark:
    note = str(entry.get("note", ""))
    if "x" not in entry:
        return UserMark(name, None, note)
    x, y, yaw = (float(str(entry.get(key, 0.0))) for key in ("x", "y", "yaw"))
    return UserMark(name, Pose2D(x, y, yaw).require_finite(), note)


def _entry(mark: UserMark) -> dict[str, object]:
    entry: dict[str, object] = {}
    if mark.pose is not None:
        entry.update(x=round(mark.pose.x, 4), y=round(mark.pose.y, 4), yaw=round(mark.pose.yaw, 5))
    if mark.note:
        entry["note"] = mark.note
    return entry
