"""Connects a command to its chassis, and stops our motion when the command is interrupted or fails."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from typing import TYPE_CHECKING

from rosproto.cli import never_wait_for_stdout, signals_ignored, watchdog_if
from rosproto.errors import ConnectionLost, RosTimeout
from rosproto.msg import environment_paths
from rosproto.profile import remembered
from rosproto.sentence import both, say, sentence_of
from woosh_pure.cli.output import Output
from woosh_pure.errors import ChassisError, MotionRefused

if TYPE_CHECKING:
    from rosproto.watchdog import Watchdog
    from woosh_pure.chassis import Chassis
    from woosh_pure.sim.site import Site


_ENDED_THERE = ("REPLACED", "CANCELLED", "REJECTED")
"""Outcomes that the chassis has reported: no motion of ours continues."""


def address_of(
    args: Namespace, out: Output, stack: ExitStack, sim_speed: float = 1.0
) -> tuple[str | None, str | None]:
    """Return the chassis's address and our own, by the common options; with --sim, of one started here."""
    if args.sim:
        return simulated(args, out, stack, sim_speed), args.host
    return chosen(args)


def graph_of(args: Namespace, out: Output, stack: ExitStack) -> tuple[str, str | None]:
    """Return the URI of the chassis's master and our own address, for a command with a node of its own.

    A robot that has only the Robot API gets its graph in this process, until the end of `stack`.
    """
    from rosproto.transport import HostNames
    from woosh_pure.connection.arguments import master_uri_of
    from woosh_pure.robot_api.http import only_robot_api

    address, host = address_of(args, out, stack)
    uri = master_uri_of(address)
    given = robot_api_of(args)
    if (api := only_robot_api(uri, given)) is None:
        return uri, host
    from woosh_pure.api_bridge.bridge import ApiBridge

    return stack.enter_context(ApiBridge(api, hosts=HostNames(names(args)))).master_uri, "127.0.0.1"


def chosen(args: Namespace) -> tuple[str | None, str | None]:
    """Return the chassis's address and our own, by the common options.

    In this order: --master, --chassis, $ROS_MASTER_URI (as None), the profile saved by `woosh connect`.
    """
    if args.master and args.chassis:
        raise ValueError("--master and --chassis contradict each other; give one of them")
    for option, given in (("--master", args.master), ("--chassis", args.chassis), ("--host", args.host)):
        if given is not None and not given.strip():
            # Empty, as from an unset variable of a script: refuse, instead of using another chassis.
            wrong = "{option} is empty; give an address such as 169.254.128.2, or leave {same} out"
            raise ValueError(say(wrong, option=option, same=option))
    address = args.master or args.chassis
    profile = None if address else remembered()
    return (address, args.host) if profile is None else (profile.chassis, args.host or profile.host)


def names(args: Namespace) -> dict[str, str]:
    """Return the host names of --resolve, then those of the environment."""
    from rosproto.node import host_names
    from rosproto.transport import parse_host_names

    return {**host_names(), **parse_host_names(getattr(args, "resolve", None) or ())}


def robot_api_of(args: Namespace) -> str | bool | None:
    """Return what `Chassis(robot_api=...)` takes, by the common options; --sim has none."""
    given: str | None = args.api_address
    return False if args.sim or given == "off" else given


def watchdog_of(args: Namespace) -> AbstractContextManager[Watchdog | None]:
    """Start the process that stops the robot if this one is killed; None with --sim."""
    return watchdog_if(not (args.no_watchdog or args.sim))


@contextmanager
def connect(
    args: Namespace,
    out: Output,
    *,
    to: str | None = None,
    sim_speed: float = 1.0,
    watchdog: Watchdog | None = None,
    patient: bool = False,
) -> Iterator[Chassis]:
    """Connect to the chassis of the common options.

    Args:
        args: The command line.
        out: Prints the progress.
        to: The address of another chassis.
        sim_speed: With --sim, simulated seconds per second.
        watchdog: The process that stops the robot when this process is killed.
        patient: Yield an unreachable chassis, too, without entering it; enter it later.
    """
    if args.sim_speed is not None and not args.sim:
        raise ValueError("--sim-speed is for --sim; a real chassis runs in real time")
    from tempfile import TemporaryDirectory

    from woosh_pure.chassis import Chassis

    with ExitStack() as stack:
        address, host = (to, args.host) if to is not None else address_of(args, out, stack, sim_speed)
        with out.working("connecting"):
            paths = [*(args.msg_path or ()), *environment_paths()]
            learned = not args.no_learned
            chassis = Chassis(
                address,
                host=host,
                msg_path=paths,
                learned=learned,
                resolve=names(args),
                watchdog=watchdog or False,
                robot_api=robot_api_of(args),
                missions_state=stack.enter_context(TemporaryDirectory()) if args.sim and to is None else None,
            )
            try:
                with reaching():
                    stack.enter_context(chassis)
            except ConnectionLost:
                if not patient:
                    raise
                stack.push(chassis)  # closed at the end, whether it was entered later or not
        try:
            yield chassis
        except BaseException as error:
            if not _may_move(chassis, error):
                raise
            stop_and_tell(chassis, out)
            if isinstance(error, BrokenPipeError):
                # Without a reader of the output, a motion is stopped.

                raise ChassisError("the output was closed: the motion was stopped") from error
            raise


@contextmanager
def reaching() -> Iterator[None]:
    """Convert the timeout of a master to ConnectionLost: for scripts it is unreachable."""
    try:
        yield
    except RosTimeout as error:
        try_it = "try `woosh doctor`"
        why = both(error.why, try_it) if error.why else ""
        raise ConnectionLost(both(sentence_of(error), try_it), peer=error.peer, why=why) from error


def simulated(
    args: Namespace, out: Output, stack: ExitStack, speed: float = 1.0, site: Site | None = None
) -> str:
    """Start the simulated chassis of --sim, which is `args.simulator` then; return its master's URI."""
    if args.master or args.chassis:
        raise ValueError("--sim and an address contradict each other; give one of them")
    from woosh_pure.sim import SimulatedChassis

    speed = speed if args.sim_speed is None else args.sim_speed
    args.simulator = sim = stack.enter_context(SimulatedChassis(speed=speed, site=site))
    out.line(
        "a new simulated robot, for this command alone, at {uri}; several commands share one with "
        "`woosh sim` and, beside it, `woosh connect 127.0.0.1`",
        uri=sim.master_uri,
    )
    return sim.master_uri


def _may_move(chassis: Chassis, error: BaseException) -> bool:
    """Whether a motion of this process may still run. A stop would also disturb motions of others."""
    from woosh_pure.chassis import components_of

    if chassis.under_way or components_of(chassis).motions.just_cancelled:
        return True

    outcome = getattr(error, "outcome", None)
    if outcome is not None:
        return outcome.kind.name not in _ENDED_THERE
    return chassis.moved and not isinstance(error, (MotionRefused, BrokenPipeError))


def stop_and_tell(chassis: Chassis, out: Output) -> None:
    """Stop and print the report. A second Ctrl-C does not interrupt it; it ends within seconds."""
    never_wait_for_stdout()
    with signals_ignored():
        with out.working("stopping"):
            report = chassis.stop(timeout=4.0)
        try:
            out.line(str(report))
        except (OSError, ValueError):
            pass  # the terminal has gone; the stop matters, not the report
