"""`rosproto master`: a ROS master until Ctrl-C, SIGTERM, or a `shutdown` call."""

from __future__ import annotations

import argparse
import sys
from contextlib import nullcontext
from typing import TYPE_CHECKING

from rosproto.cli.background_output import never_wait_for_stdout
from rosproto.cli.exit_codes import CommandError, cannot_listen
from rosproto.cli.options import host, port
from rosproto.cli.signals import interrupt_on_signals
from rosproto.errors import ConnectionLost, RosError
from rosproto.protocol.wire_limits import Limits
from rosproto.transport.os_errors import allow_open_files
from rosproto.transport.uri import make_uri, parse_uri

if TYPE_CHECKING:
    from rosproto.master import Master
    from rosproto.rosout_aggregator import RosoutAggregator


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options for host, port and access."""
    parser.add_argument(
        "--host",
        type=host,
        default="127.0.0.1",
        help="address to listen on; only this computer by default, 0.0.0.0 for every network",
    )
    parser.add_argument(
        "-p", "--port", type=port, default=11311, help="port, 0 for a free one (default: 11311)"
    )
    parser.add_argument(
        "--advertise",
        type=host,
        metavar="HOST",
        help="host name or address that others should use, if not --host",
    )
    parser.add_argument(
        "--allow",
        metavar="ADDRESS",
        action="append",
        help="only this address may connect (repeat for more); default: everybody who can reach --host",
    )
    parser.add_argument(
        "--no-rosout", action="store_true", help="do not run the node /rosout, which publishes /rosout_agg"
    )
    parser.add_argument(
        "--rosout-log",
        metavar="FILE",
        help="append what all nodes log to FILE, as roscore's rosout.log",
    )


def run(arguments: argparse.Namespace) -> None:
    """Serve; stdout has only the master's URI."""
    from rosproto.master import Master

    if arguments.no_rosout and arguments.rosout_log:
        raise CommandError("--rosout-log is written by the node /rosout, which --no-rosout leaves out")
    never_wait_for_stdout()
    allow_open_files(Limits().connections)
    try:
        with (
            interrupt_on_signals("SIGINT", "SIGTERM", "SIGBREAK"),
            _listening(Master, arguments) as master,
            _rosout(master, arguments),
        ):
            print(master.uri, flush=True)
            # In steps: Windows delivers no Ctrl-C during an endless wait.
            while not master.wait(0.5):
                pass
    except KeyboardInterrupt:
        pass  # the normal end of this command


def _listening(kind: type[Master], arguments: argparse.Namespace) -> Master:
    try:
        return kind(arguments.host, arguments.port, advertise=arguments.advertise, allow=arguments.allow)
    except ConnectionLost as error:
        # A local error: the address cannot be bound.
        raise CommandError(cannot_listen(error, "--host")) from error


def _rosout(master: Master, arguments: argparse.Namespace) -> RosoutAggregator | nullcontext[None]:
    """Start the node /rosout; the master also works without it."""
    if arguments.no_rosout:
        return nullcontext()
    from rosproto.rosout_aggregator import RosoutAggregator

    here = {"0.0.0.0": "127.0.0.1", "": "127.0.0.1", "::": "::1"}.get(arguments.host, arguments.host)
    try:
        return RosoutAggregator(
            make_uri(here, master.port),
            host=parse_uri(master.uri)[0],
            allow=arguments.allow,
            log_file=arguments.rosout_log,
        )
    except RosError as error:
        print(f"rosproto master: there is no /rosout_agg: {error}", file=sys.stderr)
        return nullcontext()
    except OSError as error:
        raise CommandError(f"--rosout-log {arguments.rosout_log}: {error.strerror or error}") from error
