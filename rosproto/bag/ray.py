"""Topics of many recordings as a Ray dataset; needs Ray, and pyarrow (the extra `arrow`).

A thin source: `rosproto.bag.partitions` cuts the recordings, each piece is one read task, and Ray schedules
them and repeats those whose worker died.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from rosproto.bag.bag_file import BagLimits
from rosproto.bag.partitioning import PARTITION_BYTES, Damaged, Files, Partition, partitions
from rosproto.errors import BagError
from rosproto.extras import optional_module

if TYPE_CHECKING:
    from pyarrow import Table
    from ray.data import Dataset, Datasource, ReadTask

__all__ = ["read_bags"]


def read_bags(
    files: Files,
    topic: str,
    *,
    fields: Iterable[str] | None = None,
    size: int = PARTITION_BYTES,
    damaged: Damaged = "raise",
    limits: BagLimits | None = None,
    **options: Any,
) -> Dataset:
    """Read a topic of recordings as a ray.data.Dataset of Arrow blocks, with every message exactly once.

    Args:
        files: See `rosproto.bag.partitions`, also for `size`, `fields`, `damaged` and `limits`. Workers
            must reach the files under the same names.
        topic: The topic.
        **options: Of `ray.data.read_datasource`, such as `concurrency` and `ray_remote_args`.

    Raises:
        BagError: See `rosproto.bag.partitions`; or Ray is missing.
    """
    data = optional_module("ray.data", BagError('this needs ray.data: pip install "ray[data]"'))
    pieces = partitions(files, topic, size=size, fields=fields, damaged=damaged, limits=limits)
    options.setdefault("override_num_blocks", len(pieces))
    dataset: Dataset = data.read_datasource(_source(pieces), **options)
    return dataset


def _reader(piece: Partition) -> Callable[[], list[Table]]:
    return lambda: [piece.table()]


def _source(pieces: list[Partition]) -> Datasource:
    base: Any = importlib.import_module("ray.data").Datasource
    metadata = importlib.import_module("ray.data.block").BlockMetadata
    task = importlib.import_module("ray.data.datasource").ReadTask
    schema = pieces[0].schema()

    class BagSource(base):  # type: ignore[misc]
        """One read task for each piece."""

        def get_name(self) -> str:
            return "Bags"

        def estimate_inmemory_data_size(self) -> int:
            return sum(piece.size for piece in pieces)

        def get_read_tasks(self, parallelism: int, *_: object, **__: object) -> list[ReadTask]:
            return [
                task(
                    _reader(piece),
                    metadata(
                        num_rows=None if piece.damaged == "skip" else piece.message_count,
                        size_bytes=piece.size,
                        input_files=(piece.file,),
                        exec_stats=None,
                    ),
                    schema=schema,
                )
                for piece in pieces
            ]

    return BagSource()
