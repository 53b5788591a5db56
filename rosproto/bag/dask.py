"""Topics of many recordings as a Dask dataframe; needs dask[dataframe], and pyarrow (the extra `arrow`).

A thin layer: `rosproto.bag.partitions` cuts the recordings, each piece becomes one partition of the
dataframe, and Dask schedules them.
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Literal

from rosproto.bag.pieces import PIECE_BYTES, Partition, partitions
from rosproto.errors import BagError

if TYPE_CHECKING:
    from rosproto.bag.limits import BagLimits

__all__ = ["read_bags"]


def read_bags(
    files: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
    topic: str,
    *,
    fields: Iterable[str] | None = None,
    size: int = PIECE_BYTES,
    damaged: Literal["raise", "skip"] = "raise",
    limits: BagLimits | None = None,
) -> Any:
    """A topic of recordings as a dask.dataframe.DataFrame, with every message exactly once.

    Args:
        files: See `rosproto.bag.partitions`; workers must reach them under the same names.
        topic: The topic.
        fields: See `BagReader.to_arrow`.
        size: A piece is full when its chunks take this many bytes of the file.
        damaged: See `rosproto.bag.partitions`.
        limits: How much each file may ask for.

    Raises:
        BagError: See `rosproto.bag.partitions`; or Dask is missing.
    """
    try:
        dataframe: Any = importlib.import_module("dask.dataframe")
    except ImportError as problem:
        raise BagError("this needs Dask's dataframes: pip install 'dask[dataframe]'") from problem
    pieces = partitions(files, topic, size=size, fields=fields, damaged=damaged, limits=limits)
    empty = pieces[0].schema().empty_table()
    return dataframe.from_map(_frame, pieces, meta=_pandas(empty))


def _frame(piece: Partition) -> Any:
    return _pandas(piece.table())


def _pandas(table: Any) -> Any:
    """A pandas frame with Arrow's types; dictionaries become plain strings, because they differ by piece."""
    import pandas
    import pyarrow

    columns = [
        column.cast(column.type.value_type) if pyarrow.types.is_dictionary(column.type) else column
        for column in table.columns
    ]
    plain = pyarrow.table(columns, names=table.column_names)
    return plain.to_pandas(types_mapper=pandas.ArrowDtype)
