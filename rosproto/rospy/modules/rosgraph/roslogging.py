"""Log handlers: INFO and below to stdout, the rest to stderr, all to the node's log file."""

import logging
import os
import re
import sys
import time
from logging.handlers import RotatingFileHandler

_NAMES = {
    "DEBUG": ("DEBUG", "\033[32m"),
    "INFO": ("INFO", None),
    "WARNING": ("WARN", "\033[33m"),
    "ERROR": ("ERROR", "\033[31m"),
    "CRITICAL": ("FATAL", "\033[31m"),
}
_RESET = "\033[0m"
_plain = logging.Formatter()
MAX_LOG_BYTES = 50000000  # of a log file; the previous file is kept


class LoggingException(Exception):
    """Log files cannot be written."""


class RospyLogger(logging.Logger):
    """rospy's class of loggers, which programs patch for new Pythons; here they are Python's own."""


class RosStreamHandler(logging.Handler):
    """Writes `[INFO] [1234.567890]: text`, or the format of ROSCONSOLE_FORMAT."""

    def __init__(self, colorize=True, stdout=None, stderr=None):
        super().__init__()
        self._stdout = stdout or sys.stdout
        self._stderr = stderr or sys.stderr
        self._colorize = colorize

    def emit(self, record):
        """Write one record."""
        from rospy.core import function_of
        from rospy.names import get_name

        level, color = _NAMES.get(record.levelname, (record.levelname, None))
        text = os.environ.get("ROSCONSOLE_FORMAT", "[${severity}] [${time}]: ${message}")
        # The message first, and so keywords in it are replaced, too: as in rospy.
        for key, value in (
            ("severity", level),
            ("message", _plain.format(record)),
            ("walltime", "%f" % time.time()),
            ("thread", record.thread),
            ("logger", record.name),
            ("file", record.pathname),
            ("line", record.lineno),
            ("function", function_of(record)),
            ("node", get_name()),
            ("time", "%f" % time.time() + _simulated()),
        ):
            text = text.replace("${%s}" % key, str(value))
        text = re.sub(r"\$\{walltime:(.*?)\}", lambda found: time.strftime(found[1]), text)
        text = re.sub(r"\$\{time:(.*?)\}", lambda found: time.strftime(found[1]) + _simulated(), text)
        stream = self._stdout if record.levelno < logging.WARNING else self._stderr
        if self._colorize and color and hasattr(stream, "isatty") and stream.isatty():
            stream.write(color + text + "\n" + _RESET)
        else:
            stream.write(text + "\n")


def _simulated():
    """ ", seconds" of simulated time; "" when there is none."""
    from rospy.rostime import get_time, is_wallclock

    return "" if is_wallclock() else ", %f" % get_time()


class _LogFile(RotatingFileHandler):
    """The node's log file, opened with the first record. When it cannot be written, records are dropped."""

    def __init__(self, path):
        super().__init__(path, "a", MAX_LOG_BYTES, 1, encoding="utf-8", delay=True, errors="backslashreplace")
        self.setFormatter(logging.Formatter("[%(name)s][%(levelname)s] %(asctime)s: %(message)s"))

    def handleError(self, record):
        """Say once that it cannot be written."""
        error = sys.exc_info()[1]
        if not isinstance(error, OSError):
            super().handleError(record)
            return
        self.setLevel(logging.CRITICAL + 1)
        sys.stderr.write("WARNING: cannot write the log file [%s]: %s\n" % (self.baseFilename, error))


def configure_logging(logname, level=logging.INFO, filename=None, env=None):
    """Set up Python's logging as ROS does; the name of the log file.

    The root logger gets the file and the level INFO, "rosout" the terminal.
    """
    env = os.environ if env is None else env
    home = env.get("ROS_HOME") or os.path.join(os.path.expanduser("~"), ".ros")
    folder = env.get("ROS_LOG_DIR") or os.path.join(home, "log")
    path = os.path.join(folder, filename or "%s-%s.log" % (logname or "unknown", os.getpid()))
    os.environ["ROS_LOG_FILENAME"] = path
    usual = [os.path.join(home, "config", "python_logging." + kind) for kind in ("conf", "yaml")]
    config = env.get("ROS_PYTHON_LOG_CONFIG_FILE") or next(filter(os.path.isfile, usual), None)
    if config:
        _configure_from(config, logname, path)
    else:
        _configure_as_usual(path)
    return path


def _configure_from(config, logname, path):
    if not os.path.isfile(config):
        sys.stderr.write("WARNING: cannot load logging configuration file, logging is disabled\n")
        logging.getLogger(logname).setLevel(logging.CRITICAL)
        return
    os.makedirs(os.path.dirname(path), exist_ok=True)  # the configuration opens the file
    from logging.config import dictConfig, fileConfig

    if not config.endswith((".yaml", ".yml")):
        fileConfig(config, disable_existing_loggers=False)
        return
    from yaml import safe_load

    with open(config, encoding="utf-8") as file:
        settings = safe_load(file)
    settings.setdefault("version", 1)
    dictConfig(settings)


def _configure_as_usual(path):
    try:
        os.makedirs(os.path.dirname(path), exist_ok=True)
    except OSError:
        pass  # the file says why it cannot be written
    for name, handler in ((None, _LogFile(path)), ("rosout", RosStreamHandler())):
        logger = logging.getLogger(name)
        for old in list(logger.handlers):
            logger.removeHandler(old)
        logger.setLevel(logging.INFO)
        logger.addHandler(handler)
