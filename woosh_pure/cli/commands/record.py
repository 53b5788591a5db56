"""`woosh record`: what the chassis says, into a bag; moves nothing."""

from __future__ import annotations

import re
from argparse import ArgumentParser, Namespace
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from woosh_pure.cli.connection import chosen, names, simulated
from woosh_pure.cli.output import Output

if TYPE_CHECKING:
    from rosproto.recording import Recorder, TopicSelection

HELP = "record what the chassis says and is told into a bag, until interrupted; moves nothing"

ALWAYS = ("pose", "battery")
"""Feeds that are in every recording: without them nobody can tell later where and how the robot was."""
BEYOND_TABLE = ("/tf", "/tf_static", "/diagnostics", "/rosout", "/map", "/map_metadata")
GOALS = r"/[^/]+(?:/[^/]+)*/(?:goal|cancel|status|feedback|result)"
"""The topics of actions, the chassis's own and others."""
HEAVY = frozenset({"sensor_msgs/Image", "sensor_msgs/CompressedImage", "sensor_msgs/PointCloud2"})


def add_arguments(parser: ArgumentParser) -> None:
    """See `registry`."""
    from rosproto.cli import add_output_options

    parser.add_argument("topics", nargs="*", metavar="TOPIC", help="more topics, beside those of the chassis")
    parser.add_argument("--camera", action="store_true", help="also images and point clouds (much data)")
    parser.add_argument("--all", action="store_true", help="every topic of the graph")
    parser.add_argument("-x", "--exclude", action="append", default=[], metavar="REGEX", help="not these")
    add_output_options(parser)
    parser.add_argument("--uncompressed", action="store_const", const="none", dest="compression")
    parser.set_defaults(compression="lz4", output_prefix=None)


def run(args: Namespace, out: Output) -> int:
    """See `registry`."""
    from rosproto import Node
    from rosproto.cli import follow_recording, interrupt_on_signals, recorder_options
    from rosproto.recording import Recorder
    from woosh_pure.connection.address import master_uri_of

    if not args.output_name and not args.output_prefix:
        args.output_prefix = "woosh"
    options = recorder_options(args)
    with ExitStack() as stack:
        stack.enter_context(interrupt_on_signals())
        address, host = (simulated(args, out, stack), args.host) if args.sim else chosen(args)
        uri = master_uri_of(address)
        node = stack.enter_context(
            Node("woosh_record", master_uri=uri, host=host, anonymous=True, rosout=False, resolve=names(args))
        )
        selection = selection_of(args.topics, camera=args.camera, all=args.all, exclude=args.exclude)
        recorder = Recorder(node, selection=selection, **options)
        code = follow_recording(recorder, quiet=args.quiet or args.json)
    return _tell(recorder, out) or code


def selection_of(
    topics: list[str] = [],  # noqa: B006  (never changed)
    *,
    camera: bool = False,
    all: bool = False,
    exclude: list[str] = [],  # noqa: B006
) -> TopicSelection:
    """What is recorded: pose and battery in any case, then the table's topics as they appear.

    Args:
        topics: More topics, in any case.
        camera: Images and point clouds too.
        all: Everything there is, also what is not the chassis's.
        exclude: Regular expressions for whole names; pose and battery stay.
    """
    from rosproto.recording import TopicSelection
    from woosh_pure.interface.table import find
    from woosh_pure.interface.table import topics as rows

    named = [name for feed in ALWAYS for name in (find(feed).name, *find(feed).aliases)]
    known = [name for row in rows() if camera or row.type not in HEAVY for name in (row.name, *row.aliases)]
    patterns = [re.escape(name) for name in (*known, *BEYOND_TABLE)]
    return TopicSelection(
        [*named, *("/" + topic.lstrip("/") for topic in topics)],
        patterns=[*patterns, GOALS],
        exclude=exclude,
        all=all,
    )


def _tell(recorder: Recorder, out: Output) -> int:
    """What is in the bags; 1 when there is no pose or no battery in them: then it is hardly the chassis."""
    from rosproto.bag import open_bag
    from woosh_pure.interface.table import find

    counts: dict[str, int] = {}
    files: list[dict[str, Any]] = []
    for path in filter(Path.exists, recorder.paths):
        with open_bag(path) as bag:
            files.append({"path": str(path), "bytes": bag.size, "seconds": round(bag.duration, 3)})
            for topic, known in bag.topics.items():
                counts[topic] = counts.get(topic, 0) + known.message_count
    for topic, count in sorted(counts.items()):
        out.line(f"  {topic:40s} {count:8d}")
    rows = [find(feed) for feed in ALWAYS]
    silent = [row.name for row in rows if not any(name in counts for name in (row.name, *row.aliases))]
    if silent:
        out.line(f"nothing was heard on {' and '.join(silent)}; try `woosh doctor`")
    out.result({"files": files, "topics": counts, "dropped": recorder.dropped, "silent": silent})
    return 1 if silent else 0
