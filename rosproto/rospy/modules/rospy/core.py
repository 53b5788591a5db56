"""rospy.core: the log functions, and the start and shutdown of the node."""

import atexit
import functools
import logging
import os
import signal
import sys
import threading
import traceback
import warnings
from urllib.parse import urlparse

from rosgraph import roslogging

from rosproto.rospy.master import call

from .exceptions import *  # programs name the exceptions by this module too
from .exceptions import ROSException
from .impl.validators import ParameterInvalid
from .names import *
from .names import get_caller_id, get_mappings, get_name, get_namespace, resolve_name
from .rostime import Duration, Time

MASTER_NAME = "master"
ROSRPC = "rosrpc://"

logger = _logger = logging.getLogger("rospy.core")  # `_logger` is rospy's name for it


def parse_rosrpc_uri(uri):
    """Host and port of rosrpc://host:port."""
    if not uri.startswith(ROSRPC):
        raise ParameterInvalid("Invalid protocol for ROS service URL: %s" % uri)
    try:
        host, port = uri[len(ROSRPC) :].partition("/")[0].split(":")
        return host, int(port)
    except ValueError:
        raise ParameterInvalid("ROS service URL is invalid: %s" % uri) from None


# -- log ----------------------------------------------------------------------------------------------------

_FRAMES = 3  # from the logger's method up to the program: _log, the function, its caller
_last_times = {}
_last_texts = {}
_said = set()
_caller = threading.local()


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
    now, last = Time.now(), _last_times.get(caller)
    if last is None or last > now or now - last > Duration(period):
        _last_times[caller] = now
        return True
    return False


def _functions(name, level):
    """(plain, once, throttled, throttled unless the text is another one)."""

    def log(msg, *args, **kwargs):
        _log(level, msg, args, kwargs)

    def once(msg, *args, **kwargs):
        _log(level, msg, args, kwargs, once=True)

    def throttle(period, msg, *args, **kwargs):
        _log(level, msg, args, kwargs, period=period or None)

    def throttle_identical(period, msg, *args, **kwargs):
        _log(level, msg, args, kwargs, period=period, identical=True)

    for suffix, function, when in (
        ("", log, "always"),
        ("_once", once, "from one place only the first time"),
        ("_throttle", throttle, "from one place at most every `period` seconds"),
        ("_throttle_identical", throttle_identical, "from one place a text anew after `period` seconds"),
    ):
        function.__name__ = function.__qualname__ = name + suffix
        function.__doc__ = "Log at this level, %s." % when
    return log, once, throttle, throttle_identical


logdebug, logdebug_once, logdebug_throttle, logdebug_throttle_identical = _functions(
    "logdebug", logging.DEBUG
)
loginfo, loginfo_once, loginfo_throttle, loginfo_throttle_identical = _functions("loginfo", logging.INFO)
logwarn, logwarn_once, logwarn_throttle, logwarn_throttle_identical = _functions("logwarn", logging.WARNING)
logerr, logerr_once, logerr_throttle, logerr_throttle_identical = _functions("logerr", logging.ERROR)
logfatal, logfatal_once, logfatal_throttle, logfatal_throttle_identical = _functions(
    "logfatal", logging.CRITICAL
)
logout = loginfo
logerror = logerr

_internal = logging.getLogger("rospy.internal")
rospydebug = _internal.debug
rospyinfo = _internal.info
rospyerr = _internal.error
rospywarn = _internal.warning

_log_filename = None


def configure_logging(node_name, level=logging.INFO):
    """Send log lines to the terminal and to the node's log file."""
    global _log_filename
    given = get_mappings().get("__log")
    filename = os.path.abspath(given) if given else node_name.replace("/", "_").lstrip("_") + ".log"
    if filename == ".log":
        raise ROSException("invalid configure_logging parameter: %s" % node_name)
    _log_filename = roslogging.configure_logging("rospy", level, filename=filename)


# -- environment --------------------------------------------------------------------------------------------

_uri = None


def get_node_uri():
    """URI of this node's slave API; None before there is one."""
    return _uri


def set_node_uri(uri):
    """Set that URI."""
    global _uri
    _uri = uri


def get_ros_root(required=False, env=None):
    """ROS_ROOT of the environment."""
    warnings.warn("Call to deprecated function get_ros_root.", DeprecationWarning, stacklevel=2)
    root = (os.environ if env is None else env).get("ROS_ROOT")
    if required and not root:
        raise ROSException("ROS_ROOT is not set")
    return root


def xmlrpcapi(uri, cache=True):
    """The xmlrpc.client.ServerProxy of a master or node, for any thread; None when `uri` is not a URI."""
    parts = urlparse(uri) if uri else None
    return _proxy(uri) if parts and parts.scheme and parts.netloc else None


@functools.cache
def _proxy(uri):
    """A ServerProxy that calls through our client: usable from any thread, and with a time-out."""
    from xmlrpc.client import ServerProxy

    class Proxy(ServerProxy):
        def _ServerProxy__request(self, methodname, params):  # all calls go through this
            return call(uri, methodname, *params)

    Proxy.__name__ = Proxy.__qualname__ = "ServerProxy"
    return Proxy(uri)


# -- start and shutdown -------------------------------------------------------------------------------------

_client_ready = False
_shutdown_flag = False
_in_shutdown = False
_shutdown_lock = threading.RLock()
_client_shutdown_hooks = []
_preshutdown_hooks = []
_shutdown_hooks = []
_signalChain = {}


def is_initialized():
    """True when init_node has finished."""
    return _client_ready


def set_initialized(initialized):
    """Note that init_node has finished."""
    global _client_ready
    _client_ready = initialized


def is_shutdown():
    """True when the node is shut down."""
    return _shutdown_flag


def is_shutdown_requested():
    """True when it is being shut down: the program's hooks may still run."""
    return _in_shutdown


def _add_hook(hook, hooks, *reason):
    if not callable(hook):
        raise TypeError("shutdown hook [%s] must be a function or callable object: %s" % (hook, type(hook)))
    if _shutdown_flag:
        logger.warning("add_shutdown_hook called after shutdown")
        hook(*reason)
        return
    with _shutdown_lock:
        hooks.append(hook)


def add_client_shutdown_hook(h):
    """Call `h()` when shutdown begins; publishing still works then."""
    _add_hook(h, _client_shutdown_hooks)


def add_preshutdown_hook(h):
    """Call `h(reason)` after the client hooks, before the node counts as shut down."""
    _add_hook(h, _preshutdown_hooks, "already shutdown")


def add_shutdown_hook(h):
    """Call `h(reason)` when the node counts as shut down."""
    _add_hook(h, _shutdown_hooks, "already shutdown")


def signal_shutdown(reason):
    """Shut the node down: run the program's hooks, then close everything. Returns when done."""
    global _shutdown_flag, _in_shutdown
    logger.info("signal_shutdown [%s]", reason)
    if _shutdown_flag or _in_shutdown:
        return
    with _shutdown_lock:
        if _shutdown_flag or _in_shutdown:
            return
        _in_shutdown = True
        _run_hooks(_client_shutdown_hooks)
        _run_hooks(_preshutdown_hooks, reason)
        _shutdown_flag = True
        for hook in _shutdown_hooks:
            try:
                hook(reason)
            except Exception as error:
                sys.stderr.write("signal_shutdown hook error[%s]\n" % error)
        del _shutdown_hooks[:]


def _run_hooks(hooks, *reason):
    for hook in list(hooks):
        try:
            hook(*reason)
        except BaseException:  # after a hook that calls sys.exit, the others still run
            traceback.print_exc()
    del hooks[:]


def _ros_atexit():
    signal_shutdown("atexit")


atexit.register(_ros_atexit)


class _Uninterrupted:
    """A block of the main thread that no signal handler interrupts; the signal is handled after it.

    The handler runs hooks that publish, and closes the node, in the main thread: it must not do that while
    the same thread holds one of the node's locks.
    """

    def __init__(self):
        self._depth = 0
        self._pending = None

    def __enter__(self):
        if threading.current_thread() is threading.main_thread():
            self._depth += 1

    def __exit__(self, *exc):
        if threading.current_thread() is threading.main_thread():
            self._depth -= 1
            if self._pending is not None and not self._depth:
                pending, self._pending = self._pending, None
                _handle(*pending)

    def defer(self, number, frame):
        """Keep a signal for later; False when it can be handled now."""
        if self._depth:
            self._pending = (number, frame)
        return bool(self._depth)


uninterrupted = _Uninterrupted()


def _ros_signal(number, frame):
    if not uninterrupted.defer(number, frame):
        _handle(number, frame)


def _handle(number, frame):
    signal_shutdown("signal-" + str(number))
    before = _signalChain.get(number)
    if callable(before):
        try:
            before(number, frame)
        except KeyboardInterrupt:
            pass  # Python's own handler; the shutdown flag tells the program


def register_signals():
    """Shut down on SIGTERM and SIGINT; only from the main thread."""
    numbers = [signal.SIGTERM, signal.SIGINT]
    if hasattr(signal, "SIGBREAK"):  # Windows: Ctrl-Break, the one that can be sent to a process group
        numbers.append(signal.SIGBREAK)
    for number in numbers:
        _signalChain[number] = signal.signal(number, _ros_signal)
