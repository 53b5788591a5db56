"""rosbag: bag files."""

from .bag import Bag, Compression, ROSBagException, ROSBagFormatException, ROSBagUnindexedException

__all__ = ["Bag", "Compression", "ROSBagException", "ROSBagFormatException", "ROSBagUnindexedException"]
