"""The saved default robot (`woosh connect`), and the folder of the user's files on each OS.

Which master, one rule for `woosh`, `rosproto` and `Chassis()`: the argument or option, else $ROS_MASTER_URI,
else the saved one.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import NamedTuple

from rosproto.files import read_text, save_file
from rosproto.sentence import say

__all__ = ["Profile", "directory", "forget", "load", "profile_file", "remembered", "save"]


class Profile(NamedTuple):
    """The default chassis.

    Attributes:
        chassis: Host or master URI.
        host: Our own address for the robot; None detects it.
    """

    chassis: str
    host: str | None = None


def directory() -> Path:
    """Return the folder: %APPDATA%\\woosh, ~/Library/Application Support/woosh, $XDG_CONFIG_HOME/woosh.

    $WOOSH_CONFIG_DIR overrides it.

    Raises:
        FileNotFoundError: This user has no home folder.
    """
    given = os.environ.get("WOOSH_CONFIG_DIR")
    if given:
        return Path(given)
    if sys.platform == "win32":
        base = Path(os.environ.get("APPDATA") or _home() / "AppData" / "Roaming")
    elif sys.platform == "darwin":
        base = _home() / "Library" / "Application Support"
    else:
        base = Path(os.environ.get("XDG_CONFIG_HOME") or _home() / ".config")
    return base / "woosh"


def _home() -> Path:
    try:
        return Path.home()
    except RuntimeError as error:  # a container with an arbitrary user id, some services
        raise FileNotFoundError("this user has no home folder; set WOOSH_CONFIG_DIR to a folder") from error


def profile_file() -> Path:
    """Return the file of the default chassis."""
    return directory() / "profile.json"


def load() -> Profile | None:
    """Return the saved chassis, or None.

    Raises:
        ValueError: The file is invalid.
    """
    try:
        path = profile_file()
        text = read_text(path)
    except FileNotFoundError:
        return None
    try:
        fields = json.loads(text)
        return Profile(str(fields["chassis"]), fields.get("host"))
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        wrong = "{path}: not a profile ({error}); write it again with `woosh connect HOST`"
        raise ValueError(say(wrong, path=path, error=error)) from error


def remembered() -> Profile | None:
    """Return the saved chassis; None without one, and where $ROS_MASTER_URI goes before it.

    Raises:
        ValueError: The file is invalid.
    """
    return None if os.environ.get("ROS_MASTER_URI", "").strip() else load()


def save(profile: Profile) -> Path:
    """Write the file; an interrupted write leaves the old one."""
    path = profile_file()
    save_file(path, (json.dumps(profile._asdict(), indent=2) + "\n").encode())
    return path


def forget() -> bool:
    """Remove the file; return False if there was none."""
    try:
        profile_file().unlink()
    except FileNotFoundError:
        return False
    return True
