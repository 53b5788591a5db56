"""Arguments that several commands share, and their types."""

from __future__ import annotations

import argparse
import math
from argparse import ArgumentParser
from collections.abc import Iterable, Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from rosproto.cli import counted, folder_exists, heading, metres, positive, to_float
from rosproto.files import write_file
from rosproto.sentence import Sentence, say
from woosh_pure.cli.output import Output
from woosh_pure.geometry import Pose2D, normalize_angle
from woosh_pure.maps.marks import UserMark, own_marks, reported_marks, with_marks, with_robot_marks

if TYPE_CHECKING:
    from woosh_pure.feed.feed import Feed
    from woosh_pure.mcp import Limits

T = TypeVar("T")
POSE = ("X", "Y", "DEGREES")


class EachChassis(argparse.Action):
    """--chassis HOST or NAME=HOST: the last one is the chassis; some commands use all.

    Those before and after the command are collected separately: argparse uses two namespaces.
    """

    def __init__(self, *args: Any, gathered_in: str, **more: Any) -> None:
        super().__init__(*args, **more)
        self._gathered_in = gathered_in

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> None:
        """See argparse."""
        name, address = named_host(str(values))
        setattr(namespace, self.dest, address)
        before = getattr(namespace, self._gathered_in, [])
        setattr(namespace, self._gathered_in, [*before, (name, address)])


def named_host(text: str) -> tuple[str, str]:
    """Split NAME=HOST; HOST alone has the name ""."""
    name, equals, address = text.partition("=")
    return (name.strip(), address) if equals and not set(name) & set(":/[") else ("", text)


def each_chassis(args: argparse.Namespace) -> list[tuple[str, str]]:
    """Return name ("" if none) and address of each --chassis, in order."""
    return [*getattr(args, "chassis_before", ()), *getattr(args, "chassis_after", ())]


def pose(values: Sequence[float]) -> Pose2D:
    """Return a pose in the map from X (m), Y (m) and yaw (degrees)."""
    x, y, yaw = values
    return Pose2D(x, y, normalize_angle(math.radians(yaw)))


def pose_of(texts: Sequence[str]) -> Pose2D:
    """Parse X, Y and DEGREES of an option, each with a unit or without.

    Raises:
        NotANumber: One is not a number of that unit.
    """
    x, y, yaw = texts
    return pose((metres(x), metres(y), heading(yaw)))


def corners(text: str) -> list[tuple[float, float]]:
    """Parse the corners of an outline, "X,Y X,Y ...", in m."""
    return [_corner(each) for each in text.split()]


def _corner(text: str) -> tuple[float, float]:
    try:
        x, y = (to_float(part.strip()) for part in text.split(","))
    except ValueError:
        raise ValueError(say("corner {text!r}: expected X,Y in metres, e.g. 0.4,0.3", text=text)) from None
    return x, y


def png_file(text: str) -> Path:
    """Parse the path of a new picture: in an existing folder, with the ending .png or none."""
    path = folder_exists(text)
    if path.suffix.lower() not in ("", ".png"):
        raise argparse.ArgumentTypeError(
            say("{file}: pictures are written as PNG; give a name that ends in .png", file=text)
        )
    return path


def simulated_marks(args: argparse.Namespace) -> dict[str, UserMark]:
    """Return the marks of --sim's hall, or of the simulator at the address, by name; none of a real robot."""
    if args.sim:
        from woosh_pure.sim.site import built_in_site

        started = getattr(args, "simulator", None)
        return (started.world.site if started else built_in_site()).user_marks()
    from rosproto import MasterClient
    from rosproto.errors import RosError
    from rosproto.transport import HostNames
    from woosh_pure.cli.connection import chosen, names
    from woosh_pure.connection.arguments import master_uri_of

    try:
        uri, hosts = master_uri_of(chosen(args)[0]), HostNames(names(args))
        if uri.startswith("ws://"):
            return {}  # a real robot's are those of `robot_marks`
        with MasterClient(uri, "/woosh_marks", timeout=1.0, hosts=hosts) as master:
            return reported_marks(master.get_param)
    except (RosError, ValueError):  # no address, or nobody there: the caller finds out
        return {}


def robot_marks(
    args: argparse.Namespace, out: Output | None = None, *, timeout: float = 10.0
) -> list[UserMark]:
    """Return the marks that a real robot names by its Robot API; none of a robot without it.

    Args:
        args: The command line.
        out: Says why they are not known, if the robot has a Robot API; None says nothing.
        timeout: Seconds.
    """
    from rosproto.errors import RosError
    from woosh_pure.cli.connection import chosen, names, robot_api_of
    from woosh_pure.connection.arguments import master_uri_of
    from woosh_pure.errors import ApiRefused
    from woosh_pure.robot_api.api import robot_api_at

    if (given := robot_api_of(args)) is False:
        return []
    try:
        api = robot_api_at(given, master_uri_of(chosen(args)[0]), names(args))
        with closing(api):
            found, here = api.marks(timeout=timeout), api.scene().current_map
            return [mark.as_user_mark() for mark in found if here in ("", mark.map)]
    except (RosError, ValueError) as error:
        if out is not None and (given or isinstance(error, ApiRefused)):
            out.line("the robot's own marks are not known: {error}", error=error)
        return []


def marks_here(args: argparse.Namespace, robot: Iterable[UserMark] = ()) -> dict[str, UserMark]:
    """Return the known marks by name: those of a simulator and, except with --sim, those of the user's list.

    Args:
        args: The command line.
        robot: Those that the robot names.

    Raises:
        OSError, ValueError: The user's list cannot be read.
    """
    own = {} if args.sim else own_marks()
    return {**simulated_marks(args), **{mark.name: mark for mark in with_robot_marks(own.values(), robot)}}


def mark_missing(args: argparse.Namespace, wanted: str, given: str = "") -> Sentence:
    """Return the error of a missing mark: the expected arguments, and the known marks, near ones first."""
    return with_marks(wanted, marks_here(args, robot_marks(args)), given)


def add_mark_options(parser: ArgumentParser) -> None:
    """Add --mark and --marks, for commands that start a simulated chassis."""
    parser.add_argument(
        "--mark",
        action="append",
        default=[],
        metavar="NAME=X,Y,YAW",
        help="a mark in the simulated hall: m, m, degrees (repeat for more); one of that name is moved there",
    )
    parser.add_argument(
        "--marks",
        action="append",
        type=Path,
        default=[],
        metavar="FILE",
        help="marks in the simulated hall, from a list as `woosh marks` keeps it",
    )


def add_watchdog(parser: ArgumentParser) -> None:
    """Add --no-watchdog, for commands that drive for long."""
    parser.add_argument(
        "--no-watchdog",
        action="store_true",
        help="do not start the watchdog process, which stops the robot if this one is killed",
    )


def add_wait(parser: ArgumentParser) -> None:
    """Add --wait, for commands that need a message of the chassis."""
    parser.add_argument(
        "--wait",
        type=positive,
        default=5.0,
        metavar="S",
        help="seconds to wait for the chassis to report it (5)",
    )


def add_timeout(parser: ArgumentParser) -> None:
    """Add --timeout, for commands that start a motion."""
    parser.add_argument(
        "--timeout", type=positive, default=300.0, metavar="S", help="then it is cancelled (300)"
    )


def wait_for(feed: Feed[T], args: argparse.Namespace, out: Output) -> T:
    """Wait for the first value of a feed, and show that the command waits."""
    with out.working(say("waiting for {topic}", topic=feed.topic)):
        return feed.wait(args.wait, new=False)


def enum_words(members: object) -> list[str]:
    """Return the names of an enum as words: STOP_AND_WAIT becomes stop-and-wait."""
    return [m.name.lower().replace("_", "-") for m in members]  # type: ignore[attr-defined]


def word_of(name: str) -> str:
    """Return the enum name of a word: stop-and-wait becomes STOP_AND_WAIT."""
    return name.upper().replace("-", "_")


def write(path: Path, data: bytes, out: Output) -> str:
    """Write a file, report it, and return its name."""
    write_file(path, data)
    out.line("wrote {path} ({size})", path=path, size=counted(len(data), "byte", "bytes"))
    return str(path)


def add_limits(parser: ArgumentParser, prefix: str = "") -> None:
    """Add the options of what an assistant may do; with a prefix for a command that does more."""

    def add(name: str, **more: Any) -> None:
        parser.add_argument(f"--{prefix}{name}", dest=f"mcp_{name.replace('-', '_')}", **more)

    add("allow-motion", action="store_true", help="let an assistant move the robot; a person must watch")
    add("only-marks", action="store_true", help="it may drive to known marks only")
    add(
        "area",
        type=Path,
        metavar="FILE",
        help="it may drive inside a polygon only: a line X,Y for each corner",
    )
    add("max-distance", type=positive, metavar="M", help="at most so far from where a motion begins")
    add("max-speed", type=positive, metavar="V", help="m/s; a faster motion is ended")
    add("max-seconds", type=positive, default=120.0, metavar="S", help="a longer motion is ended (120)")
    asks = "whether a person is asked before each motion (always: a client that cannot ask may not move)"
    add("confirm", choices=("always", "when-possible", "never"), default="always", help=asks)


def limits_of(args: argparse.Namespace) -> Limits:
    """The limits of the options."""
    from woosh_pure.mcp import Limits
    from woosh_pure.mcp.limits import area_of

    try:
        area = area_of(args.mcp_area.read_text("utf-8")) if args.mcp_area else ()
    except ValueError as error:
        raise ValueError(say("{file}: {error}", file=args.mcp_area, error=error)) from error
    return Limits(args.mcp_only_marks, area, args.mcp_max_distance, args.mcp_max_speed, args.mcp_max_seconds)
