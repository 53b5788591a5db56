"""Generates genpy's classes from our definition texts; runs where genpy is (Debian's /usr/bin/python3).

The action messages and everything else are written as plain .msg and .srv files first, so that genpy sees
files only. The result is a folder to put in front of sys.path; it shadows Debian's own message packages.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path


def write_definitions(folder: Path) -> None:
    """Write all bundled definitions as <package>/msg/*.msg and <package>/srv/*.srv."""
    from rosproto.msg import bundled

    library = bundled()
    for package in library.packages():
        for kind, names in (("msg", library.messages(package)), ("srv", library.services(package))):
            target = folder / package / kind
            target.mkdir(parents=True, exist_ok=True)
            for name in names:
                spec = library.message(name) if kind == "msg" else library.service(name)
                path = target / f"{name.partition('/')[2]}.{kind}"
                path.write_text(spec.text, "utf-8", errors="surrogateescape")


def generate(definitions: Path, output: Path) -> None:
    """Run genpy's generators over such a folder."""
    from genpy.generate_initpy import write_modules
    from genpy.generator import MsgGenerator, SrvGenerator

    packages = sorted(os.listdir(definitions))
    search = {package: [str(definitions / package / "msg")] for package in packages}
    for package in packages:
        for kind, generator in (("msg", MsgGenerator()), ("srv", SrvGenerator())):
            files = sorted(str(path) for path in (definitions / package / kind).glob(f"*.{kind}"))
            target = output / package / kind
            target.mkdir(parents=True, exist_ok=True)
            (output / package / "__init__.py").touch()
            if files and generator.generate_messages(package, files, str(target), search):
                raise RuntimeError(f"genpy failed on {package}/{kind}")
            write_modules(str(target))


if __name__ == "__main__":
    generate(Path(sys.argv[1]), Path(sys.argv[2]))
