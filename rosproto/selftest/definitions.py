"""The bundled definitions: each is there, can be read, and has the md5sum that ROS's genmsg computes for it.

`md5sums.txt` has a line for each package and kind, and in it each type with the first eight digits, which are
enough to find what was changed by accident. tests/interop/test_genmsg.py compares it with genmsg's own.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib import resources

from rosproto.errors import DefinitionError
from rosproto.selftest.checking import CheckFailed


def known_md5sums() -> Iterator[tuple[str, str, str]]:
    """(first digits of the md5sum, kind, name) of every message and service; kind is "msg" or "srv"."""
    table = resources.files(__package__).joinpath("md5sums.txt").read_text(encoding="ascii")
    for line in table.splitlines():
        package, kind, *types = line.split()
        for name, _, digits in (entry.partition("=") for entry in types):
            yield digits, kind, f"{package}/{name}"


def check_definitions() -> str:
    """Each type of the table; and that none is bundled which the table does not know."""
    from rosproto.msg import bundled

    library = bundled()
    known = {(kind, name) for _, kind, name in known_md5sums()}
    there = {("msg", name) for package in library.packages() for name in library.messages(package)}
    there |= {("srv", name) for package in library.packages() for name in library.services(package)}
    wrong = [f"{name} is not known to this check" for _, name in sorted(there - known)]
    for digits, kind, name in known_md5sums():
        try:
            found = library.md5sum(name, kind=kind)
        except DefinitionError as error:
            wrong.append(str(error))
            continue
        if found[:8] != digits:
            wrong.append(f"{name} has md5sum {found}, expected {digits}...")
    if wrong:
        raise CheckFailed(f"{len(wrong)} of {len(known)} definitions are wrong; {wrong[0]}")
    return f"{len(known)} types have the md5sums of genmsg"
