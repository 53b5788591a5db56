"""Compares the definitions of a robot (a `survey`'s answers) with the known ones, and stores new ones.

Peers are untrusted: a definition is used only if it can be parsed within `DefinitionLimits` and has the
announced md5sum.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

from rosproto.codec import differences
from rosproto.errors import DefinitionError
from rosproto.msg import DefinitionLibrary, MessageSpec, bundled, library_from_full_text
from rosproto.sentence import led, say
from rosproto.text import short
from woosh_pure.firmware.survey import SurveyAnswer


class Comparison(NamedTuple):
    """The comparison of one answer with the known definitions.

    Attributes:
        answer: The answer.
        verdict: "bundled" (the current definition of this package), "revision" (another one of this package),
            "folder" (in one of the user's folders), "new" (can be learned), "unknown" (a service whose .srv
            is needed), "unusable" (the sent text is invalid or does not match), "silent" (no answer).
        source: The revision or the folder; "" otherwise.
        note: Explanation of the difference and its evidence, for display.
        differences: Differences from the bundled definition, one line per field; empty if equal.
        library: The robot's definitions; None if unknown.
    """

    answer: SurveyAnswer
    verdict: str
    source: str = ""
    note: str = ""
    differences: tuple[str, ...] = ()
    library: DefinitionLibrary | None = None


class KnownDefinitions:
    """The known definitions: bundled ones with their revisions, and the user's folders.

    Args:
        folders: Folders for `msg_path=`: learned sets and others.
    """

    def __init__(self, folders: Iterable[Path] = ()) -> None:
        self._folders = [(path, bundled().fork([path])) for path in folders]

    def find(self, kind: str, name: str, md5sum: str) -> tuple[str, str, str, DefinitionLibrary] | None:
        """(verdict, source, note, library) of a definition by its md5sum; None if unknown."""
        for path, library in [(None, bundled()), *self._folders]:
            try:
                if library.has(kind, name) and library.md5sum(name, kind=kind) == md5sum:
                    return ("folder", str(path), "", library) if path else ("bundled", "", "", library)
                revisions = library.revisions(name, kind=kind) if library.has(kind, name) else []
            except DefinitionError:
                continue
            for revision in revisions:
                if revision.md5sum == md5sum:
                    return "revision", revision.label, revision.note, revision.library
        return None


def compare(answer: SurveyAnswer, knowledge: KnownDefinitions) -> Comparison:
    """Compare an answer with the known definitions."""
    if answer.error:
        return Comparison(answer, "silent", note=answer.error)
    kind = "msg" if answer.kind == "topic" else "srv"
    known = knowledge.find(kind, answer.type, answer.md5sum)
    if known is not None:
        verdict, source, note, library = known
        lines = () if verdict == "bundled" else _compare(answer.type, kind, library)
        return Comparison(answer, verdict, source, note, lines, library)
    if kind == "srv":
        return Comparison(answer, "unknown", note=_service_advice(answer))
    try:
        library = library_from_full_text(answer.type, answer.definition)
        md5sum = library.md5sum(answer.type)
    except (DefinitionError, ValueError) as error:
        return Comparison(
            answer, "unusable", note=say("the definition it sent cannot be used: {error}", error=error)
        )
    if md5sum != answer.md5sum:
        note = "it announces md5sum {md5sum}, but the definition it sent has {other}"
        return Comparison(answer, "unusable", note=say(note, md5sum=answer.md5sum, other=md5sum))
    return Comparison(answer, "new", "", "", _compare(answer.type, kind, library), library)


def _service_advice(answer: SurveyAnswer) -> str:
    where = f"{answer.type.replace('/', '/srv/', 1)}.srv"
    if not answer.type or answer.type == "*":
        return say("its provider does not tell the type")
    if bundled().has("srv", answer.type):
        text = "no known revision has this md5sum; the vendor's {file} is needed, in a folder for msg_path="
        return say(text, file=where)
    return say("the type is not known here; its {file} is needed, in a folder for msg_path=", file=where)


def _compare(name: str, kind: str, library: DefinitionLibrary) -> tuple[str, ...]:
    """Differences from the bundled definition, in the type and in the types it uses."""
    base = bundled()
    if not base.has(kind, name):
        return (led(name, "not bundled"),)
    parts = [name] if kind == "msg" else [f"{name}Request", f"{name}Response"]
    names = dict.fromkeys([*parts, *library.dependencies(name, kind=kind)])
    lines: list[str] = []
    for used in names:
        theirs = library.message(used)
        if base.has("msg", used):
            lines += [led(used, line) for line in _lines(base.message(used), theirs)]
        else:
            lines.append(led(used, "not bundled"))
    return tuple(lines)


def _lines(ours: MessageSpec, theirs: MessageSpec) -> Sequence[str]:
    spelled = _other_spellings(ours, theirs)
    text = "{name} is spelled {other} on the robot"
    lines: list[str] = [say(text, name=name, other=other) for name, other in spelled.items()]
    known = {*spelled, *spelled.values()}
    lines += [_words(d.name, d.ours, d.theirs) for d in differences(ours, theirs) if d.name not in known]
    shared = {field.name for field in ours.fields} & {field.name for field in theirs.fields}
    left, right = ([f.name for f in spec.fields if f.name in shared] for spec in (ours, theirs))
    if left != right:
        moved = [name for name, other in zip(left, right, strict=True) if name != other]
        lines.append(say("another order, from {name} on", name=moved[0]))
    here, there = ({c.name: f"{c.type} {c.value}" for c in spec.constants} for spec in (ours, theirs))
    for name in dict.fromkeys([*here, *there]):
        if here.get(name) != there.get(name):
            lines.append(_words(say("constant {name}", name=name), here.get(name, ""), there.get(name, "")))
    return lines


def _other_spellings(ours: MessageSpec, theirs: MessageSpec) -> dict[str, str]:
    """Our name -> the robot's name, for fields with two known names and the same type."""
    here, there = ({field.name: field.type for field in spec.fields} for spec in (ours, theirs))
    pairs = bundled().field_aliases(ours.name)
    return {
        name: other
        for pair in pairs
        for name, other in (pair, pair[::-1])
        if name in here and other in there and name not in there and here[name] == there[other]
    }


def _words(name: str, ours: str, theirs: str) -> str:
    if not theirs:
        return say("{name} ({ours}): not on the robot", name=name, ours=ours)
    text = "{name}: {ours} here, {theirs} on the robot" if ours else "{name} ({theirs}): only on the robot"
    return say(text, name=name, ours=ours, theirs=theirs)


# -- learned sets: folders of .msg files, each usable as `msg_path=` -----------------------------------------
#
# Contradicting definitions (two nodes of one robot with different revisions) go into different sets. A set is
# written to a temporary folder, read back for a check, and then renamed: an interrupted program leaves no
# partial set.

# File names that Windows does not allow, with any extension.
MAX_NAME_CHARACTERS = (
    251  # characters of a package or a type; with ".msg" 255, the limit of most file systems
)
_RESERVED = {"con", "prn", "aux", "nul", *(f"{port}{n}" for port in ("com", "lpt") for n in range(1, 10))}


class LearnedSet:
    """A set of definitions without contradictions.

    Attributes:
        texts: Type -> its own text, for learned types and the types they use.
        types: Learned type -> its md5sum.
    """

    def __init__(self) -> None:
        self.texts: dict[str, str] = {}
        self.types: dict[str, str] = {}
        self._sums: dict[str, str] = {}

    def take(self, name: str, library: DefinitionLibrary) -> bool:
        """Add a type and all types it uses; return False, without adding any, if one contradicts the set."""
        names = [name, *library.dependencies(name)]
        sums = {used: library.md5sum(used) for used in names}
        # Names that differ only in case are one file on Windows and macOS.
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
        """Eight hexadecimal digits of a hash of the definitions, to recognise an already learned set."""
        lines = "".join(f"{name} {self._sums[name]}\n" for name in sorted(self._sums))
        return hashlib.sha256(lines.encode()).hexdigest()[:8]


def why_not_kept(name: str, library: DefinitionLibrary) -> str:
    """Why a type, or one it uses, cannot be stored in files; "" if it can."""
    for used in [name, *library.dependencies(name)]:
        if problem := _unnameable(used):
            return problem if used == name else f"{name[:MAX_NAME_CHARACTERS]} uses {problem}"
    return ""


def _unnameable(name: str) -> str:
    """Why a type's name cannot be the name of a file and its folder; "" if it can."""
    package, _, base = name.partition("/")
    if {package.lower(), base.lower()} & _RESERVED:
        return f"{name}: a file cannot have this name on every system"
    if max(len(package), len(base)) > MAX_NAME_CHARACTERS:
        return f"{short(name)}: longer than the name of a file may be"
    return ""


def make_sets(learned: Iterable[tuple[str, DefinitionLibrary]]) -> list[LearnedSet]:
    """Distribute definitions, in order, to as few sets without contradictions as possible."""
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
    """Write one set below `folder`; return the folder of the set.

    Args:
        learned: The definitions.
        folder: The revisions folder; created if missing.
        origin: The robot's host, for the name of the set.

    Raises:
        DefinitionError: The written definitions differ when read back.
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
        work.chmod(0o755)  # mkdtemp allows only the owner; the definitions are not secret
        try:
            os.rename(work, place)
        except OSError:
            if not place.is_dir():  # another program has learned the same set
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
