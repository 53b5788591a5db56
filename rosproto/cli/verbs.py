"""The verbs of a command, as `list` in `rosproto topic list`: a table of them becomes subparsers."""

from __future__ import annotations

import argparse
from collections.abc import Callable

from .graph_options import add_graph_options
from .options import AddArguments

Verb = tuple[AddArguments | None, Callable[[argparse.Namespace], int], str]
"""What adds its arguments, what runs it, help."""


def add_verbs(parser: argparse.ArgumentParser, table: dict[str, Verb], *, graph: bool = True) -> None:
    """Add the verbs of a command: `rosproto topic list`."""
    choices = parser.add_subparsers(title="verbs", metavar="VERB", dest="verb", required=True)
    for name, (add, run, text) in table.items():
        sub = choices.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
        if graph:
            add_graph_options(sub)
        if add is not None:
            add(sub)
        sub.set_defaults(run=run)
