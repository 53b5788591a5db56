"""`woosh drive`: drive by keyboard.

Terminals send no key-up, only repeats of a held key. So each key sets a velocity that expires, and every key
other than the four directions stops.
"""

from __future__ import annotations

import math
import signal
import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rosproto.cli import Keys, is_terminal, never_wait_for_stdout, open_keys, own, positive, terminal_size
from rosproto.sentence import say
from rosproto.text import cut, padded
from woosh_pure.cli.arguments import add_watchdog
from woosh_pure.cli.connection import connect, stop_and_tell, watchdog_of
from woosh_pure.cli.output import Output
from woosh_pure.errors import MotionRefused

if TYPE_CHECKING:
    from woosh_pure.chassis import Chassis
    from woosh_pure.velocity.drive import Drive


_WARNING = (
    "DRIVING BY VELOCITY BYPASSES THE CHASSIS'S OBSTACLE AVOIDANCE AND LIMITS.",
    "The area must be clear. Watch the robot all the time, and keep its red button within reach.",
    "This program is not an emergency stop: if it or the network fails, the robot may keep driving.",
)
_KEYS = "arrows or WASD: drive   + -: faster, slower (stops)   q, Esc: end   any other key: stop"


def add_drive(parser: ArgumentParser) -> None:
    parser.add_argument("--linear", type=positive, metavar="M/S", help="full speed (0.2, or the limit)")
    parser.add_argument(
        "--angular", type=positive, metavar="DEG/S", help="full turning speed (25, or the limit)"
    )
    parser.add_argument("--direct", action="store_true", help="without the chassis's smoothing")
    parser.add_argument(
        "--feedback-timeout",
        type=positive,
        default=0.4,
        metavar="S",
        help="end the drive after S seconds without a measured velocity (0.4)",
    )
    parser.add_argument(
        "--share",
        action="store_true",
        help="drive beside another program that can send velocities: it must be silent meanwhile",
    )
    parser.add_argument(
        "--acknowledged",
        action="store_true",
        help="skip the confirmation: you know that this bypasses the protection",
    )
    add_watchdog(parser)


def run_drive(args: Namespace, out: Output) -> None:
    if args.json:
        raise ValueError("--json: there is nothing to print for programs; use Chassis.velocity in Python")
    if not (is_terminal(sys.stdin) and is_terminal(sys.stdout)):
        raise ValueError("drive needs a terminal for its keys; from a script use Chassis.velocity in Python")
    with watchdog_of(args) as watchdog, connect(args, out, watchdog=watchdog) as chassis:
        chassis.readiness()
        if not (args.acknowledged or args.sim):
            _ask(out)
        try:
            _drive(chassis, args, out)
        except MotionRefused:
            if chassis.moved:  # and was not stopped by its keys
                stop_and_tell(chassis, out)
            raise
        report = chassis.stop(timeout=4.0)
        stands = report.standing and not report.problems
        out.line("the robot stands still" if stands else str(report))


def _ask(out: Output) -> None:
    for line in _WARNING:
        out.line(line)
    try:
        answer = input(f"{out.say('Type yes to drive:')} ")
    except EOFError:
        answer = ""
    if answer.strip().lower() != "yes":
        raise MotionRefused("not acknowledged, nothing was sent; type yes when the area is clear")


def _drive(chassis: Chassis, args: Namespace, out: Output) -> None:
    never_wait_for_stdout()
    angular = None if args.angular is None else math.radians(args.angular)
    out.line(_KEYS)
    with open_keys() as keys, _never_asleep(), ExitStack() as stack:
        with out.working("opening the drive"):
            drive = stack.enter_context(
                chassis.velocity(
                    bypasses_protection=True,
                    direct=args.direct,
                    max_linear=args.linear,
                    max_angular=angular,
                    feedback_timeout=args.feedback_timeout,
                    share=args.share,
                )
            )
        keys.read(0.0)  # discard keys pressed before the drive was open
        linear = min(0.2, drive.limits.linear) if args.linear is None else args.linear
        turning = min(math.radians(25.0), drive.limits.angular) if angular is None else angular
        try:
            _loop(chassis, drive, keys, Teleop(linear, turning), out)
        finally:
            own(sys.stdout).write("\r\n")


def _loop(chassis: Chassis, drive: Drive, keys: Keys, teleop: Teleop, out: Output) -> None:
    while True:
        command = teleop.press(keys.read(0.05))
        if command is not None:
            if command.quit:
                return
            drive.set(command.vx, command.wz, valid_for=VALID_FOR)
        elif not drive.active:
            drive.set(0.0)  # raises the reason of the end
        _show(chassis, drive, teleop, command, out)


def _show(chassis: Chassis, drive: Drive, teleop: Teleop, command: Press | None, out: Output) -> None:
    sent, measured, pose = drive.sending, chassis.measured_velocity.latest, chassis.pose.latest
    stopped = "" if sent.vx or sent.wz or (command and command.moves) else "STOP"
    parts = [
        f"{out.cell(stopped or 'drive', 5)} {out.say(say('speed {speed:.0%}', speed=teleop.speed))}",
        say("sent {vx:+.2f} m/s {wz:+4.0f}°/s", vx=sent.vx, wz=math.degrees(sent.wz)),
    ]
    if measured is not None:
        parts.append(
            say("measured {vx:+.2f} m/s {wz:+4.0f}°/s", vx=measured.vx, wz=math.degrees(measured.wz))
        )
    if pose is not None:
        parts.append(say("at {where}", where=f"{pose.x:.2f} {pose.y:.2f} {pose.yaw_degrees:.0f}°"))
    columns = terminal_size()[0] - 1
    text = padded(cut("  ".join(map(out.say, parts)), columns), columns)
    own(sys.stdout).write(f"\r{text}")
    sys.stdout.flush()


@contextmanager
def _never_asleep() -> Iterator[None]:
    """Ignore job control stops within the block: a suspended process cannot stop the robot."""
    number_ = getattr(signal, "SIGTSTP", None)
    try:
        before = None if number_ is None else signal.signal(number_, signal.SIG_IGN)
    except ValueError:
        before = number_ = None
    try:
        yield
    finally:
        if number_ is not None:
            signal.signal(number_, before)


VALID_FOR = 0.3
"""Seconds a key is good for. The velocity is sent at 20 Hz, so zero is out within 0.4 s of the last key."""

_DIRECTIONS = {
    "up": (1.0, 0.0),
    "w": (1.0, 0.0),
    "down": (-1.0, 0.0),
    "s": (-1.0, 0.0),
    "left": (0.0, 1.0),
    "a": (0.0, 1.0),
    "right": (0.0, -1.0),
    "d": (0.0, -1.0),
}
_QUIT = ("q", "escape")
_STEPS = (0.25, 0.5, 0.75, 1.0)


@dataclass(frozen=True, slots=True)
class Press:
    """A command: vx in m/s, wz in rad/s."""

    vx: float = 0.0
    wz: float = 0.0
    quit: bool = False

    @property
    def moves(self) -> bool:
        """Whether it is not a stop."""
        return bool(self.vx or self.wz)


class Teleop:
    """Converts keys to commands.

    Args:
        linear, angular: Full speed, m/s and rad/s.
    """

    def __init__(self, linear: float, angular: float) -> None:
        self._linear, self._angular = linear, angular
        self._step = 1

    @property
    def speed(self) -> float:
        """Fraction of the full speed, 0.25 to 1; initially 0.5."""
        return _STEPS[self._step]

    def press(self, keys: Sequence[str]) -> Press | None:
        """Return the command for simultaneous keys; None without keys.

        A key that is not a direction has priority in any order: no direction overrides a stop.
        """
        if not keys:
            return None
        if any(key in _QUIT for key in keys):
            return Press(quit=True)
        for key in keys:
            if key in ("+", "=", "-"):
                self._step = min(max(self._step + (-1 if key == "-" else 1), 0), len(_STEPS) - 1)
        if any(key not in _DIRECTIONS for key in keys):
            return Press()
        forward, left = _DIRECTIONS[keys[-1]]
        return Press(forward * self._linear * self.speed, left * self._angular * self.speed)
