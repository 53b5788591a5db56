"""`MarkFile`: the user's own list of marks (name, pose, note); the chassis's ROS interface cannot list them.

The file is JSON: `{"A1": {"x": 3.0, "y": 1.0, "yaw": 1.57, "note": "shelf"}}`; x, y in m, yaw in rad, map
frame. `"charger": true` is a charger, `"on_chassis": false` a place that is not on the chassis's own map.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from rosproto.errors import RosError
from rosproto.files import read_text, save_file
from rosproto.profile import directory
from rosproto.sentence import Sentence, both, hint, say
from woosh_pure.geometry import Pose2D

NEAR_MARK = 0.4
"""`cutoff` of `near_names` for marks, whose names are short."""
SIMULATED_MARKS = "/woosh_sim/marks"
"""The parameter with the marks of a simulated chassis, as a text like a mark file; a real one has none."""


@dataclass(frozen=True, slots=True)
class UserMark:
    """One mark of the user's list; the pose may be unknown.

    Attributes:
        name: Its name.
        pose: Its pose in the map.
        note: Free text.
        charger: Whether there is a charger.
        on_chassis: Whether the chassis's own map has a mark of this name for tasks. Else it is a place, and
            the robot is sent to its pose.
        source: "list", or "robot" for a mark that the robot itself has named.
    """

    name: str
    pose: Pose2D | None = None
    note: str = ""
    charger: bool = False
    on_chassis: bool = True
    source: str = "list"


def with_robot_marks(own: Iterable[UserMark], robot: Iterable[UserMark]) -> list[UserMark]:
    """The user's list and the robot's marks. Of two with one name it is the user's, with the robot's pose
    where the list has none.
    """
    found = {mark.name: mark for mark in robot}
    for mark in own:
        known = found.pop(mark.name, None)
        found[mark.name] = replace(mark, pose=known.pose) if known and mark.pose is None else mark
    return list(found.values())


def mark_file() -> Path:
    """Return the file of the user's marks."""
    return directory() / "marks.json"


class MarkFile:
    """The marks of one site in a file.

    Attributes:
        path: The file; it need not exist yet.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._marks: dict[str, UserMark] = {}
        self._texts: dict[str, tuple[UserMark, str]] = {}  # as last saved: others are formatted again
        self._read: tuple[int, int] | None = None
        self.refresh()

    def refresh(self) -> None:
        """Read the file again if another program has changed it.

        Raises:
            ValueError: The file is not a list of marks.
            OSError: The file cannot be read.
        """
        stamp = self._stamp()
        if stamp == self._read:
            return
        if stamp is None:
            self._marks = {}
        else:
            self._load()
        self._read = stamp

    def _stamp(self) -> tuple[int, int] | None:
        try:
            found = self.path.stat()
        except (FileNotFoundError, NotADirectoryError):
            return None
        return found.st_mtime_ns, found.st_size

    def _load(self) -> None:
        try:
            self._marks = marks_of(read_text(self.path))
        except (ValueError, TypeError, AttributeError, KeyError) as error:
            example = '{"A1": {"x": 3.0, "y": 1.0, "yaw": 1.57}}'
            wrong = "{path}: not a mark file ({error}); expected {example}"
            raise ValueError(say(wrong, path=self.path, error=error, example=example)) from error

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
            missing = say("mark {name!r} is not in {path}", name=name, path=self.path)
            raise KeyError(with_marks(missing, self._marks, name)) from None

    @property
    def names(self) -> list[str]:
        """All names, sorted, for completion on a command line."""
        return sorted(self._marks)

    def put(
        self, name: str, pose: Pose2D | None = None, note: str = "", *, on_chassis: bool | None = None
    ) -> UserMark:
        """Add a mark, or replace its pose and note; `save` writes the file.

        Args:
            name: The name on the chassis's map, or that of your own place.
            pose: Its pose in the map; None if not known.
            note: Free text.
            on_chassis: False for a place that is not on the chassis's map; None keeps the earlier value.

        Raises:
            ValueError: The name is empty, the pose is not finite, or a place has no pose.
        """
        if not name.strip():
            raise ValueError("a mark needs a name")
        where = None if pose is None else replace(pose.require_finite(), frame="map")
        mark = replace(self._marks.get(name, UserMark(name)), pose=where, note=note)
        if on_chassis is not None:
            mark = replace(mark, on_chassis=on_chassis)
        if where is None and not mark.on_chassis:
            raise ValueError(
                say("{name} is a place of this list, not of the chassis's map: it needs a pose", name=name)
            )
        self._marks[name] = mark
        return mark

    def remove(self, name: str) -> None:
        """Remove a mark."""
        del self._marks[self[name].name]

    def save(self) -> None:
        """Write the file; an interrupted write leaves the old one."""
        self.keep(self)

    def keep(self, marks: Iterable[UserMark]) -> None:
        """Replace all marks in the file; nothing changes if writing fails."""
        kept = {mark.name: mark for mark in marks}
        before, texts = self._texts, {}
        for name in sorted(kept):
            known, mark = before.get(name), kept[name]
            texts[name] = known if known is not None and known[0] is mark else (mark, _text(mark))
        save_file(self.path, _joined(each for _, each in texts.values()).encode())
        self._marks, self._texts, self._read = kept, texts, self._stamp()


def marks_of(text: str) -> dict[str, UserMark]:
    """Return the marks of a mark file's text, by name; an invalid text raises one of many errors."""
    return {name: _mark(name, entry) for name, entry in json.loads(text).items()}


def own_marks() -> dict[str, UserMark]:
    """Return the marks of the user's list, by name.

    Raises:
        OSError, ValueError: It cannot be read.
    """
    return {mark.name: mark for mark in MarkFile(mark_file())}


def reported_marks(parameter: Callable[[str], object]) -> dict[str, UserMark]:
    """Return the marks of a simulated chassis, by name; none of a real one. `parameter` gets a parameter."""
    try:
        return marks_of(str(parameter(SIMULATED_MARKS)))
    except (RosError, ValueError):
        return {}


def with_marks(wrong: str, known: Mapping[str, UserMark], given: str = "") -> Sentence:
    """Return the error of a mark that is missing or unknown with the known marks, near ones first."""
    names = sorted(known)
    if not names:
        return both(wrong, "your list has no marks yet: `woosh marks add NAME` keeps where the robot is")
    near = [] if given in names else hint(given, names, NEAR_MARK)
    return both(wrong, *near, say("marks: {names}", names=names))


def text_of(marks: Iterable[UserMark]) -> str:
    """Return the text of a mark file."""
    return _joined(map(_text, marks))


def _joined(texts: Iterable[str]) -> str:
    text = ",\n".join(texts)
    return f"{{\n{text}\n}}\n" if text else "{}\n"


def _mark(name: str, entry: dict[str, object]) -> UserMark:
    note = str(entry.get("note", ""))
    charger, on_chassis = bool(entry.get("charger", False)), bool(entry.get("on_chassis", True))
    if "x" not in entry:
        return UserMark(name, None, note, charger, on_chassis)
    x, y, yaw = (float(str(entry.get(key, 0.0))) for key in ("x", "y", "yaw"))
    return UserMark(name, Pose2D(x, y, yaw).require_finite(), note, charger, on_chassis)


def _text(mark: UserMark) -> str:
    """The lines of a mark in the file."""
    text = json.dumps({mark.name: _entry(mark)}, indent=2, ensure_ascii=False, sort_keys=True)
    return text.removeprefix("{\n").removesuffix("\n}")


def _entry(mark: UserMark) -> dict[str, object]:
    entry: dict[str, object] = {}
    if mark.pose is not None:
        entry.update(x=round(mark.pose.x, 4), y=round(mark.pose.y, 4), yaw=round(mark.pose.yaw, 5))
    if mark.note:
        entry["note"] = mark.note
    if mark.charger:
        entry["charger"] = True
    if not mark.on_chassis:
        entry["on_chassis"] = False
    return entry
