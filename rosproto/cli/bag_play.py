"""`rosproto bag play`: the options and keys of rosbag play."""

from __future__ import annotations

import argparse
import sys
from contextlib import ExitStack
from typing import TYPE_CHECKING

from rosproto.cli.background_output import never_wait_for_stdout
from rosproto.cli.bag_files import left_out, opened
from rosproto.cli.bag_progress import Progress
from rosproto.cli.console import counted, is_terminal, warn
from rosproto.cli.exit_codes import CommandError
from rosproto.cli.graph_clients import open_node
from rosproto.cli.graph_options import add_graph_options
from rosproto.cli.keys import Keys, open_keys
from rosproto.cli.options import add_allow_damaged, count, positive, seconds
from rosproto.cli.signals import interrupt_on_signals

if TYPE_CHECKING:
    from rosproto.bag import BagReader
    from rosproto.recording import Player


def add_play_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of rosbag play."""
    add_graph_options(parser, as_json=False)
    parser.add_argument("bags", nargs="*", metavar="BAG", help="and remappings: /old:=/new")
    parser.add_argument(
        "-r", "--rate", type=positive, default=1.0, metavar="FACTOR", help="play this many times as fast"
    )
    parser.add_argument(
        "-s", "--start", type=seconds, default=0.0, metavar="SEC", help="skip this many seconds at the start"
    )
    parser.add_argument(
        "-u", "--duration", type=seconds, metavar="SEC", help="stop after this many seconds of the bag"
    )
    parser.add_argument("-l", "--loop", action="store_true", help="start again at the end")
    parser.add_argument(
        "-k", "--keep-alive", action="store_true", help="keep running after the end, for latched topics"
    )
    parser.add_argument("--clock", action="store_true", help="publish /clock with the time of the bag")
    parser.add_argument("--hz", type=positive, default=100.0, help="rate of /clock (default: 100)")
    parser.add_argument(
        "-d", "--delay", type=seconds, default=0.2, metavar="SEC", help="wait before the first message (0.2)"
    )
    parser.add_argument("--pause", action="store_true", help="start paused")
    parser.add_argument("-i", "--immediate", action="store_true", help="as fast as subscribers take it")
    parser.add_argument(
        "--queue", type=count, default=1000, metavar="N", help="queue size of each topic (1000)"
    )
    parser.add_argument("--topics", nargs="+", metavar="TOPIC", help="play only these")
    parser.add_argument(
        "--bags", nargs="+", dest="more_bags", default=[], metavar="BAG", help="bags, after --topics"
    )
    parser.add_argument("-p", "--prefix", default="", help="prefix of every topic")
    parser.add_argument("--skip-empty", type=seconds, metavar="SEC", help="skip silences longer than this")
    parser.add_argument(
        "--pause-topics", nargs="+", metavar="TOPIC", default=[], help="pause before messages of these"
    )
    parser.add_argument(
        "--rate-control-topic",
        metavar="TOPIC",
        help="keep in step with this topic, whose header stamps are bag time",
    )
    parser.add_argument(
        "--rate-control-max-delay",
        type=seconds,
        default=1.0,
        metavar="SEC",
        help="wait when this far ahead of it (1)",
    )
    parser.add_argument(
        "--wait-for-subscribers", action="store_true", help="wait for subscribers of every topic first"
    )
    add_allow_damaged(parser)
    parser.add_argument("-q", "--quiet", action="store_true", help="print no progress line")


def play(arguments: argparse.Namespace) -> None:
    """Publish until the end, or until interrupted."""
    from rosproto.recording import Player

    never_wait_for_stdout()
    paths, remap = _split_remappings([*arguments.bags, *arguments.more_bags])
    with ExitStack() as stack:
        bags = [stack.enter_context(opened(path, arguments, quiet=arguments.quiet)) for path in paths]
        stack.enter_context(interrupt_on_signals())
        # The default switch interval of 5 ms is too long for the timing of messages.
        stack.callback(sys.setswitchinterval, sys.getswitchinterval())
        sys.setswitchinterval(0.0005)
        node = stack.enter_context(open_node(arguments, "play"))
        keys = stack.enter_context(open_keys(driving=False)) if is_terminal(sys.stdin) else None
        line = Progress("", quiet=arguments.quiet)
        stack.callback(line.leave)
        console = _Console(line, keys)
        player = stack.enter_context(
            Player(
                node,
                bags,
                topics=arguments.topics and _present(bags, arguments.topics),
                rate=arguments.rate,
                start=arguments.start,
                duration=arguments.duration,
                loop=arguments.loop,
                clock_hz=arguments.hz if arguments.clock else None,
                remap=remap,
                prefix=arguments.prefix,
                delay=arguments.delay,
                queue_size=arguments.queue,
                keep_alive=arguments.keep_alive,
                paused=arguments.pause,
                skip_empty=arguments.skip_empty,
                immediate=arguments.immediate,
                pause_topics=arguments.pause_topics,
                rate_control=_global(arguments.rate_control_topic) if arguments.rate_control_topic else None,
                rate_control_delay=arguments.rate_control_max_delay,
                on_tick=console,
                on_left_out=lambda problem: left_out(problem, arguments),
            )
        )
        if arguments.wait_for_subscribers:
            line.note("waiting for subscribers")
            player.wait_for_subscribers(timeout=None)
        if keys is not None:
            line.note("space: pause and go on, s: step, t: pause topics on and off, Ctrl-C: end")
        player.play()
        if line.on:
            console.show(player)
        else:
            line.note(counted(player.published, "message"))


def _present(bags: list[BagReader], topics: list[str]) -> list[str]:
    """Return the topics that are in a bag, and warn of the others; all of them if none is."""
    known = {topic for bag in bags for topic in bag.topics}
    found = [topic for topic in topics if topic in known]
    for topic in topics if found else ():
        if topic not in known:
            warn(f"no messages on topic {topic!r}; there are {', '.join(sorted(known))}")
    return found or topics


def _split_remappings(words: list[str]) -> tuple[list[str], dict[str, str]]:
    paths = [word for word in words if ":=" not in word]
    pairs = [word.partition(":=") for word in words if ":=" in word]
    if not paths:
        raise ValueError("no bag to play; name one")
    for old, _, new in pairs:
        if not old or not new:
            raise CommandError(f"{old}:={new} is not a remapping: write /old:=/new")
    return paths, {_global(old): _global(new) for old, _, new in pairs}


def _global(name: str) -> str:
    return name if name.startswith("/") else "/" + name


class _Console:
    """Reads keys and shows a progress line; the player calls it about 20 times a second."""

    def __init__(self, line: Progress, keys: Keys | None) -> None:
        self._line, self._keys = line, keys
        self._calls = 0

    def __call__(self, player: Player) -> None:
        for key in self._keys.read(0.0) if self._keys else ():
            if key == " ":
                (player.resume if player.paused else player.pause)()
            elif key == "s":
                player.step()
            elif key == "t":
                player.pause_on_topics = not player.pause_on_topics
        self._calls += 1
        if self._calls % 4 == 1 and self._line.on:
            self.show(player)

    def show(self, player: Player) -> None:
        state = "[PAUSED] " if player.paused else "[DELAYED]" if player.waits_for else "[RUNNING]"
        self._line.show(
            f"{state} bag time {player.position_ns / 1e9:.3f}  {player.position:.2f} / "
            f"{player.timeline.duration:.2f} s  {counted(player.published, 'message')}"
        )
