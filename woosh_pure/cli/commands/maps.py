"""`woosh map`, and `woosh marks`: the user's own list of marks, and the robot's."""

from __future__ import annotations

from argparse import SUPPRESS, ArgumentParser, Namespace
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rosproto.cli import seconds
from rosproto.errors import RosError, RosTimeout
from rosproto.files import write_file
from rosproto.sentence import say
from rosproto.text import padded, width
from woosh_pure.cli.arguments import POSE, add_wait, marks_here, pose_of, robot_marks, wait_for
from woosh_pure.cli.connection import connect
from woosh_pure.cli.output import Output
from woosh_pure.errors import ChassisError
from woosh_pure.geometry import Pose2D
from woosh_pure.maps.gridmap import GridMap
from woosh_pure.maps.marks import MarkFile, UserMark, mark_file
from woosh_pure.reasons import ReasonKey

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis


def add_map(parser: ArgumentParser) -> None:
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
        metavar=POSE,
        help="where the robot is in it: m, m and degrees (0 0 0)",
    )


def run_map(args: Namespace, out: Output) -> None:
    {"show": _show_map, "save": _save_map, "set": _set_map}[args.verb](args, out)


def _map_facts(grid: GridMap) -> dict[str, object]:
    return {
        "width": grid.width,
        "height": grid.height,
        "resolution": round(grid.resolution, 6),
        "origin": grid.origin,
        "occupied": int((grid.cells > 50).sum()),
        "unknown": int((grid.cells < 0).sum()),
    }


def _say_size(grid: GridMap, out: Output) -> None:
    cells = "{width} x {height} cells of {metres:.3f} m, {across:.1f} m x {along:.1f} m, from {origin}"
    out.line(
        cells,
        width=grid.width,
        height=grid.height,
        metres=grid.resolution,
        across=grid.width * grid.resolution,
        along=grid.height * grid.resolution,
        origin=grid.origin,
    )


def _get_map(chassis: Chassis, out: Output) -> GridMap:
    with out.working("fetching the map"):
        return chassis.get_map()


def _show_map(args: Namespace, out: Output) -> None:
    with connect(args, out) as chassis:
        grid = _get_map(chassis, out)
    _say_size(grid, out)
    out.result(_map_facts(grid))


def _save_map(args: Namespace, out: Output) -> None:
    if not args.out.parent.is_dir():
        raise ValueError(say("{parent} is not a directory; create it first", parent=args.out.parent))
    with connect(args, out) as chassis:
        for name in ("pose", "scan", "velocity", "plan", "tf_static"):
            chassis.feed(name).open()  # received while the map is fetched
        grid = _get_map(chassis, out)
        files = [*grid.save(args.out)]
        if not args.no_png:
            files.append(files[0].with_suffix(".png"))
            write_file(files[-1], _draw_map(chassis, grid, args.listen, out))
    _say_size(grid, out)
    for file in files:
        out.line("wrote {path}", path=file)
    out.result({**_map_facts(grid), "files": [str(file) for file in files]})


def _draw_map(chassis: Chassis, grid: GridMap, listen: float, out: Output) -> bytes:
    from woosh_pure.maps.picture import chart_png
    from woosh_pure.readings import scan_in_map

    pose = scan = None
    path: Sequence[Pose2D] = ()
    try:
        with out.working("waiting for pose and scan"):
            pose = chassis.pose.wait(listen, new=False)
            scan = scan_in_map(chassis, chassis.scan.wait(listen, new=False), pose)
            path = _path(chassis, listen, out)
    except RosTimeout as error:
        out.line("not in the picture: {error}", error=error)
    return chart_png(grid, out, pose=pose, scan=scan, path=path)


def _path(chassis: Chassis, listen: float, out: Output) -> Sequence[Pose2D]:
    """Return the path of a moving robot, published now and then or once when planned; empty at rest."""
    from woosh_pure.readings import known_path

    if not chassis.measured_velocity.wait(listen, new=False).is_standing():
        try:
            chassis.feed("plan").wait(listen, new=False)
        except RosTimeout as error:
            out.line("the path is not in the picture, although the robot moves: {error}", error=error)
            return ()
    return known_path(chassis)


def _set_map(args: Namespace, out: Output) -> None:
    grid = GridMap.load(args.file)
    with connect(args, out) as chassis, out.working("sending the map"):
        chassis.set_map(grid, pose_of(args.pose) if args.pose else None)
    _say_size(grid, out)
    out.line("the chassis accepted it")
    out.result(_map_facts(grid))


def add_marks(parser: ArgumentParser) -> None:
    parser.add_argument("--file", type=Path, help="the list (default: beside the saved chassis)")
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True)
    verbs.add_parser("list", help="show the list, and the marks that the robot names")
    add = verbs.add_parser("add", help="add or replace a mark")
    add.add_argument("name", help="of a place, or of a mark on the chassis's map (--on-chassis)")
    place = add.add_mutually_exclusive_group()
    place.add_argument("--pose", nargs=3, metavar=POSE, help="m, m and degrees in the map")
    place.add_argument("--here", action="store_true", help="where the robot is now (the default)")
    place.add_argument(
        "--no-pose", action="store_true", help="only the name of a mark on the chassis's map; asks no robot"
    )
    owner = add.add_mutually_exclusive_group()
    owner.add_argument(
        "--on-chassis",
        action="store_true",
        help="the chassis's map has this mark: `goto` asks for it by name (else `goto` drives to the pose)",
    )
    owner.add_argument("--place", action="store_true", help=SUPPRESS)  # the default; for older scripts
    add.add_argument("--note", default="", help="anything")
    add_wait(add)
    remove = verbs.add_parser("remove", help="remove a mark from the list")
    remove.add_argument("mark", help="its name")


def run_marks(args: Namespace, out: Output) -> None:
    if args.sim and args.file is None and args.verb != "list":
        raise ValueError(
            "--sim ends with this command, and your list is for real robots; give another one: --file FILE"
        )
    marks = MarkFile(args.file or mark_file())
    if args.verb == "add":
        before = {mark.name: mark for mark in marks}.get(args.name)
        on_chassis = args.on_chassis or (args.no_pose and not args.place)
        where = pose_of(args.pose) if args.pose else None if args.no_pose else _here(args, out)
        mark = marks.put(args.name, where, args.note, on_chassis=on_chassis)
        marks.save()
        out.line(
            "{name}: {pose} (in {path})", name=mark.name, pose=mark.pose or say("no pose"), path=marks.path
        )
        if before is not None and before.pose not in (None, where):
            out.line("it was {pose} before", pose=before.pose)
        if before is not None and before.on_chassis and not on_chassis:
            out.line(
                "`woosh goto {name}` drives to this pose now; for the chassis's mark give --on-chassis",
                name=mark.name,
            )
    elif args.verb == "remove":
        marks.remove(args.mark)
        marks.save()
        out.line("removed {name}", name=args.mark)
    known: Iterable[UserMark] = marks
    if args.verb == "list" and args.file is None:
        known = marks_here(args, robot_marks(args, out)).values()
    listed = sorted(known, key=lambda m: m.name)
    if args.verb == "list":
        _print_marks(listed, out)
        if not listed:
            out.line("no marks in {path}; add one with `woosh marks add NAME`", path=marks.path)
    out.result(listed)


def _print_marks(listed: Sequence[UserMark], out: Output) -> None:
    column = max((width(mark.name) for mark in listed), default=0)
    for mark in listed:
        name = padded(mark.name, max(12, column))
        note = f"{mark.note}  (robot)".strip() if mark.source == "robot" else mark.note
        shown = "{name} {pose}  {note}" if note else "{name} {pose}"
        out.line(shown, name=name, pose=mark.pose or say("no pose"), note=note)


def _here(args: Namespace, out: Output) -> Pose2D:
    """Return the robot's pose, if it is localized."""
    try:
        with connect(args, out) as chassis:
            chassis.readiness()  # subscribes
            where = wait_for(chassis.pose, args, out)
            lost = [r for r in chassis.readiness().reasons if r.key is ReasonKey.NOT_LOCALISED]
    except (RosError, ValueError):
        out.line("`--pose X Y DEGREES` or `--no-pose` keeps a mark without asking the robot")
        raise
    if lost:
        raise ChassisError(lost[0].text)
    return where
