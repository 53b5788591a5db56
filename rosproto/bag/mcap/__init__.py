"""MCAP files with the interface of `BagReader` and `BagWriter`; needs the package mcap (the extra `mcap`)."""

from rosproto.bag.mcap.reader import MCAP_MAGIC, McapReader
from rosproto.bag.mcap.writer import McapWriter

__all__ = ["MCAP_MAGIC", "McapReader", "McapWriter"]
