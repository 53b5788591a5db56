"""rosbag's errors; tracebacks name them as part of rosbag.bag."""

from contextlib import contextmanager

from rosproto.errors import BagError


class ROSBagException(Exception):
    """A bag cannot be used."""

    def __init__(self, value=None):
        self.value = value
        self.args = (value,)

    def __str__(self):
        return self.value


class ROSBagFormatException(ROSBagException):
    """It is not a bag, or it is damaged."""


class ROSBagUnindexedException(ROSBagException):
    """It has no table of contents."""

    def __init__(self, *args):
        super().__init__("Unindexed bag")


class ROSBagEncryptNotSupportedException(ROSBagException):
    """It is encrypted, and this layer cannot decrypt it."""


class ROSBagEncryptException(ROSBagException):
    """Encrypting or decrypting failed."""


for _error in (ROSBagException, *ROSBagException.__subclasses__()):
    _error.__module__ = "rosbag.bag"


@contextmanager
def rosbag_errors():
    """Raise rosbag's errors for rosproto's, or the operating system's own error if there is one."""
    try:
        yield
    except BagError as error:
        if isinstance(error.__cause__, OSError):
            raise error.__cause__ from None
        if error.reason.startswith("the bag is encrypted"):
            raise ROSBagEncryptNotSupportedException(str(error)) from error
        raise ROSBagFormatException(str(error)) from error
