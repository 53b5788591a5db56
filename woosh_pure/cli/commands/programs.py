"""`woosh run`: a program of the user, for rospy or with `Chassis()`, at a chassis or at a simulated one."""

from __future__ import annotations

import atexit
import logging
import os
import signal
import subprocess
import sys
import sysconfig
import threading
import time
from argparse import SUPPRESS, ArgumentParser, Namespace
from contextlib import ExitStack, suppress
from pathlib import Path
from queue import SimpleQueue
from types import TracebackType
from typing import TYPE_CHECKING

import rosproto
import woosh_pure
from rosproto.cli import is_terminal, natural, port, signals_ignored
from rosproto.errors import RosTimeout
from rosproto.sentence import say
from woosh_pure.cli.arguments import add_mark_options, simulated_marks
from woosh_pure.cli.connection import chosen, connect, simulated
from woosh_pure.cli.output import Output
from woosh_pure.errors import MotionRefused
from woosh_pure.hints import MODULES, meant
from woosh_pure.outcome import ENDED_EARLY

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis
    from woosh_pure.sim import SimulatedChassis
    from woosh_pure.web.server import WebServer

_OPTIONS = ("--sim", "--sim-speed", "--watch", "--page-port", "--mark", "--marks", "--chassis", "--master")
"""Those of `woosh run` that are told where they stand behind the file, and so are the program's."""

_ENDED = "the program has ended with exit code {code}; {report}; it runs again {again}; Ctrl-C ends"


def add_run(parser: ArgumentParser) -> None:
    add_mark_options(parser)
    parser.add_argument(
        "--watch",
        action="store_true",
        help="show its robot in a browser; run it again when its file changes, or after the page's reset",
    )
    parser.add_argument("--page-port", type=port, default=8080, metavar="PORT", help="of that page (8080)")
    parser.add_argument("--ends-with", type=natural, help=SUPPRESS)
    parser.add_argument("program", help="a Python file that uses woosh_pure or rospy")
    parser.add_argument("arguments", nargs="...", help="the program's arguments").required = False


def run_run(args: Namespace, out: Output) -> int:
    if (args.mark or args.marks) and not args.sim:
        raise ValueError("--mark and --marks are for --sim: a real chassis has its own marks")
    out = Output(stream=sys.stderr, language=out.language)  # stdout is the program's
    if args.watch:
        return _watch(args, out)
    from logging.handlers import QueueHandler

    from rosproto.rospy import run_at

    for word in args.arguments[:1] if args.arguments[:1] == ["--"] else args.arguments:
        if (option := word.partition("=")[0]) in _OPTIONS:
            out.line(
                "{option} was given to {file}; to give it to woosh run, put it before the file: "
                "woosh run {option} {file}",
                option=option,
                file=args.program,
            )
    code, ended_early = 1, SimpleQueue[logging.LogRecord]()
    log = logging.getLogger(ENDED_EARLY)
    log.propagate = False
    log.setLevel(logging.INFO)
    log.addHandler(QueueHandler(ended_early))

    def tell() -> None:
        if code == 0 and not ended_early.empty():
            out.line(
                "the program has ended, and so a motion that was under way was cancelled: `.wait()` may be "
                "missing, as in chassis.forward(0.5).wait()"
            )

    def show(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
        _leave_own_frames(error.with_traceback(trace))
        sys.__excepthook__(kind, error, error.__traceback__)
        if isinstance(error, ModuleNotFoundError) and (right := meant(MODULES, error.name or "")):
            out.line("did you mean {names}?", names=f"`{right}`")

    if args.ends_with is not None:
        threading.Thread(target=_end_with, args=(args.ends_with,), name="woosh:run", daemon=True).start()
    atexit.register(tell)  # called after the exit functions of the program
    if not args.debug:
        sys.excepthook = show
    address, own = (None, args.host) if args.sim else chosen(args)
    code = run_at(
        lambda: _simulated(args, out) if args.sim else address,
        args.program,
        args.arguments,
        own_address=own,
        msg_path=args.msg_path or (),
        resolve=args.resolve or (),
    )
    return code


def _end_with(pipe: int) -> None:
    """Interrupt this process, as Ctrl-C does, when nobody has the other end of a pipe any more."""
    os.read(pipe, 1)
    if os.name == "posix":  # elsewhere no pipe is handed on
        os.kill(os.getpid(), signal.SIGINT)


def _leave_own_frames(error: BaseException, seen: tuple[BaseException, ...] = ()) -> None:
    """Remove the frames of libraries, and the causes that are within them."""
    folders = [sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")]
    folders += [os.path.dirname(str(module.__file__)) for module in (rosproto, woosh_pure)]
    libraries = ("<frozen ", *(os.path.join(folder, "") for folder in folders))
    own, each = list[TracebackType](), error.__traceback__
    while each is not None:
        if not each.tb_frame.f_code.co_filename.startswith(libraries):
            own.append(each)
        each = each.tb_next
    error.__traceback__ = None
    for one in reversed(own):
        error.__traceback__ = TracebackType(error.__traceback__, one.tb_frame, one.tb_lasti, one.tb_lineno)
    for name in ("__cause__", "__context__"):
        if (cause := getattr(error, name)) is not None and cause not in seen:
            _leave_own_frames(cause, (*seen, error))
            if cause.__traceback__ is None:
                setattr(error, name, None)


def _simulated(args: Namespace, out: Output) -> str:
    """Start a simulated chassis that runs until the program ends; return the URI of its master."""
    from woosh_pure.sim.site import site_of

    stack = ExitStack()
    atexit.register(stack.close)
    return simulated(args, out, stack, site=site_of(None, args.mark, args.marks))


def _watch(args: Namespace, out: Output) -> int:
    """Show the robot on a page, and run the program in processes of its own meanwhile."""
    if not Path(args.program).is_file():
        raise ValueError(say("{file}: there is no such file", file=args.program))
    from woosh_pure.cli.commands.web import page_arguments, page_of

    uri = _simulated(args, out) if args.sim else None
    simulator: SimulatedChassis | None = args.simulator if args.sim else None
    page = page_arguments(args, *([] if is_terminal(sys.stderr) else ["--no-browser"]))
    with connect(args, out, to=uri) as chassis:
        # Whatever moves at the end of the program is stopped, so nobody else may have begun it.
        with suppress(RosTimeout):
            if not chassis.measured_velocity.wait(2.0, new=False).is_standing():
                raise MotionRefused("the robot moves already; stop it first: `woosh stop`")
        simulators = {"robot": simulator} if simulator else {}
        marks = simulated_marks(args).values()
        with page_of({"robot": chassis}, page, out, marks, simulators) as (server, _):
            while server.running:
                _run_once(args, chassis, out, server, simulator)
    return 1


def _run_once(
    args: Namespace, chassis: Chassis, out: Output, server: WebServer, simulator: SimulatedChassis | None
) -> None:
    """Run the program until its file changes or the simulation is reset; whenever it ends, stop the robot."""

    def now() -> tuple[object, ...]:
        file = Path(args.program)
        return file.stat().st_mtime_ns if file.exists() else None, simulator and simulator.resets

    options = [f"--msg-path={one}" for one in args.msg_path or ()]
    options += [f"--resolve={one}" for one in args.resolve or ()]
    options += ["--lang", out.language, *(["--debug"] if args.debug else [])]
    words = ["woosh_pure", "--master", chassis.master_uri, *options, "run"]
    before, ended = now(), False
    theirs, ours = os.pipe()  # ours is closed when this process is killed, too; the program then ends
    handed = [theirs] if os.name == "posix" else []
    words += [*(f"--ends-with={pipe}" for pipe in handed), args.program, *args.arguments]
    process = subprocess.Popen([sys.executable, "-m", *words], pass_fds=handed)
    os.close(theirs)
    try:
        while server.running and now() == before:
            time.sleep(0.1)
            if not ended and process.poll() is not None:
                ended = True
                report = chassis.stop(everything=True)
                again = say("when {file} changes", file=args.program)
                if simulator:
                    again = say("{changed}, or after a reset on the page", changed=again)
                out.line(_ENDED, code=process.returncode, report=report, again=again)
    finally:
        with signals_ignored():
            process.terminate()
            try:
                process.wait(3.0)
            except subprocess.TimeoutExpired:
                process.kill()
            os.close(ours)
            if not ended:
                chassis.stop(everything=True)
    if simulator:
        simulator.reset()  # each run begins where the robot was switched on
    if server.running:
        out.line("{file} starts again", file=args.program)
