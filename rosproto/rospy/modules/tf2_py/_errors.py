"""tf2's exceptions and their texts; the names in tracebacks are those of its C module, tf2."""

from rosproto.tf.tree import Gap, seconds


class TransformException(Exception):
    """A transform is not available."""


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


def error_of(no_way, target, source):
    """The exception for a `Gap` or `Unconnected` of the tree."""
    if isinstance(no_way, Gap):
        return ExtrapolationException(
            "%s, when looking up transform from frame [%s] to frame [%s]" % (_why(no_way), source, target)
        )
    return ConnectivityException(
        "Could not find a connection between '%s' and '%s' because they are not part of the same tree."
        "Tf has two or more unconnected trees." % (target, source)
    )


def _why(gap):
    stamp, known = gap.stamp, gap.history
    if not known:  # cleared: tf2 gives no reason
        return ""
    if len(known) == 1:
        return (
            "Lookup would require extrapolation at time %.09f, but only time %.09f is in the buffer"
            % (seconds(stamp), seconds(known.earliest))
        )[:115]  # the size of tf2's buffer for it
    if stamp > known.newest.stamp:
        return _beyond(stamp, known.newest.stamp, "future", "latest")
    return _beyond(stamp, known.earliest, "past", "earliest")


def _beyond(asked, known, where, which):
    return (
        "Lookup would require extrapolation %.09fs into the %s.  Requested time %.09f but the %s data is at"
        " time %.09f" % (seconds(abs(asked - known)), where, seconds(asked), which, seconds(known))
    )
