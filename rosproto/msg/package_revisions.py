"""Older and differing definitions in a package's `revisions` folder, found by md5sum.

`<package>/revisions/revisions.txt` lists them:

    # label < label of the revision it changes; nothing after `<` means the package itself
    1.1.1 <
      NavigationMode: the goal has no nav_dir
    1.1.0 < 1.1.1
      StepControl: no angle

`<package>/revisions/<label>/{msg,srv,action}/` holds only the definitions that differ. A revision is a
complete library: these definitions replace those of the revision it changes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from rosproto.errors import DefinitionError
from rosproto.msg.definition_files import DefinitionSource, Folder

if TYPE_CHECKING:
    from rosproto.msg.library import DefinitionLibrary

TABLE = "revisions.txt"


class Revision(NamedTuple):
    """Another definition of a type.

    Attributes:
        name: The message or service.
        label: A version of the package, or "page" for the vendor's interface page.
        md5sum: Its md5sum.
        library: All definitions as of that revision; `library.message(name)` is this one.
        note: The difference and its source, for users.
    """

    name: str
    label: str
    md5sum: str
    library: DefinitionLibrary
    note: str


class Row(NamedTuple):
    """One revision in the table; `notes` by base name of the differing type."""

    label: str
    after: str
    notes: dict[str, str]

    def note_for(self, package: str, used: set[str]) -> str:
        """The notes on the types in `used`; notes on an action also apply to its messages."""
        return " ".join(
            f"{package}/{base}: {note}"
            for base, note in self.notes.items()
            if any(name.startswith(f"{package}/{base}") for name in used)
        )


def read_table(folder: Folder) -> list[Row]:
    """The revisions of a package, in the order of the table; empty when it has none."""
    if "revisions" not in folder.tree.names(*folder.parts):
        return []
    parts = (*folder.parts, "revisions", TABLE)
    if TABLE not in folder.tree.names(*parts[:-1]):
        return []
    file = folder.tree.describe(*parts)
    rows: dict[str, Row] = {"": Row("", "", {})}
    label = ""
    for number, line in enumerate(folder.tree.read(*parts).split("\n"), 1):
        words = line.partition("#")[0]
        if not words.strip():
            continue
        left, sign, right = (part.strip() for part in words.partition(":" if words[0].isspace() else "<"))
        if not sign or (words[0].isspace() and not label) or (not words[0].isspace() and right not in rows):
            raise DefinitionError(
                "expected `label < earlier label`, or below it an indented `Type: what differs`",
                file=file,
                line=number,
            )
        if words[0].isspace():
            rows[label].notes[left] = right
        else:
            label = left
            rows[label] = Row(label, right, {})
    del rows[""]
    return list(rows.values())


def revision_source(folder: Folder, package: str, label: str) -> DefinitionSource:
    """The definitions that differ in one revision."""
    place = Folder(folder.tree, *folder.parts, "revisions", label)
    return DefinitionSource(folder.tree.describe(*place.parts), {package: [place]})
