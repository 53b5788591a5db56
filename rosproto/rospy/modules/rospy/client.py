"""rospy.client: init_node, spin, parameters, and other things a program calls."""

import logging
import os
import sys
import threading
import time
import warnings

import rosgraph
import rosgraph.names
import roslib

from . import core, names, rostime
from .core import add_client_shutdown_hook as on_shutdown
from .core import logdebug, logerr, loginfo, logwarn
from .exceptions import ROSException, ROSInitException, ROSInterruptException
from .impl import init, rosout, simtime
from .msproxy import MasterProxy
from .rostime import Duration
from .topics import Subscriber

DEBUG, INFO, WARN, ERROR, FATAL = 1, 2, 4, 8, 16
TIMEOUT_READY = 15.0


def myargv(argv=None):
    """sys.argv without the arguments meant for ROS."""
    return [word for word in (sys.argv if argv is None else argv) if not rosgraph.names.is_legal_remap(word)]


def load_command_line_node_params(argv):
    """The `_name:=value` of a command line, the values typed as YAML.

    Raises:
        ROSInitException: A value is not valid YAML.
    """
    found = {}
    try:
        for word in argv:
            if not rosgraph.names.is_legal_remap(word):
                continue
            name, value = (part.strip() for part in word.split(rosgraph.names.REMAP))
            if name and value and len(name) > 1 and name[0] == "_" and name[1] != "_":
                found[name[1:]] = _typed(value)
    except Exception as error:
        raise ROSInitException("invalid command-line parameters: %s" % (str(error))) from None
    return found


def _typed(text):
    try:
        from yaml import safe_load
    except ImportError:
        from rosproto.typed_values import parse_value

        return parse_value(text)
    return safe_load(text)


def spin():
    """Wait until the node is shut down.

    Raises:
        ROSInitException: There is no node.
    """
    if not core.is_initialized():
        raise ROSInitException("client code must call rospy.init_node() first")
    core.logdebug(
        "node[%s, %s] entering spin(), pid[%s]", core.get_caller_id(), core.get_node_uri(), os.getpid()
    )
    try:
        while not core.is_shutdown():
            # As in rospy: after a signal, the main thread waits this long for other threads.
            time.sleep(0.5)
    except KeyboardInterrupt:
        core.logdebug("keyboard interrupt, shutting down")
        core.signal_shutdown("keyboard interrupt")


_init_node_args = None


def init_node(
    name,
    argv=None,
    anonymous=False,
    log_level=None,
    disable_rostime=False,
    disable_rosout=False,
    disable_signals=False,
    xmlrpc_port=0,
    tcpros_port=0,
):
    """Make this process a node; waits for the master.

    Raises:
        ROSInitException: It was shut down meanwhile, or the time cannot be initialized.
        ROSException: It was called before with other arguments.
        ValueError: The name is empty or has a namespace.
    """
    global _init_node_args
    if argv is None:
        argv = sys.argv
    else:
        names.reload_mappings(argv)
    if not name:
        raise ValueError("name must not be empty")
    if rosgraph.names.SEP in name:
        raise ValueError("namespaces are not allowed in node names")
    arguments = (name, argv, anonymous, log_level, disable_rostime, disable_signals)
    if _init_node_args is not None:
        if arguments != _init_node_args:
            raise ROSException(
                "rospy.init_node() has already been called with different arguments: " + str(_init_node_args)
            )
        return
    disable_signals = disable_signals or roslib.is_interactive()
    _init_node_args = (name, argv, anonymous, log_level, disable_rostime, disable_signals)
    if not disable_signals:
        core.register_signals()
    resolved = _node_name(name, anonymous)
    core.configure_logging(resolved)
    names.initialize_mappings(resolved)
    logging.getLogger("rospy.client").info("init_node, name[%s], pid[%s]", resolved, os.getpid())
    init.start_node(resolved, port=xmlrpc_port, tcpros_port=tcpros_port)
    if core.is_shutdown():
        raise ROSInitException("init_node interrupted before it could complete")
    for key, value in load_command_line_node_params(argv).items():
        core.logdebug("setting param %s to %s", key, value)
        set_param(rosgraph.names.PRIV_NAME + key, value)
    core.set_initialized(True)
    if not disable_rosout:
        rosout.init_rosout()
        rosout.load_rosout_handlers(log_level)
    if disable_rostime:
        rostime.set_rostime_initialized(True)
    elif not simtime.init_simtime():
        raise ROSInitException("Failed to initialize time. Please check logs for additional details")
    core.logdebug("init_node, name[%s], pid[%s]", resolved, os.getpid())
    init.serve_loggers()


def _node_name(name, anonymous):
    """The global name; `__name:=` of the command line wins, and then it is not anonymous."""
    mappings = names.get_mappings()
    if "__name" in mappings:
        name = mappings["__name"]
        if anonymous:
            core.logdebug(
                "[%s] WARNING: due to __name setting, anonymous setting is being changed to false", name
            )
            anonymous = False
    if anonymous:
        name = "%s_%s_%s" % (name, os.getpid(), int(time.time() * 1000))
    if not rosgraph.names.is_legal_base_name(name):
        warnings.warn(
            "'%s' is not a legal ROS base name. This may cause problems with other ROS tools." % name,
            stacklevel=3,
        )
    return rosgraph.names.resolve_name(name, core.get_caller_id())


_master_proxy = None
_master_proxy_lock = threading.Lock()


def get_master(env=None):
    """The master, by its API: `get_master().getUri()` and so on, raw replies."""
    global _master_proxy
    with _master_proxy_lock:
        if _master_proxy is None:
            _master_proxy = MasterProxy(rosgraph.get_master_uri())
        return _master_proxy


def get_published_topics(namespace="/"):
    """Return [[topic, type], ...] of the topics published below a namespace."""
    code, text, value = get_master().getPublishedTopics(namespace)
    if code != 1:
        raise ROSException("unable to get published topics: %s" % text)
    return value


def wait_for_message(topic, topic_type, timeout=None):
    """Subscribe, take one message, unsubscribe.

    Raises:
        ROSException: None arrived in time.
        ROSInterruptException: The node was shut down meanwhile.
    """
    if isinstance(timeout, Duration):
        timeout = timeout.to_sec()
    received = []
    subscriber = Subscriber(topic, topic_type, received.append)
    try:
        end = None if timeout is None else time.monotonic() + timeout
        while not core.is_shutdown() and not received:
            time.sleep(0.01)
            if end is not None and time.monotonic() >= end:
                # As in rospy: a message that arrived within the last pause is too late.
                raise ROSException("timeout exceeded while waiting for message on topic %s" % topic)
    finally:
        subscriber.unregister()
    if core.is_shutdown():
        raise ROSInterruptException("rospy shutdown")
    return received[0]


# -- parameters ---------------------------------------------------------------------------------------------


_Unspecified = object  # rospy's name for it
_unspecified = _Unspecified()


def get_param(param_name, default=_unspecified):
    """Value of a parameter, a dict for a namespace.

    Raises:
        KeyError: It is not set, and there is no default.
    """
    try:
        return get_master()[param_name]
    except KeyError:
        if default is not _unspecified:
            return default
        raise


def get_param_cached(param_name, default=_unspecified):
    """As `get_param`; the value is fetched once and then kept up to date by the master."""
    try:
        return get_master().get_param_cached(param_name)
    except KeyError:
        if default is not _unspecified:
            return default
        raise


def get_param_names():
    """Names of all parameters."""
    code, text, value = get_master().getParamNames()
    if code != 1:
        raise ROSException("Unable to retrieve parameter names: %s" % text)
    return value


def set_param(param_name, param_value):
    """Set a parameter; a dict replaces the namespace."""
    names.warn_if_illegal(param_name, stacklevel=2)
    get_master()[param_name] = param_value


def search_param(param_name):
    """Name of the parameter found upwards from this node's namespace; None when there is none."""
    return get_master().search_param(param_name)


def delete_param(param_name):
    """Delete a parameter.

    Raises:
        KeyError: It is not set.
    """
    del get_master()[param_name]


def has_param(param_name):
    """True when it is set."""
    return param_name in get_master()
