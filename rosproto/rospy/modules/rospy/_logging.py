"""The logging functions: `loginfo` and the like; also once, throttled, or only when the text changes."""

import logging
import sys
import threading

_FRAMES = 3  # from the logger's method up to the program: _log, the function, its caller
_last_times = {}
_last_texts = {}
_said = set()


def _log(level, msg, args, kwargs, period=None, identical=False, once=False):
    logger = logging.getLogger("rosout")
    name = kwargs.pop("logger_name", None)
    if name:
        logger = logger.getChild(name)
    if once or identical or period is not None:
        frame = sys._getframe(2)
        caller = (frame.f_code.co_filename, frame.f_lineno, frame.f_lasti)
        if not _is_due(caller, msg, period, identical, once):
            return
    kwargs.setdefault("stacklevel", _FRAMES)
    _caller.frame = sys._getframe(2)
    try:
        logger.log(level, msg, *args, **kwargs)
    finally:
        _caller.frame = None


_caller = threading.local()


def function_of(record):
    """Name of the function that logged, with its class's when it is a method, as rospy gives it."""
    frame = getattr(_caller, "frame", None)
    if frame is None or frame.f_code.co_name != record.funcName or "self" not in frame.f_locals:
        return record.funcName
    return "%s.%s" % (type(frame.f_locals["self"]).__name__, record.funcName)


def _is_due(caller, msg, period, identical, once):
    if once:
        new = caller not in _said
        _said.add(caller)
        return new
    due = _period_is_over(caller, period)
    if not identical:
        return due
    new = _last_texts.get(caller) != msg
    _last_texts[caller] = msg
    return new or due


def _period_is_over(caller, period):
    from .rostime import Duration, Time

    now, last = Time.now(), _last_times.get(caller)
    if last is None or last > now or now - last > Duration(period):
        _last_times[caller] = now
        return True
    return False


def logdebug(msg, *args, **kwargs):
    """Log at the level DEBUG."""
    _log(logging.DEBUG, msg, args, kwargs)


def loginfo(msg, *args, **kwargs):
    """Log at the level INFO."""
    _log(logging.INFO, msg, args, kwargs)


def logwarn(msg, *args, **kwargs):
    """Log at the level WARN."""
    _log(logging.WARNING, msg, args, kwargs)


def logerr(msg, *args, **kwargs):
    """Log at the level ERROR."""
    _log(logging.ERROR, msg, args, kwargs)


def logfatal(msg, *args, **kwargs):
    """Log at the level FATAL."""
    _log(logging.CRITICAL, msg, args, kwargs)


logout = loginfo
logerror = logerr


def _variants(name, level):
    def throttle(period, msg, *args, **kwargs):
        _log(level, msg, args, kwargs, period=period or None)

    def throttle_identical(period, msg, *args, **kwargs):
        _log(level, msg, args, kwargs, period=period, identical=True)

    def once(msg, *args, **kwargs):
        _log(level, msg, args, kwargs, once=True)

    texts = {
        "throttle": "at most every `period` seconds",
        "throttle_identical": "unless it is the same text as before, within `period` seconds",
        "once": "only the first time",
    }
    for function in (throttle, throttle_identical, once):
        kind = function.__name__
        function.__name__ = function.__qualname__ = "%s_%s" % (name, kind)
        function.__doc__ = "As `%s`, from one place %s." % (name, texts[kind])
        globals()[function.__name__] = function


for _name, _level in (
    ("logdebug", logging.DEBUG),
    ("loginfo", logging.INFO),
    ("logwarn", logging.WARNING),
    ("logerr", logging.ERROR),
    ("logfatal", logging.CRITICAL),
):
    _variants(_name, _level)
