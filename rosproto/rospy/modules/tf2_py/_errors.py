"""tf2's exceptions; their names in tracebacks are those of its C module, tf2."""


class TransformException(Exception):
    """A transform cannot be had."""


class ConnectivityException(TransformException):
    """Both frames are known, but not connected."""


class LookupException(TransformException):
    """A frame is unknown."""


class ExtrapolationException(TransformException):
    """It is known, but not for that time."""


class InvalidArgumentException(TransformException):
    """An argument makes no sense."""


class TimeoutException(TransformException):
    """It took too long."""


for _error in (TransformException, *TransformException.__subclasses__()):
    _error.__module__ = "tf2"
