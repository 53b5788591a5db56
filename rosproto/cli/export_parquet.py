"""`rosproto bag export BAG parquet`: a table per topic, for pandas, polars, DuckDB and others."""

from __future__ import annotations

import argparse
import os
import re
from collections.abc import Iterable
from contextlib import ExitStack
from types import ModuleType
from typing import TYPE_CHECKING
from zlib import crc32

from rosproto.bag import BagReader
from rosproto.cli.bag_edit import span
from rosproto.cli.bag_files import check_new, named, next_to, whole
from rosproto.cli.bag_progress import Progress
from rosproto.cli.console import counted
from rosproto.cli.exit_codes import CommandError
from rosproto.extras import optional_module

if TYPE_CHECKING:
    import pyarrow as pa
    import pyarrow.parquet as pq

GROUP_BYTES = 32 << 20
"""Of a row group, in memory: readers take one at a time."""
MAX_UNFINISHED_BYTES = 64 << 20
"""Of all unfinished row groups together; from there on the largest is written as it is."""


def write_parquet(bag: BagReader, topics: list[str], arguments: argparse.Namespace) -> list[str]:
    """Write a file per topic; on an error none remains."""
    parquet = need("pyarrow.parquet", "pyarrow", "arrow")
    from rosproto.bag.arrow import TopicBatches, batches_of

    paths = _paths(bag, topics, arguments)
    total = sum(bag.topics[topic].message_count for topic in topics)
    tables = [TopicBatches(bag, topic, arguments.fields) for topic in topics]
    files = [_File(parquet, paths[topic], table.schema) for topic, table in zip(topics, tables, strict=True)]
    with ExitStack() as stack, Progress("writing Parquet", total, quiet=arguments.quiet) as progress:
        for file in files:
            stack.enter_context(whole(file.path))
            stack.callback(file.close)
        for number, batch in batches_of(bag, tables, *span(bag, arguments), step=progress.step):
            files[number].take(batch)
            if sum(file.size for file in files) >= MAX_UNFINISHED_BYTES:
                max(files, key=lambda file: file.size).write()
        for file in files:
            file.write()
    return list(paths.values())


def _paths(bag: BagReader, topics: list[str], arguments: argparse.Namespace) -> dict[str, str]:
    output: str | None = arguments.output
    if output is None or not output.endswith(".parquet") or os.path.isdir(output):
        return new_paths(bag, topics, arguments, ".parquet")
    if len(topics) != 1:
        raise CommandError(
            f"{output} is one file, but there are {counted(len(topics), 'topic')}: choose one with"
            " --topics, or name a directory"
        )
    check_new([output], arguments.bag)
    return {topics[0]: output}


def new_paths(
    bag: BagReader, topics: list[str], arguments: argparse.Namespace, ending: str
) -> dict[str, str]:
    """Return the output path of each topic, and create the directory (the default one or `--output`).

    Raises:
        CommandError: A file already exists.
    """
    directory: str = arguments.output or next_to(arguments.bag)
    names = file_names(bag.topics)
    paths = {topic: os.path.join(directory, names[topic] + ending) for topic in topics}
    check_new(paths.values(), arguments.bag)
    os.makedirs(directory, exist_ok=True)
    return paths


class _File:
    """One topic's file.

    Attributes:
        path: The file.
        size: Bytes in the incomplete row group.
    """

    def __init__(self, parquet: ModuleType, path: str, schema: pa.Schema) -> None:
        self._parquet = parquet
        self._schema = schema
        self._writer: pq.ParquetWriter | None = None
        self._group: list[pa.RecordBatch] = []
        self.path = path
        self.size = 0

    def take(self, batch: pa.RecordBatch) -> None:
        """Add a record batch; write a complete row group."""
        self._group.append(batch)
        self.size += batch.nbytes
        if self.size >= GROUP_BYTES:
            self.write()

    def write(self) -> None:
        """Write the pending batches as a row group."""
        with named(self.path):
            if self._writer is None:
                # No dictionary for numbers: they seldom repeat, and a trial costs a hash each.
                self._writer = self._parquet.ParquetWriter(
                    self.path, self._schema, compression="zstd", use_dictionary=_texts(self._schema)
                )
            if self._group:
                table = need("pyarrow", "pyarrow", "arrow").Table.from_batches(self._group)
                self._group, self.size = [], 0
                self._writer.write_table(table)

    def close(self) -> None:
        if self._writer is not None:
            with named(self.path):
                self._writer.close()


def _texts(schema: pa.Schema) -> list[str]:
    """Return the Parquet names of string columns."""
    return [path for field in schema for path in _texts_in(field, "")]


def _texts_in(field: pa.Field, prefix: str) -> list[str]:
    kind, path = str(field.type), prefix + field.name
    if kind.startswith("struct"):
        inner = [field.type.field(number) for number in range(field.type.num_fields)]
        return [name for each in inner for name in _texts_in(each, path + ".")]
    return [path] if kind.startswith("dictionary") else []


# -- names of files -----------------------------------------------------------------------------------------
# Each topic has its own file name on every system.
#
# Windows and macOS ignore case, Windows reserves device names, and invalid characters become a dash: `/a/b`
# and `/a-b` would be one file. A topic with an ambiguous name gets its check sum appended, so that its name
# is the same in each export of the bag.


MAX_NAME_CHARACTERS = 150
_DEVICES = re.compile(r"(?:con|prn|aux|nul|conin\$|conout\$|(?:com|lpt)[0-9])", re.IGNORECASE)


def file_name(topic: str) -> str:
    """Convert a topic to a file name for every system: "/camera/image_raw" -> "camera-image_raw"."""
    name = re.sub(r"[^A-Za-z0-9_]+", "-", topic).strip("-") or "topic"
    if len(name) > MAX_NAME_CHARACTERS:
        name = name[:MAX_NAME_CHARACTERS]
    return f"topic-{name}" if _DEVICES.fullmatch(name) else name


def file_names(topics: Iterable[str]) -> dict[str, str]:
    """Return a unique file name for each topic, on every system.

    Args:
        topics: All topics of a bag, also unexported ones: names do not depend on the selection.

    Raises:
        CommandError: Two topics get the same file name.
    """
    names: dict[str, str] = {}
    owners: dict[str, list[str]] = {}
    # The first legal topic name keeps the plain form.
    for topic in sorted(topics, key=lambda topic: (not _is_plain(topic), topic)):
        owners.setdefault(file_name(topic).lower(), []).append(topic)
    for group in owners.values():
        for number, topic in enumerate(group):
            names[topic] = file_name(topic) + (f"-{_sum(topic)}" if number else "")
    taken: dict[str, str] = {}
    for topic, name in names.items():
        other = taken.setdefault(name.lower(), topic)
        if other != topic:
            raise CommandError(
                f"{other!r} and {topic!r} would be one file, {name}; export them one by one: --topics"
            )
    return names


def _is_plain(topic: str) -> bool:
    return re.fullmatch(r"(?:/[A-Za-z0-9_]+)+", topic) is not None and len(topic) <= MAX_NAME_CHARACTERS


def _sum(topic: str) -> str:
    return f"{crc32(topic.encode('utf-8', 'surrogatepass')):08x}"


def need(module: str, package: str, extra: str) -> ModuleType:
    """Import an optional package.

    Raises:
        CommandError: It is not installed; the text names the extra.
    """
    missing = CommandError(f'this needs the package {package}: pip install ".[{extra}]"')
    return optional_module(module, missing)
