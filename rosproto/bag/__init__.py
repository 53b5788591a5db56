"""Read and write bags of format 2.0; unfinished and damaged bags can be read, too."""

from rosproto.bag.bag_file import BagLimits
from rosproto.bag.messages import RawMessage
from rosproto.bag.opening import create_bag, open_bag
from rosproto.bag.partitioning import Partition, partitions
from rosproto.bag.reader import BagReader, Compression, TopicInfo
from rosproto.bag.records import ChunkInfo, Connection
from rosproto.bag.repair import Report, recover, reindex
from rosproto.bag.writer import BagWriter

__all__ = [
    "BagLimits",
    "BagReader",
    "BagWriter",
    "ChunkInfo",
    "Compression",
    "Connection",
    "Partition",
    "RawMessage",
    "Report",
    "TopicInfo",
    "create_bag",
    "open_bag",
    "partitions",
    "recover",
    "reindex",
]
