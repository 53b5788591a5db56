"""Topics of bags as Arrow tables; needs pyarrow (the extra `arrow`)."""

from rosproto.bag.arrow.batches import BATCH_BYTES, BATCH_ROWS, TopicBatches, batches_of, to_arrow
from rosproto.bag.arrow.schema import schema_of

__all__ = ["BATCH_BYTES", "BATCH_ROWS", "TopicBatches", "batches_of", "schema_of", "to_arrow"]
