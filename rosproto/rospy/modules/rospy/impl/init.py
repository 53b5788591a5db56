"""rospy.impl.init: the node behind the module."""

import logging
import os
import threading
import time

import rosgraph
from roscpp.msg import Logger
from roscpp.srv import GetLoggers, GetLoggersResponse, SetLoggerLevel, SetLoggerLevelResponse
from rosgraph.roslogging import RosStreamHandler

from rosproto.errors import RosError
from rosproto.node.options import host_names
from rosproto.rospy.host import ProgramNode
from rosproto.transport.own_address import host_from_environment

from .. import core, names, topics
from ..exceptions import ROSInitException
from ..rostime import wallsleep
from ..service import ServiceException
from .tcpros_service import Service, attach

node = None
_DEBUGGED = {10: "DEBUG", 20: "INFO", 30: "WARN", 40: "ERROR", 50: "FATAL"}


def start_node(resolved_name, port=0, tcpros_port=0):
    """Open the node, waiting for the master as long as it takes; then open the topics made earlier.

    Raises:
        ROSInitException: It was shut down meanwhile.
    """
    global node
    names.set_caller_id(resolved_name)
    uri = rosgraph.get_master_uri()
    opened = None
    warned = False
    while opened is None and not core.is_shutdown():
        try:
            opened = ProgramNode(
                resolved_name,
                master_uri=uri,
                host=host_from_environment(os.environ, names.get_mappings()),
                port=port,
                tcpros_port=tcpros_port,
                resolve=host_names(),
                on_shutdown_request=_shutdown_requested,
                on_refused=_refused,
            )
        except (RosError, OSError):
            if not warned:
                _tell(uri)
                warned = True
            wallsleep(0.2)
    if opened is None:
        raise ROSInitException("Failed to initialize time. Please check logs for additional details")
    node = opened
    core.set_node_uri(node.uri)
    core.add_shutdown_hook(lambda reason: node.close())
    topics.manager.attach(node)
    attach(node)
    return node


def _tell(uri):
    text = "master may not be running yet. Will keep trying."
    if topics.manager.get_topics():
        core.logerr("Unable to immediately register with master node [%s]: %s" % (uri, text))
    else:
        print("Unable to register with master node [%s]: %s" % (uri, text))


def _shutdown_requested(reason):
    """The master or a tool ends this node; `reason` is "shutdown by CALLER at ADDRESS: TEXT"."""
    caller, _, text = reason.partition(": ")
    print("shutdown request: %s" % text if text else "shutdown requst")
    core.signal_shutdown("external shutdown request from [%s]: [%s]" % (caller, text))


def _refused(text):
    """Report a subscriber or service client with another definition."""
    if not core.is_shutdown_requested():
        core.logwarn(text)


def serve_loggers():
    """Provide the services that read and set this process's log levels.

    Runs later, in a thread: it takes as long as the rest of init_node, and programs do not wait for it.
    """
    threading.Thread(target=_serve_loggers, name="rosproto:logger services", daemon=True).start()


def _serve_loggers():
    time.sleep(0.1)
    try:
        Service("~get_loggers", GetLoggers, _get_loggers)
        Service("~set_logger_level", SetLoggerLevel, _set_logger_level)
    except (RosError, OSError, ServiceException) as error:
        if not core.is_shutdown():
            core.rospywarn("the logger services are not provided: %s", error)


def _get_loggers(request):
    def level(name):
        return _DEBUGGED.get(logging.getLogger(name).getEffectiveLevel(), "INFO")

    found = list(logging.Logger.manager.loggerDict)
    return GetLoggersResponse([Logger(name, level(name)) for name in found])


def _set_logger_level(request):
    levels = {name: level for level, name in _DEBUGGED.items()}
    level = levels.get(request.level.upper())
    if level is None:
        logging.getLogger("rospy").error("Bad logging level: %s", request.level)
    else:
        logging.getLogger(request.logger).setLevel(level)
    return SetLoggerLevelResponse()
