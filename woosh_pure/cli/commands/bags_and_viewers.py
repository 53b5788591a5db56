"""`woosh record`, `woosh foxglove` and `woosh robot-api`."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rosproto.cli import (
    add_gateway_options,
    add_server_options,
    announced,
    gateway_options,
    interrupt_on_signals,
    server_options,
    serving,
    serving_line,
    shown_token,
    until_interrupted,
    watchdog_if,
)
from rosproto.logs import PeerLog
from woosh_pure.cli.connection import connect, graph_of, names
from woosh_pure.cli.output import Output
from woosh_pure.interface.recorded_topics import ALWAYS, selection_of
from woosh_pure.interface.table import driving_patterns, find
from woosh_pure.maps.marks import MarkFile, UserMark, mark_file
from woosh_pure.robot_api.wire import PORT

if TYPE_CHECKING:
    from rosproto.cli import ServerOptions
    from rosproto.gateway import GatewayServer
    from rosproto.recording import Recorder
    from rosproto.watchdog import Watchdog
    from woosh_pure.chassis import Chassis


def add_record(parser: ArgumentParser) -> None:
    from rosproto.cli import add_output_options

    parser.add_argument("topics", nargs="*", metavar="TOPIC", help="more topics, beside those of the chassis")
    parser.add_argument("--camera", action="store_true", help="also images and point clouds (much data)")
    parser.add_argument("--all", action="store_true", help="every topic of the graph")
    parser.add_argument(
        "-x", "--exclude", action="append", default=[], metavar="REGEX", help="leave these out"
    )
    add_output_options(parser)
    parser.add_argument("--uncompressed", action="store_const", const="none", dest="compression")
    parser.set_defaults(compression="lz4", output_prefix=None)


def run_record(args: Namespace, out: Output) -> int:
    from rosproto import Node
    from rosproto.cli import follow_recording, interrupt_on_signals, recorder_options
    from rosproto.recording import Recorder

    if not args.output_name and not args.output_prefix:
        args.output_prefix = "woosh"
    options = recorder_options(args)
    with ExitStack() as stack:
        stack.enter_context(interrupt_on_signals())
        uri, host = graph_of(args, out, stack)
        node = stack.enter_context(
            Node("woosh_record", master_uri=uri, host=host, anonymous=True, rosout=False, resolve=names(args))
        )
        selection = selection_of(args.topics, camera=args.camera, all=args.all, exclude=args.exclude)
        recorder = Recorder(node, selection=selection, **options)
        code = follow_recording(recorder, quiet=args.quiet or args.json, translate=out.say)
    return _tell_bags(recorder, out) or code


def _tell_bags(recorder: Recorder, out: Output) -> int:
    """Print the bags' contents; return 1 if one is damaged, or without pose or battery (no chassis)."""
    from rosproto.bag import open_bag

    counts: dict[str, int] = {}
    files: list[dict[str, object]] = []
    damage: list[str] = []
    for path in filter(Path.exists, recorder.paths):
        with open_bag(path) as bag:
            files.append({"path": str(path), "bytes": bag.size, "seconds": round(bag.duration, 3)})
            for topic, known in bag.topics.items():
                counts[topic] = counts.get(topic, 0) + known.message_count
            damage += [f"{path}: {problem}" for problem in bag.damage]
    for topic, count in sorted(counts.items()):
        out.line(f"  {topic:40s} {count:8d}")
    rows = [find(feed) for feed in ALWAYS]
    silent = [row.name for row in rows if not any(name in counts for name in (row.name, *row.aliases))]
    if silent:
        out.line("nothing was heard on {names}; try `woosh doctor`", names=silent)
    for problem in damage:
        out.line("damaged, messages may be missing: {problem}", problem=problem)
    out.result(
        {"files": files, "topics": counts, "dropped": recorder.dropped, "silent": silent, "damage": damage}
    )
    return 1 if silent or damage else 0


def add_foxglove(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--layout",
        type=Path,
        metavar="FILE",
        help="write a layout for the chassis there (import it in the viewer), and serve",
    )
    parser.add_argument("--layout-only", action="store_true", help="write the layout and end")
    parser.add_argument("--marks", type=Path, metavar="FILE", help="the list of marks that is drawn")
    add_server_options(parser)
    parser.add_argument(
        "--allow-driving",
        action="store_true",
        help="let viewers publish velocities and the goals that move the robot; keep the red button within "
        "reach",
    )


def run_foxglove(args: Namespace, out: Output) -> None:
    from rosproto.gateway import Foxglove
    from woosh_pure.foxglove import ChassisTopics, write_layout

    if args.layout_only and args.layout is None:
        raise ValueError("--layout-only needs --layout FILE")
    if args.layout is not None:
        out.line("layout: {path} (in the viewer: Layouts, Import from file)", path=write_layout(args.layout))
    if args.layout_only:
        out.result({"layout": str(args.layout)})
        return
    options = server_options(args, write=driving_patterns() if args.allow_driving else ())
    marks = _marks(args)
    with _chassis(args, out, options) as (chassis, watchdog):
        topics = ChassisTopics(chassis, marks, out.language)
        with (
            topics,
            serving(
                Foxglove, chassis.node, options, topics=topics.all, name="Woosh chassis", watchdog=watchdog
            ) as server,
        ):
            _serve(args, out, server, options, announced(server, options, shown_token(args, options)))


def add_robot_api(parser: ArgumentParser) -> None:
    add_gateway_options(parser, PORT)
    parser.add_argument("--marks", type=Path, metavar="FILE", help="the list of marks of its one scene")
    parser.add_argument(
        "--share",
        action="store_true",
        help="let a client drive while another client or program can: the robot obeys the last one",
    )


def run_robot_api(args: Namespace, out: Output) -> None:
    from woosh_pure.api_server import RobotApiServer, RobotSite

    options = gateway_options(args)
    with _chassis(args, out, options) as (chassis, watchdog):
        site = RobotSite("robot", "map", chassis.get_map, _marks(args))
        more = {"site": site, "lease": chassis.lease, "share": args.share, "watchdog": watchdog}
        with serving(RobotApiServer, chassis.node, options, **more) as server:
            line = serving_line("the Robot API", server, options, shown_token(args, options))
            _serve(args, out, server, options, [line])


def _marks(args: Namespace) -> Callable[[], Sequence[UserMark]]:
    """The list of marks, read again when it has changed; as it was while it cannot be read."""
    file, log = MarkFile(args.marks or mark_file()), PeerLog("woosh_pure.maps")

    def newest() -> Sequence[UserMark]:
        try:
            file.refresh()
        except (OSError, ValueError) as error:
            log.warning("marks", "! %s", error)
        return tuple(file)

    return newest


@contextmanager
def _chassis(
    args: Namespace, out: Output, options: ServerOptions
) -> Iterator[tuple[Chassis, Watchdog | None]]:
    """The chassis, and the watchdog process if clients may drive."""
    with ExitStack() as stack:
        stack.enter_context(interrupt_on_signals())
        drives = options["access"].writes_anything
        watchdog = stack.enter_context(watchdog_if(drives and not args.no_watchdog))
        yield stack.enter_context(connect(args, out)), watchdog


def _serve(
    args: Namespace, out: Output, server: GatewayServer, options: ServerOptions, lines: Sequence[str]
) -> None:
    """Print how to reach a server, and wait for the end."""
    token = shown_token(args, options)
    try:
        for line in lines:
            out.line(line)
        out.result({"url": server.url, "token": token, "write": list(options["access"].write)})
        until_interrupted(server.node, args.seconds)
    except KeyboardInterrupt:
        pass  # the normal end of this command
