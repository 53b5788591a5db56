"""Names of the graph as typed: make absolute, match, report unknown ones."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterable

from .console import warn
from .exit_codes import CommandError
from .parser import near


def absolute(name: str) -> str:
    """Return a typed name as absolute, below $ROS_NAMESPACE."""
    if name.startswith("/"):
        return name
    space = os.environ.get("ROS_NAMESPACE", "").strip("/")
    return f"/{space}/{name}" if space else f"/{name}"


def below(names: Iterable[str], asked: str) -> list[str]:
    """Return the names in a namespace, or that match a pattern (`/move_base/*`), sorted."""
    if asked in ("", "/"):
        return sorted(names)
    if any(sign in asked for sign in "*?["):
        import fnmatch

        return sorted(fnmatch.filter(names, absolute(asked)))
    space = absolute(asked).rstrip("/")
    return sorted(name for name in names if name == space or name.startswith(space + "/"))


def warn_if_none(found: Collection[object], what: str, asked: str, names: Iterable[str]) -> None:
    """Warn if a name was given and not found: it may be mistyped."""
    if asked and asked != "/" and not found:
        warn(f"no {what} is called {absolute(asked)} or lies below it{near(absolute(asked), names)}")


def unknown(what: str, name: str, names: Iterable[str], see: str) -> CommandError:
    """Return the error for an unknown name, with similar names and the command that lists them."""
    return CommandError(f"{what} {name!r}{near(name, names)}; see: rosproto {see}")
