"""Debian's generators of message code, all of their work in one process; runs where they are: under /usr/bin/python3.

Their own scripts take one file, or one kind of one package, each: an interpreter's start would cost more than the
work. Takes the name of a function below and its arguments, paths; ROOTS are folders like msgdefs, of which the first
that has a package counts.
"""

from __future__ import annotations

import contextlib
import importlib.util
import io
import re
import runpy
import sys
from pathlib import Path

GENACTION = "/usr/lib/actionlib_msgs/genaction.py"
CPP_TEMPLATES = "/usr/share/gencpp"
SYSTEM_HEADERS = Path("/usr/include")
INCLUDE = re.compile(r"#include <(\w+)/(\w+)\.h>")


def folders_of(roots: list[Path], made: Path) -> dict[str, list[str]]:
    """package -> folders of its .msg files; those that belong to its actions are written below `made`."""
    found: dict[str, list[str]] = {}
    for home in sorted(path for root in roots for path in root.iterdir() if path.is_dir()):
        if home.name in found and (roots[0] / home.name) != home:
            continue
        target = made / home.name
        for action in sorted((home / "action").glob("*.action")):
            target.mkdir(parents=True, exist_ok=True)
            sys.argv = [GENACTION, str(action), "-o", str(target)]
            with contextlib.redirect_stdout(io.StringIO()):
                runpy.run_path(GENACTION, run_name="__main__")
        found[home.name] = [str(home / "msg"), str(target)]
    return found


def python(target: Path, *roots: Path) -> None:
    """Packages of the first root for rospy, by genpy.

    Those that Debian's Python has already are left out: one with messages only would hide the code of that name.
    """
    from genpy.generate_initpy import write_modules  # type: ignore[import-not-found]
    from genpy.generator import MsgGenerator, SrvGenerator  # type: ignore[import-not-found]

    search = folders_of(list(roots), target / "actions")
    for home in sorted(path for path in roots[0].iterdir() if path.is_dir()):
        if importlib.util.find_spec(home.name) is not None:
            continue
        messages = {p.name: p for folder in reversed(search[home.name]) for p in Path(folder).glob("*.msg")}
        services = {p.name: p for p in (home / "srv").glob("*.srv")}
        for kind, files, generator in (("msg", messages, MsgGenerator()), ("srv", services, SrvGenerator())):
            if files:
                out = target / home.name / kind
                out.mkdir(parents=True, exist_ok=True)
                names = [str(files[name]) for name in sorted(files)]
                if generator.generate_messages(home.name, names, str(out), search):
                    raise SystemExit(f"genpy failed on {home.name}")
                write_modules(str(out))
                (target / home.name / "__init__.py").touch()


def headers(target: Path, source: Path, *roots: Path) -> None:
    """Generate the headers that a C++ source includes, recursively, by gencpp; except those in /usr/include."""
    from genmsg.template_tools import generate_from_file  # type: ignore[import-not-found]

    search = folders_of(list(roots), target / "actions")
    include = [f"{package}:{folder}" for package, folders in search.items() for folder in folders]
    texts, seen = [source.read_text("utf-8")], set()
    while texts:
        for package, base in INCLUDE.findall(texts.pop()):
            header = target / package / f"{base}.h"
            if header in seen or package not in search or (SYSTEM_HEADERS / package).is_dir():
                continue
            seen.add(header)
            if (
                not header.exists()
            ):  # those of a service's request and response are written with the service's
                services = Path(search[package][0]).with_name("srv")
                files = [Path(folder) / f"{base}.msg" for folder in search[package]] + [
                    services / f"{base}.srv"
                ]
                file = next(file for file in files if file.exists())
                maps = ({f"{kind}.h.template": "@NAME@.h"} for kind in ("msg", "srv"))
                generate_from_file(str(file), package, str(header.parent), CPP_TEMPLATES, include, *maps)
            texts.append(header.read_text("utf-8"))


if __name__ == "__main__":
    _, what, *paths = sys.argv
    if what == "python":
        python(*map(Path, paths))
    else:
        headers(*map(Path, paths))
