"""`rosproto param`: get, set, list, delete, dump, load, search; output as of rosparam."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from rosproto.cli.console import json_text, warn
from rosproto.cli.exit_codes import CommandError
from rosproto.cli.graph_clients import absolute, below, master_client, unknown, warn_if_none
from rosproto.cli.graph_options import add_verbs
from rosproto.cli.options import argument
from rosproto.cli.yaml_values import load_all, to_text, value_of
from rosproto.errors import MasterError
from rosproto.files import read_file, read_stream, read_text, write_file
from rosproto.json_values import plain
from rosproto.names import join
from rosproto.text import printable

if TYPE_CHECKING:
    from rosproto.node.graph.master_client import MasterClient

T = TypeVar("T")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verbs."""
    add_verbs(
        parser,
        {
            "get": (_get_arguments, _get, "print a parameter or a whole namespace"),
            "set": (_set_arguments, _set, "set a parameter"),
            "list": (argument("namespace", nargs="?", default="/"), _list, "list the names of parameters"),
            "delete": (argument("key"), _delete, "delete a parameter or namespace"),
            "search": (argument("key"), _search, "find a parameter upwards from the root"),
            "dump": (_dump_arguments, _dump, "write parameters to a file"),
            "load": (_load_arguments, _load, "set parameters from a file"),
        },
    )


def _get_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("key")
    parser.add_argument(
        "-p", "--pretty", action="store_true", help="text as it is, over several lines, for reading"
    )


def _set_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("key")
    parser.add_argument(
        "value",
        nargs="?",
        help="a number, true, text, [1, 2] or {a: 1}, which keeps what else is there; - reads standard input",
    )
    source = parser.add_mutually_exclusive_group()
    source.add_argument("-t", "--textfile", metavar="FILE", help="the value is the text of this file")
    source.add_argument("-b", "--binfile", metavar="FILE", help="the value is the bytes of this file")


def _dump_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", nargs="?", default="-", help="file to write (default: standard output)")
    parser.add_argument("namespace", nargs="?", default="", help="default: $ROS_NAMESPACE, else /")


def _load_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "file", help="a YAML or JSON file; - is standard input. What it does not name stays as it is"
    )
    parser.add_argument("namespace", nargs="?", default="", help="default: $ROS_NAMESPACE, else /")


def _ask(arguments: argparse.Namespace, key: str, question: Callable[[MasterClient, str], T]) -> T:
    """Ask the master about a parameter; an unknown one is an error."""
    with master_client(arguments) as master:
        try:
            return question(master, absolute(key))
        except MasterError as error:
            names = master.get_param_names()
            raise unknown("there is no parameter", absolute(key), names, "param list") from error


def _fetch(arguments: argparse.Namespace, key: str) -> Any:
    return _ask(arguments, key, lambda master, name: master.get_param(name))


def _get(arguments: argparse.Namespace) -> None:
    value = _fetch(arguments, arguments.key)
    if arguments.json:
        arguments.out.record(plain(value))
    elif arguments.pretty and isinstance(value, str):
        print(value)  # --pretty: a text of several lines unchanged
    elif arguments.pretty and isinstance(value, dict):
        _print_pretty(value, "")
    else:
        print(to_text(value))


def _print_pretty(value: Mapping[str, object], indent: str) -> None:
    """Print sorted keys; a text of several lines goes below its key."""
    for key, item in sorted(value.items()):
        if isinstance(item, dict):
            print(f"{indent}{printable(key)}:")
            _print_pretty(item, indent + "  ")
        elif isinstance(item, str):
            lines = item.split("\n")
            print(f"{indent}{printable(key)}: " + (item if len(lines) == 1 else "|"))
            for line in lines if len(lines) > 1 else ():
                print(f"{indent}  {line}")
        else:
            text = to_text(item)
            below = f"\n{text}" if isinstance(item, list) and item else f" {text}"
            print(f"{indent}{printable(key)}:" + below.rstrip())


def _set(arguments: argparse.Namespace) -> None:
    given = [v for v in (arguments.value, arguments.textfile, arguments.binfile) if v is not None]
    if len(given) != 1:
        raise ValueError("give a value, or --textfile FILE, or --binfile FILE")
    if arguments.textfile is not None:
        value: object = read_text(arguments.textfile)
    elif arguments.binfile is not None:
        value = read_file(arguments.binfile)
    else:
        value = value_of(
            read_stream(sys.stdin, "standard input") if arguments.value == "-" else arguments.value
        )
    _store(arguments, [(absolute(arguments.key), value)])


def _store(arguments: argparse.Namespace, given: Iterable[tuple[str, object]]) -> None:
    """Set the parameters of each value, all of them checked before; what else is in a namespace stays."""
    from rosproto.node.parameters import leaves, plain_value

    found = [(name, plain_value(leaf, name)) for key, value in given for name, leaf in leaves(key, value)]
    if any(not name.strip("/") for name, _ in found):
        raise ValueError("the root namespace takes names and values, `{speed: 2}`")
    if not found:
        warn("there was nothing to set: an empty file or namespace changes nothing; param delete empties one")
    with master_client(arguments) as master:
        for answer in master.batch([("setParam", pair) for pair in found]):
            if isinstance(answer, MasterError):
                raise answer


def _list(arguments: argparse.Namespace) -> None:
    with master_client(arguments) as master:
        known = master.get_param_names()
    names = below(known, arguments.namespace)
    warn_if_none(names, "parameter", arguments.namespace, known)
    arguments.out.answer(names, names)


def _delete(arguments: argparse.Namespace) -> None:
    if absolute(arguments.key) == "/":  # the root stays, as in rosparam
        with master_client(arguments) as master:
            master.set_param("/", {})
        return
    _ask(arguments, arguments.key, lambda master, name: master.delete_param(name))


def _search(arguments: argparse.Namespace) -> None:
    with master_client(arguments) as master:
        try:
            found = master.search_param(arguments.key)
        except MasterError as error:
            raise CommandError(
                f"no parameter is called {arguments.key!r} from here upwards; see: rosproto param list"
            ) from error
    arguments.out.answer(found, found)


def _dump(arguments: argparse.Namespace) -> None:
    value = _fetch(arguments, arguments.namespace)
    text = json_text(plain(value), ascii_only=True, indent=2) if arguments.json else to_text(value)
    text = text.rstrip("\n") + "\n"
    if arguments.file == "-":
        print(text, end="")
    else:
        write_file(arguments.file, text.encode())


def _load(arguments: argparse.Namespace) -> None:
    text = read_stream(sys.stdin, "standard input") if arguments.file == "-" else read_text(arguments.file)
    origin = "standard input" if arguments.file == "-" else arguments.file
    found = [document for document in load_all(text, origin) if document is not None]
    _store(arguments, [_placed(document, absolute(arguments.namespace), origin) for document in found])


def _placed(document: object, namespace: str, origin: str) -> tuple[str, object]:
    """Return the namespace of a document, below which its key `_ns` puts it, and its values."""
    if not isinstance(document, dict) or "_ns" not in document:
        return namespace, document
    inner = document.pop("_ns")
    if not isinstance(inner, str):
        raise CommandError(f"{origin}: _ns is the name of a namespace, not {inner!r}")
    return join(namespace, inner), document
