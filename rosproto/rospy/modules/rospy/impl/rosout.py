"""rospy.impl.rosout: log lines as messages on /rosout."""

import logging
import traceback

from rosgraph_msgs.msg import Log

from .. import core, names, rostime, topics

_rosout_pub = None
_with_topics = True
_rospy_to_logging_levels = _LEVELS = {
    1: logging.DEBUG,
    2: logging.INFO,
    4: logging.WARNING,
    8: logging.ERROR,
    16: logging.CRITICAL,
}
_logging_to_rospy_levels = _ROS_LEVELS = {levelno: level for level, levelno in _LEVELS.items()}


def init_rosout():
    """Publish /rosout."""
    global _rosout_pub, _with_topics
    from rospy import client

    try:
        if _rosout_pub is None:
            _rosout_pub = topics.Publisher("/rosout", Log, latch=True, queue_size=100)
            _with_topics = not client.get_param("/rosout_disable_topics_generation", False)
        return True
    except Exception as error:
        logging.getLogger("rospy.rosout").error(
            "Unable to initialize /rosout: %s\n%s", error, traceback.format_exc()
        )
        return False


class RosOutHandler(logging.Handler):
    """Publishes log records."""

    def __init__(self):
        super().__init__()
        self._busy = False

    def emit(self, record):
        """Publish one record; a record logged while doing so is not published."""
        if self._busy or _rosout_pub is None:
            return
        self._busy = True
        try:
            _rosout_pub.publish(self._message(record))
        except Exception as error:
            logging.getLogger("rospy.rosout").error(
                "Unable to report rosout: %s\n%s", error, traceback.format_exc()
            )
        finally:
            self._busy = False

    def _message(self, record):
        message = Log(
            level=_ROS_LEVELS.get(record.levelno, 2),
            name=names.get_caller_id(),
            msg=self.format(record),
            file=record.filename,
            line=record.lineno,
            function=core.function_of(record),
        )
        if _with_topics:
            message.topics = sorted(topics.manager.get_topics())
        message.header.stamp = rostime.Time.now()
        return message


def load_rosout_handlers(level):
    """Publish log records, from `level` on if given."""
    logger = logging.getLogger("rosout")
    logger.addHandler(RosOutHandler())
    if level is not None:
        logger.setLevel(_LEVELS[level])
