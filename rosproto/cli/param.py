"""`rosproto param`: get, set, list, delete, dump, load, search; the words and forms of rosparam."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from rosproto.errors import MasterError
from rosproto.values import parse_value

from .graph import CommandError, master_client, print_json, verbs
from .yaml_text import load_text, to_text

__all__ = ["add_arguments", "run"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """One verb each."""
    verbs(
        parser,
        {
            "get": (_key_arguments, _get, "print a parameter or a whole namespace"),
            "set": (_set_arguments, _set, "set a parameter"),
            "list": (_list_arguments, _list, "list the names of parameters"),
            "delete": (_key_arguments, _delete, "delete a parameter or namespace"),
            "search": (_key_arguments, _search, "find a parameter upwards from the root"),
            "dump": (_dump_arguments, _dump, "write parameters to a file"),
            "load": (_load_arguments, _load, "set parameters from a file"),
        },
    )


def run(arguments: argparse.Namespace) -> int:
    """Run the verb."""
    code: int = arguments.run_verb(arguments)
    return code


def _key_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("key")


def _set_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("key")
    parser.add_argument("value", help="a number, true, text, [1, 2] or {a: 1}; - reads standard input")


def _list_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("namespace", nargs="?", default="/")


def _dump_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", nargs="?", default="-", help="where to (default: standard output)")
    parser.add_argument("namespace", nargs="?", default="/")


def _load_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", help="a YAML or JSON file; - is standard input")
    parser.add_argument("namespace", nargs="?", default="/")


def _global(key: str) -> str:
    return key if key.startswith("/") else "/" + key


def _fetch(arguments: argparse.Namespace, key: str) -> Any:
    with master_client(arguments) as master:
        try:
            return master.get_param(_global(key))
        except MasterError as error:
            raise CommandError(f"parameter [{_global(key)}] is not set; see: rosproto param list") from error


def _get(arguments: argparse.Namespace) -> int:
    value = _fetch(arguments, arguments.key)
    if arguments.json:
        print_json(value)
    else:
        print(to_text(value))
    return 0


def _set(arguments: argparse.Namespace) -> int:
    text = sys.stdin.read() if arguments.value == "-" else arguments.value
    try:
        value = parse_value(text)
    except ValueError:
        value = load_text(text, "the value")
    with master_client(arguments) as master:
        master.set_param(_global(arguments.key), value)
    return 0


def _list(arguments: argparse.Namespace) -> int:
    below = _global(arguments.namespace).rstrip("/")
    with master_client(arguments) as master:
        names = sorted(n for n in master.get_param_names() if n == below or n.startswith(below + "/"))
    if arguments.json:
        print_json(names)
    elif names:
        print("\n".join(names))
    return 0


def _delete(arguments: argparse.Namespace) -> int:
    with master_client(arguments) as master:
        try:
            master.delete_param(_global(arguments.key))
        except MasterError as error:
            raise CommandError(f"parameter [{_global(arguments.key)}] is not set") from error
    return 0


def _search(arguments: argparse.Namespace) -> int:
    with master_client(arguments) as master:
        try:
            found = master.search_param(arguments.key)
        except MasterError as error:
            raise CommandError(f"no parameter is called {arguments.key!r} from here upwards") from error
    print_json(found) if arguments.json else print(found)
    return 0


def _dump(arguments: argparse.Namespace) -> int:
    value = _fetch(arguments, arguments.namespace)
    text = json.dumps(value, indent=2) if arguments.json else to_text(value)
    if arguments.file == "-":
        print(text)
    else:
        Path(arguments.file).write_text(text + "\n", "utf-8")
    return 0


def _load(arguments: argparse.Namespace) -> int:
    try:
        text = sys.stdin.read() if arguments.file == "-" else Path(arguments.file).read_text("utf-8")
    except OSError as error:
        raise CommandError(f"cannot read {arguments.file}: {error.strerror}") from error
    value = load_text(text, arguments.file)
    namespace = _global(arguments.namespace)
    if namespace == "/" and not isinstance(value, dict):
        raise CommandError(
            f"{arguments.file}: the root namespace takes names and values, not one {value!r:.40}"
        )
    with master_client(arguments) as master:
        for key, item in value.items() if namespace == "/" else [("", value)]:
            master.set_param((namespace.rstrip("/") + "/" + key).rstrip("/"), item)
    return 0
