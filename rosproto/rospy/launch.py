"""Runs a program file as Python itself would, with this layer's modules importable.

`__main__` with an absolute `__file__`, `sys.argv`, `sys.path[0]`, tracebacks and exit codes are as with
`python program.py`.
"""

from __future__ import annotations

import atexit
import builtins
import logging
import os
import signal
import sys
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from importlib.machinery import SourceFileLoader
from types import ModuleType, TracebackType
from typing import TYPE_CHECKING, NoReturn

from rosproto.errors import RosError
from rosproto.profile import remembered
from rosproto.rospy.finder import MSG_PATH, serve
from rosproto.startup import raise_on_interrupt

if TYPE_CHECKING:
    import argparse


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options, the program, and the program's own arguments."""
    import argparse

    class Moved(argparse.Action):
        def __call__(self, parser: argparse.ArgumentParser, *given: object) -> NoReturn:
            parser.exit(2, f"{parser.prog}: woosh starts a simulated chassis: woosh run --sim program.py\n")

    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--chassis", metavar="HOST", help="the chassis: sets ROS_MASTER_URI, and ROS_IP to our address there"
    )
    where.add_argument("--master", metavar="URI", help="sets ROS_MASTER_URI; a host means port 11311 there")
    parser.add_argument(
        "--msg-path",
        metavar="FOLDER",
        action="append",
        default=[],
        help="folder with packages of .msg, .srv, .action files (repeat for more)",
    )
    parser.add_argument(
        "--resolve",
        metavar="NAME=IP",
        action="append",
        default=[],
        help="the address of a host name that this computer does not know: sets ROSPROTO_RESOLVE",
    )
    parser.add_argument("--sim", "--mark", "--marks", action=Moved, nargs=0, help=argparse.SUPPRESS)
    parser.add_argument("program", help="a Python file written for rospy")
    parser.add_argument("arguments", nargs="...", help="the program's arguments").required = False


def main(argv: Sequence[str] | None = None, *, prog: str = "python -m rosproto.rospy") -> int:
    """Run a command line (by default the one of this process); returns the exit code."""
    words = list(sys.argv[1:] if argv is None else argv)
    try:
        if words and not words[0].startswith("-"):  # no options: nothing to be parsed
            return run_program(words[0], words[1:])
        return _run_with_options(words, prog)
    except (RosError, ValueError, OSError) as error:  # run_program prints the program's own errors
        print(f"{prog}: {error}", file=sys.stderr)
        return 1 if isinstance(error, RosError) else 2  # 2: the options are wrong


def _run_with_options(words: Sequence[str], prog: str) -> int:
    import argparse

    class Parser(argparse.ArgumentParser):
        def error(self, message: str) -> NoReturn:
            self.exit(2, f"{prog}: {message}; for example: {prog} program.py\n")

    parser = Parser(prog=prog, description="Run a program written for rospy, unchanged, without ROS.")
    parser.add_argument("-v", "--verbose", action="count", default=0, help="log; twice: log everything")
    add_arguments(parser)
    arguments = parser.parse_args(words)
    if arguments.verbose:
        _show_library_log(arguments.verbose)
    return run(arguments)


def run(arguments: argparse.Namespace) -> int:
    """Run the program of a command line; returns its exit code.

    Raises:
        RosError, ValueError, OSError: An option cannot be carried out.
    """
    if arguments.master:
        from rosproto.transport.uri import master_uri_of

        os.environ["ROS_MASTER_URI"] = master_uri_of(arguments.master)
    saved = None if arguments.chassis else remembered()
    return run_at(
        lambda: arguments.chassis or (saved and saved.chassis),
        arguments.program,
        arguments.arguments,
        msg_path=arguments.msg_path,
        own_address=saved and saved.host,
        resolve=arguments.resolve,
    )


def run_at(
    chassis: Callable[[], str | None],
    program: str,
    arguments: Sequence[str],
    *,
    own_address: str | None = None,
    msg_path: Iterable[str] = (),
    resolve: Iterable[str] = (),
) -> int:
    """Set up the environment for a chassis and run a program; returns its exit code.

    Args:
        chassis: Returns a host or a master's URI, None for that of the environment. Exit functions that it
            registers run after those of the program.
        program: Its file.
        arguments: The program's own.
        own_address: Our address, as the robot reaches it; None for that on the route to the master.
        msg_path: Further folders with packages of message definitions.
        resolve: "NAME=IP" of host names that this computer does not know.

    Raises:
        RosError, ValueError, OSError: An option cannot be carried out.
    """
    _interrupt()
    given = [os.path.abspath(folder) for folder in msg_path]
    if given:
        before = os.environ.get(MSG_PATH, "")
        os.environ[MSG_PATH] = os.pathsep.join([*given, *([before] if before else [])])
    names = list(resolve)
    if names:
        from rosproto.transport.robot_host_names import VARIABLE, parse_host_names

        known = {**parse_host_names([os.environ.get(VARIABLE, "")]), **parse_host_names(names)}
        os.environ[VARIABLE] = ",".join(f"{name}={address}" for name, address in known.items())
    host = chassis()
    if host is not None:
        _go_to(host, own_address)
    return run_program(program, arguments)


def _go_to(host: str, own_address: str | None) -> None:
    """Set the environment to the master of a chassis, and to our own address, by default that on the route.

    Raises:
        RosError: There is no route to it.
    """
    from rosproto.transport.own_address import local_address_towards
    from rosproto.transport.uri import master_uri_of, parse_uri

    uri = master_uri_of(host)
    os.environ["ROS_MASTER_URI"] = uri
    os.environ["ROS_IP"] = own_address or local_address_towards(*parse_uri(uri))
    os.environ.pop("ROS_HOSTNAME", None)


# ROS's own scripts use parts of its modules that ours do not have.
_TOOLS = {
    "rosbag": "`rosproto bag`",
    "roscore": "`rosproto master`",
    "rosgraph": "`rosproto graph`",
    "roslaunch": "`rosproto run FILE` for each program of the launch file, and `rosproto param load`",
    "rosmaster": "`rosproto master`",
    "rosmsg": "`rosproto msg`",
    "rosnode": "`rosproto node`",
    "rosparam": "`rosproto param`",
    "rosservice": "`rosproto service`",
    "rossrv": "`rosproto srv`",
    "rostest": "`rosproto run FILE` for each test, against `rosproto master`",
    "rostopic": "`rosproto topic`",
    "rosunit": "`rosproto run FILE`",
    "roswtf": "`rosproto doctor`",
}


def run_program(path: str, arguments: Sequence[str] = ()) -> int:
    """Run a program as `__main__` of this process.

    Returns:
        0 when it ended by itself, 1 after an exception, which was printed.

    Raises:
        SystemExit: The program called sys.exit.
    """
    interrupt = _interrupt()
    file_name = _absolute(path)
    tool = os.path.basename(path)
    if tool in _TOOLS:
        print(f"{tool} is a command of a ROS installation: use {_TOOLS[tool]}", file=sys.stderr)
        return 2
    try:
        with open(path, "rb") as file:
            source = file.read()
    except OSError as error:
        why = f"[Errno {error.errno}] {error.strerror}"
        print(f"{sys.executable}: can't open file {file_name!r}: {why}", file=sys.stderr)
        return 2
    serve()
    _forget_logging()
    main_module = ModuleType("__main__")
    loader = SourceFileLoader("__main__", file_name)
    vars(main_module).update(__file__=file_name, __loader__=loader, __builtins__=builtins, __cached__=None)
    sys.modules["__main__"] = main_module
    sys.argv[:] = [path, *arguments]
    # With -P or -I, and in an embeddable Python, sys.path does not begin with the program's folder.
    if not getattr(sys.flags, "safe_path", sys.flags.isolated):
        sys.path[:1] = [os.path.dirname(os.path.realpath(path))]
    try:
        exec(compile(source, file_name, "exec", dont_inherit=True), vars(main_module))
    except SystemExit:
        raise
    except BaseException as error:
        error.__traceback__ = _from_program(error.__traceback__)
        sys.excepthook(type(error), error, error.__traceback__)
        if type(error) is KeyboardInterrupt:
            interrupt.happened = True
        return 1
    return 0


def _absolute(path: str) -> str:
    """The path as Python sets `__file__` for a script: absolute, but normalised only on Windows."""
    try:
        return os.path.abspath(path) if os.name == "nt" else os.path.join(os.getcwd(), path)
    except OSError:  # the present folder was deleted
        return path


def _from_program(trace: TracebackType | None) -> TracebackType | None:
    """Return the traceback without our own frames; None for a program that cannot be compiled."""
    while trace is not None and trace.tb_frame.f_code.co_filename == __file__:
        trace = trace.tb_next
    return trace


def _show_library_log(verbosity: int) -> None:
    """Write the library's log to stderr; the program's logging is unchanged."""
    logger = logging.getLogger("rosproto")
    logger.addHandler(logging.StreamHandler())
    logger.setLevel(logging.INFO if verbosity == 1 else logging.DEBUG)


def _forget_logging() -> None:
    """Undo the command's log set-up, so that `logging` is as in a new interpreter."""
    for handler in list(logging.root.handlers):
        logging.root.removeHandler(handler)
    logging.root.setLevel(logging.WARNING)


class _Interrupt:
    """Ends the process by SIGINT after an uncaught KeyboardInterrupt, as Python does; shells check for that.

    Created before the program is loaded, so that its exit function runs last: after the program's threads
    have ended and its own exit functions have run.
    """

    def __init__(self) -> None:
        self.happened = False
        raise_on_interrupt()
        if os.name == "posix":
            atexit.register(self._die)

    def _die(self) -> None:
        if not self.happened:
            return
        logging.shutdown()  # registered earlier than this, so it would not be called
        sys.stdout.flush()
        sys.stderr.flush()
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        signal.raise_signal(signal.SIGINT)


_interrupt = cache(_Interrupt)
