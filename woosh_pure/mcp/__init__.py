"""Tools for an assistant, by the Model Context Protocol: run `woosh mcp`, or serve it from your own program.

    with Chassis("169.254.128.2", watchdog=True) as chassis:
        woosh_pure.mcp.server(chassis, allow_motion=True).run()

Needs the extra `mcp`: pip install ".[mcp]".
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from rosproto.extras import optional_module
from rosproto.sentence import say
from woosh_pure.mcp.limits import Limits

if TYPE_CHECKING:
    from mcp.server import MCPServer

    from woosh_pure.chassis import Chassis
    from woosh_pure.mcp.motion import Confirming
    from woosh_pure.web.marks import NamedPlace
    from woosh_pure.web.robot import Robot

__all__ = ["Limits", "server"]


def server(
    chassis: Chassis | Mapping[str, Chassis],
    *,
    limits: Limits = Limits(),
    allow_motion: bool = False,
    confirm: Confirming = "always",
    marks: Iterable[NamedPlace] = (),
    recordings: str | Path | None = None,
) -> MCPServer:
    """Return an MCP server of one or more robots. It moves nothing without `allow_motion`.

    Open each Chassis with `watchdog=True`, run the server, and close the Chassis afterwards.

    Args:
        chassis: The robot, or several by name.
        limits: Where and how they may be moved.
        allow_motion: Whether there are tools that move them.
        confirm: Whether a person is asked before each motion: "always" (a client that cannot ask may not move
            anything), "when-possible" (where the client can ask), "never".
        marks: Marks beside those that the robot names itself, as of `woosh_pure.web.app`.
        recordings: Folder of bags, whose names are listed.

    Raises:
        ImportError: The extra `mcp` is not installed.
        ValueError: `confirm` is none of these.
    """
    require()
    from woosh_pure.mcp.motion import CONFIRM
    from woosh_pure.mcp.server import Door

    if confirm not in CONFIRM:
        raise ValueError(
            say("confirm={confirm!r}: expected one of {names}", confirm=confirm, names=[*CONFIRM])
        )
    made = robots(chassis if isinstance(chassis, Mapping) else {"robot": chassis}, marks, recordings)
    return Door(made, limits, allow_motion=allow_motion, confirm=confirm).mcp


def robots(
    chassis: Mapping[str, Chassis], marks: Iterable[NamedPlace] = (), recordings: str | Path | None = None
) -> dict[str, Robot]:
    """Return the robots of a server, by name, with what it keeps of each: journal, goals, map, marks."""
    from woosh_pure.web.marks import MarkList
    from woosh_pure.web.robot import Robot

    shared = MarkList(marks)
    folder = None if recordings is None else Path(recordings)
    return {name: Robot(name, one, marks=shared, recordings=folder) for name, one in chassis.items()}


def require() -> None:
    """Check that the extra is installed.

    Raises:
        ImportError: It is not; the message says what to install.
    """
    for name in ("mcp", "PIL"):
        missing = say('an assistant\'s tools need {name}: pip install ".[mcp]"', name=name)
        optional_module("mcp.server" if name == "mcp" else name, ImportError(missing, name=name))
