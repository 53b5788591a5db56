"""`rosproto bag export BAG parquet`: a table a topic, for pandas, polars, DuckDB and everything else."""

from __future__ import annotations

import argparse
import os
from typing import TYPE_CHECKING, Any

from .bag_edit import span
from .bag_opening import next_to
from .bag_progress import Progress
from .connection import CommandError
from .counts import counted
from .export_names import file_names
from .optional import need

if TYPE_CHECKING:
    from rosproto.bag import BagReader

__all__ = ["write_parquet"]

GROUP_BYTES = 32 << 20
"""Of a row group, in memory: readers take one at a time."""
MOST_BYTES = 64 << 20
"""Of all unfinished row groups together; from there on the largest is written as it is."""


def write_parquet(bag: BagReader, topics: list[str], arguments: argparse.Namespace) -> list[str]:
    """A file for each topic; what stands there already is replaced once the new ones are whole."""
    parquet = need("pyarrow.parquet", "pyarrow", "arrow")
    from rosproto.bag.arrow import TopicBatches, batches_of

    paths = _paths(bag, topics, arguments)
    total = sum(bag.topics[topic].message_count for topic in topics)
    tables = [TopicBatches(bag, topic, arguments.fields) for topic in topics]
    files = [_File(parquet, paths[topic], table.schema) for topic, table in zip(topics, tables, strict=True)]
    try:
        with Progress("writing Parquet", total, quiet=arguments.quiet) as progress:
            for number, batch in batches_of(bag, tables, *span(bag, arguments)):
                progress.step(batch.num_rows)
                files[number].take(batch)
                if sum(file.size for file in files) >= MOST_BYTES:
                    max(files, key=lambda file: file.size).write()
            for file in files:
                file.finish()
        for file in files:
            os.replace(file.part, file.path)
    except BaseException:
        for file in files:
            file.drop()
        raise
    return list(paths.values())


def _paths(bag: BagReader, topics: list[str], arguments: argparse.Namespace) -> dict[str, str]:
    output: str | None = arguments.output
    if output is not None and output.endswith(".parquet") and not os.path.isdir(output):
        if len(topics) != 1:
            raise CommandError(
                f"{output} is one file, but there are {counted(len(topics), 'topic')}: choose one with"
                " --topics, or name a directory"
            )
        return {topics[0]: output}
    directory = output or next_to(arguments.bag)
    os.makedirs(directory, exist_ok=True)
    names = file_names(bag.topics)
    return {topic: os.path.join(directory, names[topic] + ".parquet") for topic in topics}


class _File:
    """One topic's file, under another name until all are whole.

    Attributes:
        path: Its name in the end.
        part: Its name until then.
        size: Bytes that wait for their row group to be full.
    """

    def __init__(self, parquet: Any, path: str, schema: Any) -> None:
        self._parquet = parquet
        self._schema = schema
        self._writer: Any = None
        self._group: list[Any] = []
        self.path = path
        self.part = path + ".part"
        self.size = 0

    def take(self, batch: Any) -> None:
        """A record batch; writes what makes a row group."""
        self._group.append(batch)
        self.size += batch.nbytes
        if self.size >= GROUP_BYTES:
            self.write()

    def write(self) -> None:
        """What waits, as a row group."""
        if self._writer is None:
            # Numbers seldom repeat: a dictionary of them is tried, and given up, at the cost of a hash each.
            self._writer = self._parquet.ParquetWriter(
                self.part, self._schema, compression="zstd", use_dictionary=_texts(self._schema)
            )
        if self._group:
            table = need("pyarrow", "pyarrow", "arrow").Table.from_batches(self._group)
            self._group, self.size = [], 0
            self._writer.write_table(table)

    def finish(self) -> None:
        self.write()
        self._writer.close()

    def drop(self) -> None:
        """Leave nothing of it."""
        if self._writer is not None:
            try:
                self._writer.close()
            except OSError:
                pass  # why it failed is told already
        if os.path.exists(self.part):
            os.unlink(self.part)


def _texts(schema: Any) -> list[str]:
    """The columns of texts, as Parquet names them."""
    return [path for field in schema for path in _texts_in(field, "")]


def _texts_in(field: Any, prefix: str) -> list[str]:
    kind, path = str(field.type), prefix + field.name
    if kind.startswith("struct"):
        inner = [field.type.field(number) for number in range(field.type.num_fields)]
        return [name for each in inner for name in _texts_in(each, path + ".")]
    return [path] if kind.startswith("dictionary") else []
