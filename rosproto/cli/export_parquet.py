"""`rosproto bag export BAG parquet`: a table a topic, for pandas, polars, DuckDB and everything else."""

from __future__ import annotations

import argparse
import os
from typing import TYPE_CHECKING, Any

from .bag_edit import span
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


def write_parquet(bag: BagReader, topics: list[str], arguments: argparse.Namespace) -> list[str]:
    """A file for each topic; what stands there already is replaced once the new one is whole."""
    parquet = need("pyarrow.parquet", "pyarrow", "arrow")
    paths = _paths(bag, topics, arguments)
    total = sum(bag.topics[topic].message_count for topic in topics)
    start, end = span(bag, arguments)
    with Progress("writing Parquet", total, quiet=arguments.quiet) as progress:
        for topic in topics:
            batches = bag.to_arrow(topic, arguments.fields, start_time=start, end_time=end)
            _write(parquet, paths[topic], batches, progress)
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
    directory = output or os.path.splitext(arguments.bag)[0]
    os.makedirs(directory, exist_ok=True)
    names = file_names(bag.topics)
    return {topic: os.path.join(directory, names[topic] + ".parquet") for topic in topics}


def _write(parquet: Any, path: str, batches: Any, progress: Progress) -> None:
    """One file, under another name until it is whole."""
    part = path + ".part"
    try:
        with parquet.ParquetWriter(part, batches.schema, compression="zstd") as writer:
            group: list[Any] = []
            size = 0
            for batch in batches:
                group.append(batch)
                size += batch.nbytes
                progress.step(batch.num_rows)
                if size >= GROUP_BYTES:
                    writer.write_table(_table(group))
                    group, size = [], 0
            if group:
                writer.write_table(_table(group))
        os.replace(part, path)
    except BaseException:
        if os.path.exists(part):
            os.unlink(part)
        raise


def _table(group: list[Any]) -> Any:
    return need("pyarrow", "pyarrow", "arrow").Table.from_batches(group)
