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

__all__ = ["Limits", "require", "robots", "server"]


def server(
    chassis: Chassis | Mapping[str, Chassis],
    *,
    limits: Limits | None = None,
    allow_motion: bool = False,
    confirm: Confirming = "always",
    marks: Iterable[NamedPlace] = (),
    recordings: str | Path | None = None,
) -> MCPServer:
    """Return an MCP server of one or more robots. Open each Chassis with `watchdog=True` before it runs.

    Args:
        chassis: The robot, or several by name.
        limits: Where and how they may be moved; None for 120 s as the only limit.
        allow_motion: Whether there are tools that move them.
        confirm: Whether a person is asked before each motion: "always" (a client that cannot ask may not move
            anything), "when-possible" (where the client can ask), "never".
        marks: Marks beside those that the robot names itself.
        recordings: Folder of bags, whose names and sizes are listed.

    Raises:
        ImportError: The extra `mcp` is not installed.
        ValueError: `confirm` is none of these.
    """
    require()
    from woosh_pure.mcp.door import Door

    if confirm not in ("always", "when-possible", "never"):
        raise ValueError(say("confirm={confirm!r}: expected always, when-possible or never", confirm=confirm))
    named = chassis if isinstance(chassis, Mapping) else {"robot": chassis}
    made = robots(named, marks, recordings)
    return Door(made, limits or Limits(), allow_motion=allow_motion, confirm=confirm).mcp


def robots(
    chassis: Mapping[str, Chassis], marks: Iterable[NamedPlace] = (), recordings: str | Path | None = None
) -> dict[str, Robot]:
    """Return the robots of a server with what it keeps of each: journal, goals, map, marks."""
    from woosh_pure.web.marks import MarkList
    from woosh_pure.web.robot import Robot

    shared, folder = MarkList(marks), None if recordings is None else Path(recordings)
    return {name: Robot(name, one, marks=shared, recordings=folder) for name, one in chassis.items()}


def require() -> None:
    """Check that the extra is installed.

    Raises:
        ImportError: It is not; the message says what to install.
    """
    for module in ("mcp.server", "PIL"):
        name = module.partition(".")[0]
        missing = say('an assistant\'s tools need {name}: pip install ".[mcp]"', name=name)
        optional_module(module, ImportError(missing, name=name))
