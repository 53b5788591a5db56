"""What building a wheel adds: texts of many small files in one, and all of it compressed as well as can be.

The texts are the definitions of msgdefs (see rosproto/msg/packed.py) and the stand-ins for ROS's modules (see
rosproto/rospy/stock.py), these packed by bz2, which makes a long text an eighth smaller than zlib does. Where
the package `deflate` is installed, as for a release, its compressor saves 3 % more than zlib's best.
"""

from __future__ import annotations

import bz2
import contextlib
import os
import runpy
import tempfile
import zipfile
from pathlib import Path
from typing import Any
from unittest import mock

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
        shortened = runpy.run_path(str(Path(self.root, "rosproto", "rospy", "shortened.py")))["shortened"]
        packs = {
            f"msgdefs/{packed['PACK']}": packed["make_pack"](Path(self.root, "msgdefs")),
            "rosproto/rospy/modules.bz2": packed["make_pack"](Path(self.root, *MODULES), (".py",), shortened),
        }
        self._made = tempfile.TemporaryDirectory()
        for number, (place, text) in enumerate(packs.items()):
            file = Path(self._made.name, str(number))
            file.write_bytes(bz2.compress(text.encode()) if place.endswith(".bz2") else text.encode())
            build_data["force_include"][str(file)] = place

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """The temporary files have been read; the wheel is there."""
        if self._made is not None:
            self._made.cleanup()
            compress_again(Path(artifact_path))


def compress_again(wheel: Path) -> None:
    """The same files in the same order, smaller."""
    smaller = wheel.with_suffix(".smaller")
    with zipfile.ZipFile(wheel) as old, zipfile.ZipFile(smaller, "w") as new, compressor():
        for info in old.infolist():
            new.writestr(info, old.read(info), zipfile.ZIP_DEFLATED, 9)
    os.replace(smaller, wheel)


def compressor() -> Any:
    """Within it, zipfile compresses with `deflate`, where that is installed."""
    try:
        from deflate import deflate_compress
    except ImportError:
        return contextlib.nullcontext()

    class Whole:
        """A compressor that waits for all of a file."""

        def __init__(self, *_: object) -> None:
            self.data = bytearray()

        def compress(self, data: bytes) -> bytes:
            self.data += data
            return b""

        def flush(self) -> bytes:
            return bytes(deflate_compress(bytes(self.data), 12))

    return mock.patch.object(zipfile, "_get_compressor", Whole)
