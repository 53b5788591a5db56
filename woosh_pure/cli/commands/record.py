"""`woosh record`: record the chassis's topics into a bag, without motion."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosproto.sentence import say
from woosh_pure.cli.connection import chosen, names, simulated
from woosh_pure.cli.output import Output
from woosh_pure.interface.recorded_topics import ALWAYS, selection_of
from woosh_pure.interface.table import find

if TYPE_CHECKING:
    from rosproto.recording import Recorder

HELP = "record what the chassis says and is told into a bag, until interrupted; moves nothing"


def add_arguments(parser: ArgumentParser) -> None:
    """See `Command`."""
    from rosproto.cli import add_output_options

    parser.add_argument("topics", nargs="*", metavar="TOPIC", help="more topics, beside those of the chassis")
    parser.add_argument("--camera", action="store_true", help="also images and point clouds (much data)")
    parser.add_argument("--all", action="store_true", help="every topic of the graph")
    parser.add_argument("-x", "--exclude", action="append", default=[], metavar="REGEX", help="not these")
    add_output_options(parser)
    parser.add_argument("--uncompressed", action="store_const", const="none", dest="compression")
    parser.set_defaults(compression="lz4", output_prefix=None)


def run(args: Namespace, out: Output) -> int:
    """See `Command`."""
    from rosproto import Node
    from rosproto.cli import follow_recording, interrupt_on_signals, recorder_options
    from rosproto.recording import Recorder
    from woosh_pure.connection.arguments import master_uri_of

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


def _tell(recorder: Recorder, out: Output) -> int:
    """Print the bags' contents; return 1 if one is damaged, or without pose or battery (no chassis)."""
    from rosproto.bag import open_bag

    counts: dict[str, int] = {}
    files: list[dict[str, Any]] = []
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
        out.line(say("nothing was heard on {names}; try `woosh doctor`", names=" and ".join(silent)))
    for problem in damage:
        out.line(say("damaged, messages may be missing: {problem}", problem=problem))
    out.result(
        {"files": files, "topics": counts, "dropped": recorder.dropped, "silent": silent, "damage": damage}
    )
    return 1 if silent or damage else 0
