"""rosbag's errors; tracebacks name them as those of rosbag.bag."""


class ROSBagException(Exception):
    """A bag cannot be used."""

    def __init__(self, value=None):
        self.value = value
        self.args = (value,)

    def __str__(self):
        return self.value


class ROSBagFormatException(ROSBagException):
    """It is no bag, or damaged."""


class ROSBagUnindexedException(ROSBagException):
    """It has no table of contents."""

    def __init__(self, *args):
        super().__init__("Unindexed bag")


for _error in (ROSBagException, ROSBagFormatException, ROSBagUnindexedException):
    _error.__module__ = "rosbag.bag"
