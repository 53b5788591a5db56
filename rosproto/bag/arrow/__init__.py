"""Topics of bags as Arrow tables; needs pyarrow (the extra `arrow`)."""

from rosproto.bag.arrow.batches import BATCH_BYTES, BATCH_ROWS, to_arrow
from rosproto.bag.arrow.schema import schema_of

__all__ = ["BATCH_BYTES", "BATCH_ROWS", "schema_of", "to_arrow"]
