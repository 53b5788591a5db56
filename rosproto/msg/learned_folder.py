"""`LearnedFolder`: the path of a folder with definitions learned from a robot, for `msg_path=`."""

from __future__ import annotations

import os
import sys

if sys.platform == "win32":  # pragma: no cover - one of the two, on each system
    from pathlib import WindowsPath as SystemPath
else:
    from pathlib import PosixPath as SystemPath


class LearnedFolder(SystemPath):
    """One set of learned definitions; the user's folders and bundled definitions take precedence.

    Only the object is marked: the same path as text is an ordinary folder of the user.
    """

    learned = True

    def __reduce__(self) -> tuple[type[LearnedFolder], tuple[str]]:
        return LearnedFolder, (os.fspath(self),)
