"""The sources of message definitions: the folders of `--msg-path`, then the bundled ones."""

from __future__ import annotations

import os
from functools import cache

from rosproto.msg import DefinitionLibrary, bundled

MSG_PATH = "ROSPROTO_MSG_PATH"
"""Environment: folders with definitions, joined as PATH is; children of a program find them there."""


@cache
def library() -> DefinitionLibrary:
    """The definitions of this process. The environment is read on the first call."""
    folders = [folder for folder in os.environ.get(MSG_PATH, "").split(os.pathsep) if folder]
    return bundled().fork(folders) if folders else bundled()
