"""Topics of many recordings as a Dask dataframe; needs dask[dataframe], and pyarrow (the extra `arrow`).

A thin layer: `rosproto.bag.partitions` cuts the recordings, each piece becomes one partition of the
dataframe, and Dask schedules them.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from rosproto.bag.bag_file import BagLimits
from rosproto.bag.partitioning import PARTITION_BYTES, Damaged, Files, Partition, partitions
from rosproto.errors import BagError
from rosproto.extras import optional_module

if TYPE_CHECKING:
    from dask.dataframe import DataFrame
    from pandas import DataFrame as Frame
    from pyarrow import Table

__all__ = ["read_bags"]


def read_bags(
    files: Files,
    topic: str,
    *,
    fields: Iterable[str] | None = None,
    size: int = PARTITION_BYTES,
    damaged: Damaged = "raise",
    limits: BagLimits | None = None,
) -> DataFrame:
    """Read a topic of recordings as a dask.dataframe.DataFrame, with every message exactly once.

    Args:
        files: See `rosproto.bag.partitions`, also for `size`, `fields`, `damaged` and `limits`. Workers
            must reach the files under the same names.
        topic: The topic.

    Raises:
        BagError: See `rosproto.bag.partitions`; or Dask is missing.
    """
    missing = BagError('this needs dask.dataframe: pip install "dask[dataframe]"')
    dataframe = optional_module("dask.dataframe", missing)
    pieces = partitions(files, topic, size=size, fields=fields, damaged=damaged, limits=limits)
    empty = pieces[0].schema().empty_table()
    table: DataFrame = dataframe.from_map(_frame, pieces, meta=_pandas(empty))
    return table


def _frame(piece: Partition) -> Frame:
    return _pandas(piece.table())


def _pandas(table: Table) -> Frame:
    """A pandas frame with Arrow's types; dictionaries become plain strings, because they differ by piece."""
    import pandas
    import pyarrow

    columns = [
        column.cast(column.type.value_type) if pyarrow.types.is_dictionary(column.type) else column
        for column in table.columns
    ]
    plain = pyarrow.table(columns, names=table.column_names)
    return plain.to_pandas(types_mapper=pandas.ArrowDtype)
