"""Folders with definitions: given ones, $ROSPROTO_MSG_PATH, and definitions learned from robots.

The learned ones are in `revisions_folder()`, as `<set>/<package>/msg/*.msg`; each set is a folder for
`msg_path=`. The environment is read when a function is called, never at import.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from rosproto.errors import DefinitionError
from rosproto.msg.definition_files import folder_source
from rosproto.msg.library import DefinitionLibrary, bundled

if TYPE_CHECKING:
    from pathlib import Path


def revisions_folder(environment: Mapping[str, str] | None = None, platform: str = sys.platform) -> Path:
    """The folder of this user's revisions, which may not exist.

    %LOCALAPPDATA% on Windows, ~/Library/Application Support on macOS, $XDG_DATA_HOME (by default
    ~/.local/share) elsewhere; followed by "rosproto/revisions".

    Raises:
        FileNotFoundError: This user has no home folder: a container with an arbitrary user id, some services.
    """
    from pathlib import Path

    environment = os.environ if environment is None else environment
    if platform == "win32":
        given, name, below = environment.get("LOCALAPPDATA", ""), "USERPROFILE", "AppData/Local"
    elif platform == "darwin":
        given, name, below = "", "HOME", "Library/Application Support"
    else:
        given, name, below = environment.get("XDG_DATA_HOME", ""), "HOME", ".local/share"
        given = given if given.startswith("/") else ""  # the XDG specification says to ignore a relative one
    try:
        base = Path(given) if given else Path(environment.get(name) or Path.home()) / below
    except RuntimeError as error:
        raise FileNotFoundError(f"this user has no home folder; set {name} to one") from error
    return base / "rosproto" / "revisions"


def environment_paths(environment: Mapping[str, str] | None = None) -> list[str]:
    """Folders in $ROSPROTO_MSG_PATH, separated as in $PATH, for `msg_path=`."""
    given = (os.environ if environment is None else environment).get("ROSPROTO_MSG_PATH", "")
    return [path for path in given.split(os.pathsep) if path]


def learned_paths(folder: str | os.PathLike[str] | None = None) -> list[Path]:
    """The folders of all learned sets, for `msg_path=`; other entries are ignored.

    They are `LearnedFolder`s, which are searched last, independent of their position in `msg_path`.
    """
    from pathlib import Path  # imported here for a faster start

    from rosproto.msg.learned_folder import LearnedFolder

    try:
        root = revisions_folder() if folder is None else Path(folder)
        entries = sorted(entry for entry in root.iterdir() if entry.is_dir())
    except OSError:
        return []
    return [LearnedFolder(e) for e in entries if not e.name.startswith(".") and _is_set(e)]


def is_learned(path: str | os.PathLike[str]) -> bool:
    """Whether the path is from `learned_paths`."""
    return bool(getattr(path, "learned", False))


def own_and_learned(
    given: Iterable[str | os.PathLike[str]] = (), *, learned: bool = True
) -> list[str | os.PathLike[str]]:
    """The order for `msg_path=`: given paths, $ROSPROTO_MSG_PATH, learned definitions."""
    return [*given, *environment_paths(), *(learned_paths() if learned else ())]


def library_of(
    name: str, kind: str = "msg", given: Iterable[str | os.PathLike[str]] = (), *, learned: bool = True
) -> DefinitionLibrary | None:
    """The library in which a command looks up a type; None for the bundled definitions.

    The user's folders take precedence over bundled definitions, and these over learned ones.

    Raises:
        DefinitionError: A folder does not exist or contains no definition.
    """
    own = [*given, *environment_paths()]
    if any(DefinitionLibrary([path]).has(kind, name) for path in own):
        return bundled().fork(own)
    if not bundled().has(kind, name):
        for path in learned_paths() if learned else ():
            if DefinitionLibrary([path]).has(kind, name):
                return bundled().fork([path])
    return None


def _is_set(path: Path) -> bool:
    try:
        folder_source(path)
    except (DefinitionError, OSError):
        return False
    return True
