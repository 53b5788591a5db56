"""`rosproto bag`: the verbs of rosbag, without a ROS installation."""

from __future__ import annotations

import argparse
import importlib

from rosproto.cli import topic
from rosproto.cli.graph_options import Verb, add_verbs

VERBS = {
    "info": ("bag_info", "info", "tell what is in bags, without reading the messages"),
    "check": ("bag_repair", "check", "read everything and tell what is damaged or undecodable"),
    "record": ("bag_record", "record", "record topics of a live graph"),
    "play": ("bag_play", "play", "publish bags to a live graph as they were recorded"),
    "echo": ("bag", "echo", "print the messages of a topic"),
    "filter": ("bag_edit", "filter", "copy chosen topics, a span, or what an expression chooses"),
    "merge": ("bag_edit", "merge", "put several bags into one, by time"),
    "convert": ("bag_edit", "convert", "make MCAP of a bag, or a bag of MCAP"),
    "compress": ("bag_edit", "compress", "compress a bag in place; the original is kept"),
    "decompress": ("bag_edit", "decompress", "decompress a bag in place; the original is kept"),
    "reindex": ("bag_repair", "reindex", "give a bag that was not closed its index, in place"),
    "fix": ("bag_repair", "fix", "save what can be read of a damaged bag into a new one"),
    "export": ("bag_export", "export", "write messages as CSV, PNG, NPZ, MCAP or Parquet"),
}
"""Verb -> (module, its functions `add_<name>_arguments` and `<name>`, help); what they need comes later."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verbs."""
    add_verbs(parser, {name: _verb(*row) for name, row in VERBS.items()}, graph=False)


def _verb(module: str, name: str, text: str) -> Verb:
    found = importlib.import_module(f".{module}", __package__)
    return getattr(found, f"add_{name}_arguments"), getattr(found, name), text


def add_echo_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the bag and the arguments of `topic echo`."""
    parser.add_argument("file", metavar="BAG")
    topic.add_echo_arguments(parser)
    parser.add_argument("--json", action="store_true", help="print messages as JSON, one per line")


def echo(arguments: argparse.Namespace) -> None:
    """Run `rosproto topic echo` on a bag; the topic may be a pattern such as '/camera/*'."""
    arguments.bag = arguments.file
    topic.echo(arguments)
