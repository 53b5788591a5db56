"""rosbag: bag files."""

from . import bag
from .bag import *  # noqa: F403

__all__ = [name for name in bag.__all__ if not name.startswith("BagMessage")]
