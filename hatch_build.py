"""What building a wheel adds: the definition texts of msgdefs in one file (see rosproto/msg/packed.py)."""

from __future__ import annotations

import os
import runpy
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class PackDefinitions(BuildHookInterface):
    """Hatch finds it by `[tool.hatch.build.targets.wheel.hooks.custom]`."""

    PLUGIN_NAME = "custom"
    _made = ""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Put the pack in; an editable wheel points to the source tree, which has the files."""
        if version == "editable":
            return
        # By its path: what is built need not be importable where it is built.
        packed = runpy.run_path(str(Path(self.root, "rosproto", "msg", "packed.py")))
        handle, self._made = tempfile.mkstemp(suffix=".txt")
        with open(handle, "w", encoding="utf-8", newline="\n") as file:
            file.write(packed["make_pack"](Path(self.root, "msgdefs")))
        build_data["force_include"][self._made] = f"msgdefs/{packed['PACK']}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """The temporary file has been read."""
        if self._made:
            os.unlink(self._made)
