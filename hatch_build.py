"""What building a wheel adds: texts of many small files in one.

They are the definitions of msgdefs (see rosproto/msg/packed.py) and the stand-ins for ROS's modules (see
rosproto/rospy/stock.py).
"""

from __future__ import annotations

import runpy
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

MODULES = ("rosproto", "rospy", "modules")


class PackTexts(BuildHookInterface):
    """Hatch finds it by `[tool.hatch.build.targets.wheel.hooks.custom]`."""

    PLUGIN_NAME = "custom"
    _made: tempfile.TemporaryDirectory[str] | None = None

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Put the packs in; an editable wheel points to the source tree, which has the files."""
        if version == "editable":
            return
        # By its path: what is built need not be importable where it is built.
        packed = runpy.run_path(str(Path(self.root, "rosproto", "msg", "packed.py")))
        packs = {
            f"msgdefs/{packed['PACK']}": packed["make_pack"](Path(self.root, "msgdefs")),
            "rosproto/rospy/modules.txt": packed["make_pack"](Path(self.root, *MODULES), (".py",)),
        }
        self._made = tempfile.TemporaryDirectory()
        for number, (place, text) in enumerate(packs.items()):
            file = Path(self._made.name, f"{number}.txt")
            file.write_bytes(text.encode())
            build_data["force_include"][str(file)] = place

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """The temporary files have been read."""
        if self._made is not None:
            self._made.cleanup()
