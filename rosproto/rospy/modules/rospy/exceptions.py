"""rospy's exceptions."""


class ROSException(Exception):
    """Base of the exceptions that programs see."""


class ROSSerializationException(ROSException):
    """A message cannot be encoded."""


class ROSInitException(ROSException):
    """The node is not initialized, or cannot be initialized."""


class ROSInterruptException(ROSException, KeyboardInterrupt):
    """The node was shut down while something waited."""


class ROSTimeMovedBackwardsException(ROSInterruptException):
    """Simulated time jumped back while something slept.

    Attributes:
        time: How far, in seconds.
    """

    def __init__(self, time):
        self.time = time
        super().__init__("ROS time moved backwards")


class ROSInternalException(Exception):
    """Base of the library's own errors."""


class TransportException(ROSInternalException):
    """A connection failed."""


class TransportTerminated(TransportException):
    """A connection broke."""


class TransportInitError(TransportException):
    """A connection could not be made."""
