"""Check the bundled definitions: each exists, can be parsed, and has the md5sum that ROS's genmsg computes.

`md5sums.txt` has a line for each package and kind, and in it each type with the first eight digits, which are
enough to find an accidental change. tests/interop/test_genmsg.py compares it with genmsg itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib import resources

from rosproto.errors import DefinitionError
from rosproto.selftest.checking import CheckFailed
from rosproto.sentence import say


def known_md5sums() -> Iterator[tuple[str, str, str]]:
    """Yield (first digits of the md5sum, kind, name) of every message and service; kind is "msg" or "srv"."""
    table = resources.files(__package__).joinpath("md5sums.txt").read_text(encoding="ascii")
    for line in table.splitlines():
        package, kind, *types = line.split()
        for name, _, digits in (entry.partition("=") for entry in types):
            yield digits, kind, f"{package}/{name}"


def check_definitions() -> str:
    """Check each type of the table, and that no other types are bundled."""
    from rosproto.msg import bundled

    library = bundled()
    known = {(kind, name) for _, kind, name in known_md5sums()}
    there = {("msg", name) for package in library.packages() for name in library.messages(package)}
    there |= {("srv", name) for package in library.packages() for name in library.services(package)}
    wrong: list[str] = [
        say("{name} is not known to this check", name=name) for _, name in sorted(there - known)
    ]
    for digits, kind, name in known_md5sums():
        try:
            found = library.md5sum(name, kind=kind)
        except DefinitionError as error:
            wrong.append(str(error))
            continue
        if found[:8] != digits:
            has = "{name} has md5sum {found}, expected {wanted}"
            wrong.append(say(has, name=name, found=found, wanted=f"{digits}..."))
    if wrong:
        raise CheckFailed(
            say(
                "{wrong} of {count} definitions are wrong; {first}",
                wrong=len(wrong),
                count=len(known),
                first=wrong[0],
            )
        )
    return say("{count} types have the md5sums of genmsg", count=len(known))
