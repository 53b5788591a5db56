"""`woosh map show|save|set`."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosproto.errors import RosTimeout
from rosproto.files import write_file
from rosproto.sentence import say
from woosh_pure.cli.arguments import POSE, number, pose, seconds
from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import Output
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.gridmap import GridMap

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis

HELP = "save the map (PGM, YAML, and a PNG with robot, path and scan), or set another one"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True)
    verbs.add_parser("show", help="size and resolution of the current map")
    save = verbs.add_parser("save", help="write OUT.yaml and OUT.pgm for map_server, and OUT.png to look at")
    save.add_argument("out", type=Path, metavar="OUT", help="name of the files, without an ending")
    save.add_argument("--no-png", action="store_true", help="leave the picture out")
    save.add_argument("--listen", type=seconds, default=2.0, metavar="S", help="for pose, scan and path (2)")
    change = verbs.add_parser("set", help="replace the map of the chassis")
    change.add_argument("file", type=Path, metavar="YAML", help="map_server's YAML, with the image beside it")
    change.add_argument(
        "--pose",
        nargs=3,
        type=number,
        metavar=POSE,
        help="where the robot is in it: m, m and degrees (0 0 0)",
    )


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    return {"show": _show, "save": _save, "set": _set}[args.verb](args, out)


def _facts(grid: GridMap) -> dict[str, Any]:
    return {
        "width": grid.width,
        "height": grid.height,
        "resolution": round(grid.resolution, 6),
        "origin": grid.origin,
        "occupied": int((grid.cells > 50).sum()),
        "unknown": int((grid.cells < 0).sum()),
    }


def _say(grid: GridMap, out: Output) -> None:
    cells = "{width} x {height} cells of {metres:.3f} m, {across:.1f} m x {along:.1f} m, from {origin}"
    out.line(
        say(
            cells,
            width=grid.width,
            height=grid.height,
            metres=grid.resolution,
            across=grid.width * grid.resolution,
            along=grid.height * grid.resolution,
            origin=grid.origin,
        )
    )


def _get(chassis: Chassis, out: Output) -> GridMap:
    with out.working("fetching the map"):
        return chassis.get_map()


def _show(args: Namespace, out: Output) -> int:
    with connect(args, out) as chassis:
        grid = _get(chassis, out)
    _say(grid, out)
    out.result(_facts(grid))
    return 0


def _save(args: Namespace, out: Output) -> int:
    target = args.out.with_suffix("") if args.out.suffix in (".yaml", ".pgm", ".png") else args.out
    if not target.parent.is_dir():
        raise ValueError(say("{parent} is no directory; make it first", parent=target.parent))
    with connect(args, out) as chassis:
        for name in ("pose", "scan", "velocity", "plan", "tf_static"):
            chassis.feed(name).open()  # received while the map is fetched
        grid = _get(chassis, out)
        files = [*grid.save(target.parent / f"{target.name}.yaml")]
        if not args.no_png:
            files.append(target.parent / f"{target.name}.png")
            write_file(files[-1], _draw(chassis, grid, args.listen, out))
    _say(grid, out)
    for file in files:
        out.line(say("wrote {path}", path=file))
    out.result({**_facts(grid), "files": [str(file) for file in files]})
    return 0


def _draw(chassis: Chassis, grid: GridMap, listen: float, out: Output) -> bytes:
    from woosh_pure.cli.picture import chart_png
    from woosh_pure.readings import scan_in_map

    pose = scan = None
    path: Sequence[Pose2D] = ()
    try:
        with out.working("waiting for pose and scan"):
            pose = chassis.pose.wait(listen, new=False)
            scan = scan_in_map(chassis, chassis.scan.wait(listen, new=False), pose)
            path = _path(chassis, listen, out)
    except RosTimeout as error:
        out.line(say("not in the picture: {error}", error=error))
    return chart_png(grid, out, pose=pose, scan=scan, path=path)


def _path(chassis: Chassis, listen: float, out: Output) -> Sequence[Pose2D]:
    """Return the path of a moving robot, published now and then or once when planned; empty at rest."""
    from woosh_pure.readings import known_path

    if not chassis.measured_velocity.wait(listen, new=False).is_standing():
        try:
            chassis.feed("plan").wait(listen, new=False)
        except RosTimeout as error:
            out.line(say("the path is not in the picture, although the robot moves: {error}", error=error))
            return ()
    return known_path(chassis)


def _set(args: Namespace, out: Output) -> int:

    grid = GridMap.load(args.file)
    with connect(args, out) as chassis, out.working("sending the map"):
        chassis.set_map(grid, pose(args.pose) if args.pose else None)
    _say(grid, out)
    out.line("the chassis took it")
    out.result(_facts(grid))
    return 0
