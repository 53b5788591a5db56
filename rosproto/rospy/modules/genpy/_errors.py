"""genpy's errors; tracebacks name them as part of genpy.message."""


class MessageException(Exception):
    """Base of the others."""


class DeserializationError(MessageException):
    """Bytes and definition disagree."""


class SerializationError(MessageException):
    """A value does not fit its field."""


for _error in (MessageException, DeserializationError, SerializationError):
    _error.__module__ = "genpy.message"
