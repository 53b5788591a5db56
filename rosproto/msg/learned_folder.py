"""`LearnedFolder`: the path of a folder with definitions learned from a robot, for `msg_path=`."""

from __future__ import annotations

import os
import sys

if sys.platform == "win32":  # pragma: no cover - one of the two, on each system
    from pathlib import WindowsPath as SystemPath
else:
    from pathlib import PosixPath as SystemPath


class LearnedFolder(SystemPath):
    """One learned set. Its types count only where neither the user's folders nor the bundled ones have them.

    The mark is in the object: text of the same path is a folder that the user has named, like any other.
    """

    learned = True

    def __reduce__(self) -> tuple[type[LearnedFolder], tuple[str]]:
        return LearnedFolder, (os.fspath(self),)
