"""The programs that are interrupted: every verb, every way to wait for it, every way to leave; and commands.

A program prints "begin" just before it begins what moves; the chassis may be connected by then, or not.
"""

from __future__ import annotations

import random
import textwrap
from dataclasses import dataclass

__all__ = ["Program", "draw", "every_verb"]

VERBS = {
    "go_to_mark": "chassis.go_to_mark('B1')",
    "park": "chassis.park('B1')",
    "charge": "chassis.charge('C1')",
    "carry": "chassis.carry('B1', Direction.LOAD)",
    "go_to": "chassis.go_to(2.8, 0.0)",
    "follow": "chassis.follow([Pose2D(1.0, 0.0), Pose2D(2.8, 0.0)])",
    "move": "chassis.move(2.5, speed=0.3)",
    "rotate": "chassis.rotate(6.0, speed=0.5)",
    "steps": "chassis.steps([Step.straight(1.5, 0.3), Step.turn(3.0, 0.5)])",
    "action": "chassis.action('/move_base', navigation_goal())",
}
WAITS = {
    "wait": "handle.wait()",
    "wait for ever": "handle.wait(None)",
    "time out": "handle.wait(0.4)",
    "progress": "[None for _ in handle.reports()]",
    "cancel": "time.sleep(0.3); handle.cancel()",
    "stop": "time.sleep(0.3); chassis.stop()",
    "close": "time.sleep(0.3); chassis.close()",
    "no wait": "time.sleep(30)",
    "feed": "chassis.feed('/lift').wait(None)",
    "await": "asyncio.run(awaited(handle))",
}
DRIVES = {
    "hold": "drive.hold(0.2, seconds=30)",
    "set": "\n".join(("while True:", "    drive.set(0.2, valid_for=5.0)", "    time.sleep(0.02)")),
    "stop": "drive.set(0.2, valid_for=5.0); time.sleep(0.4); chassis.stop(); time.sleep(30)",
    "close": "drive.set(0.2, valid_for=5.0); time.sleep(0.4); chassis.close(); time.sleep(30)",
}
COMMANDS = (
    ("goto", "B1"),
    ("goto", "--pose", "2.8", "0", "0"),
    ("move", "2.5", "--speed", "0.3"),
    ("rotate", "300", "--speed", "25"),
    ("charge", "C1"),
    ("task", "pick", "B1"),
    ("drive", "--acknowledged"),
    ("shell", "-c", "chassis.move(2.5, speed=0.3).wait()"),
)
BEGIN = """
import asyncio, sys, time
from woosh_pure import Chassis, Pose2D
from woosh_pure.enums import Direction
from woosh_pure.values.messages import stamped_pose
from woosh_pure.values.messages import message_type
from woosh_pure.motion import Step

def navigation_goal():
    goal = message_type("woosh_msgs/MoveBaseGoal")()
    goal.target_pose = stamped_pose(Pose2D(2.8, 0.0))
    return goal

async def awaited(handle):
    await handle

def begin():
    print("begin", flush=True)

"""


@dataclass(frozen=True)
class Program:
    """One program.

    Attributes:
        name: What it does, in words.
        code: Its text; sys.argv[1] is the master's URI.
        terminal: It wants a terminal, and keys pressed on it.
    """

    name: str
    code: str
    terminal: bool = False


def command(words: tuple[str, ...]) -> Program:
    """A `woosh` command."""
    code = f"""
import sys
from woosh_pure.cli import main
sys.argv = ["woosh", {words[0]!r}, "--master", sys.argv[1], *{list(words[1:])!r}]
print("begin", flush=True)
sys.exit(main())
"""
    return Program("woosh " + " ".join(words), code, terminal=words[0] == "drive")


def script(body: str, ending: str, *, early: bool) -> str:
    """A program that runs `body`, and ends in one of the ways that programs do.

    Args:
        body: Lines that use `chassis`.
        ending: "plain" (no block), "with", "caught" (the interrupt is caught and the program goes on).
        early: It says that it begins before it has connected.
    """
    lines = [] if early else ["chassis.readiness()"]
    inner = "\n".join([*lines, "begin()" if not early else "pass", body])
    if ending == "with":
        whole = "with Chassis(sys.argv[1]) as chassis:\n" + textwrap.indent(inner, "    ")
    elif ending == "caught":
        whole = (
            "chassis = Chassis(sys.argv[1])\ntry:\n"
            + textwrap.indent(inner, "    ")
            + "\nexcept KeyboardInterrupt:\n    pass\nprint('goes on', flush=True)\ntime.sleep(1.0)"
        )
    else:
        whole = "chassis = Chassis(sys.argv[1])\n" + inner
    return BEGIN + ("begin()\n" if early else "") + whole + "\n"


def draw(luck: random.Random) -> Program:
    """One of them at random."""
    kind = luck.random()
    if kind < 0.2:
        return command(luck.choice(COMMANDS))
    ending, early = luck.choice(("plain", "with", "caught")), luck.random() < 0.3
    if kind < 0.4:
        what, text = luck.choice(list(DRIVES.items()))
        body = "with chassis.velocity(bypasses_protection=True) as drive:\n" + textwrap.indent(text, "    ")
        name = f"velocity, {what}"
    else:
        verb, how = luck.choice(list(VERBS)), luck.choice(list(WAITS))
        body = f"handle = {VERBS[verb]}\n{WAITS[how]}"
        name = f"{verb}, {how}"
    early_text = ", early" if early else ""
    return Program(f"{name}, {ending}{early_text}", script(body, ending, early=early))


def every_verb() -> list[Program]:
    """Each verb, each wait, each command and each drive once."""
    programs = [command(words) for words in COMMANDS]
    endings = ("plain", "with", "caught")
    waits = list(WAITS.items())
    for number, (verb, call) in enumerate(VERBS.items()):
        how, wait = waits[number % len(waits)]
        ending = endings[number % 3]
        programs.append(
            Program(f"{verb}, {how}, {ending}", script(f"handle = {call}\n{wait}", ending, early=False))
        )
    for number, (what, text) in enumerate(DRIVES.items()):
        ending = endings[number % 3]
        body = "with chassis.velocity(bypasses_protection=True) as drive:\n" + textwrap.indent(text, "    ")
        programs.append(Program(f"velocity, {what}, {ending}", script(body, ending, early=False)))
    return programs
