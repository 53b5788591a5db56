"""Write learned definitions as folders of .msg files, each usable as `msg_path=`.

Definitions that contradict each other (two nodes of one robot with different revisions) go into different
sets. A set is written beside its place, checked by reading it again, and then renamed into it: a program that
ends half-way leaves nothing that anybody would read.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
from collections.abc import Iterable
from pathlib import Path

from rosproto.errors import DefinitionError
from rosproto.msg import DefinitionLibrary, bundled
from rosproto.sentence import say

__all__ = ["LearnedSet", "make_sets", "why_not_kept", "write_set"]

# Names that Windows does not allow for files, whatever their ending.
LONGEST = 251  # characters of a package or a type: with ".msg" the 255 that most systems allow a file
_RESERVED = {"con", "prn", "aux", "nul", *(f"{port}{n}" for port in ("com", "lpt") for n in range(1, 10))}


class LearnedSet:
    """Definitions that go together.

    Attributes:
        texts: Type -> its own text.
        types: The types that were learned, with their md5sums; the other texts are what they use.
    """

    def __init__(self) -> None:
        self.texts: dict[str, str] = {}
        self.types: dict[str, str] = {}
        self._sums: dict[str, str] = {}

    def take(self, name: str, library: DefinitionLibrary) -> bool:
        """Add a type and all it uses; False, and nothing is added, when one contradicts what is here."""
        names = [name, *library.dependencies(name)]
        sums = {used: library.md5sum(used) for used in names}
        # Names that differ in case only are one file on Windows and macOS.
        spelled = {known.lower(): known for known in self._sums}
        for used, md5sum in sums.items():
            if spelled.get(used.lower(), used) != used or self._sums.get(used, md5sum) != md5sum:
                return False
        for used, md5sum in sums.items():
            self._sums[used] = md5sum
            self.texts.setdefault(used, library.message(used).text)
        self.types[name] = sums[name]
        return True

    @property
    def digest(self) -> str:
        """Eight digits that depend on the definitions only: what was learned before is found again by it."""
        lines = "".join(f"{name} {self._sums[name]}\n" for name in sorted(self._sums))
        return hashlib.sha256(lines.encode()).hexdigest()[:8]


def why_not_kept(name: str, library: DefinitionLibrary) -> str:
    """Why a type cannot be kept in files, for itself or for one it uses; "" when it can."""
    for used in [name, *library.dependencies(name)]:
        if problem := _unnameable(used):
            return problem if used == name else f"{name[:LONGEST]} uses {problem}"
    return ""


def _unnameable(name: str) -> str:
    """What is wrong with a type's name as the name of a file and its folder; "" when nothing is."""
    package, _, base = name.partition("/")
    if {package.lower(), base.lower()} & _RESERVED:
        return f"{name}: a file cannot have this name on every system"
    if max(len(package), len(base)) > LONGEST:
        return f"{name[:60]}...: longer than the name of a file may be"
    return ""


def make_sets(learned: Iterable[tuple[str, DefinitionLibrary]]) -> list[LearnedSet]:
    """As few sets as hold all of these without contradiction, in the order given."""
    sets: list[LearnedSet] = []
    for name, library in learned:
        if not any(known.types.get(name) == library.md5sum(name) for known in sets) and not any(
            known.take(name, library) for known in sets
        ):
            fresh = LearnedSet()
            fresh.take(name, library)
            sets.append(fresh)
    return sets


def write_set(learned: LearnedSet, folder: Path, origin: str) -> Path:
    """Write one set below `folder`; returns its own folder.

    Args:
        learned: The definitions.
        folder: The revisions folder; made when it is not there.
        origin: Where from, for the name of the set: a host.

    Raises:
        DefinitionError: What was written does not read back as it was learned.
        OSError: The folder cannot be written.
    """
    label = "".join(c if c.isalnum() or c in "-." else "-" for c in origin).strip(".-") or "robot"
    place = folder / f"{label}-{learned.digest}"
    if place.is_dir():
        return place
    folder.mkdir(parents=True, exist_ok=True)
    work = Path(tempfile.mkdtemp(prefix=".new-", dir=folder))
    try:
        for name, text in learned.texts.items():
            if problem := _unnameable(name):
                raise DefinitionError(say("{problem}; not kept", problem=problem))
            package, _, base = name.partition("/")
            path = work / package / "msg" / f"{base}.msg"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(text.encode("utf-8", "surrogateescape"))
        _check(learned, work)
        work.chmod(0o755)  # mkdtemp keeps it from the user's other accounts, for which there is no reason
        try:
            os.rename(work, place)
        except OSError:
            if not place.is_dir():  # another program has learned the same meanwhile
                raise
    finally:
        shutil.rmtree(work, ignore_errors=True)
    return place


def _check(learned: LearnedSet, work: Path) -> None:
    library = bundled().fork([work])
    for name, md5sum in learned.types.items():
        if library.md5sum(name) != md5sum:
            raise DefinitionError(
                say(
                    "{name}: written to {work}, it has md5sum {md5sum} in place of {expected}",
                    name=name,
                    work=work,
                    md5sum=library.md5sum(name),
                    expected=md5sum,
                )
            )
