"""`python -m tests.storm --trials N [--jobs N] [--seed N]`: see the package's docstring."""

from __future__ import annotations

import argparse
import random
import subprocess
import sys
import time

from tests.storm.nursery import Born, Nursery
from tests.storm.programs import Program, draw, every_verb


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.storm")
    parser.add_argument("--trials", type=int, default=100)
    parser.add_argument("--jobs", type=int, default=2, help="trials at the same time, each with its robot")
    parser.add_argument("--seed", type=int, help="printed when not given")
    parser.add_argument("--only", default="", help="programs with this in their name")
    parser.add_argument("--seconds", type=float, default=1e9, help="begin no trial later than this")
    parser.add_argument("--all", action="store_true", help="each verb, wait and command once")
    parser.add_argument(
        "--part", type=int, nargs=2, metavar=("N", "OF"), default=(0, 1), help=argparse.SUPPRESS
    )
    arguments = parser.parse_args()
    seed = random.randrange(2**32) if arguments.seed is None else arguments.seed
    if arguments.jobs > 1:
        return _several(arguments, seed)
    return _trials(arguments, seed)


def _several(arguments: argparse.Namespace, seed: int) -> int:
    share = -(-arguments.trials // arguments.jobs)
    words = ["--trials", str(share), "--jobs", "1", "--only", arguments.only]
    words += ["--seconds", str(arguments.seconds), *(["--all"] if arguments.all else [])]
    parts = []
    for number in range(arguments.jobs):
        own = ["--seed", str(seed + number), "--part", str(number), str(arguments.jobs)]
        parts.append(subprocess.Popen([sys.executable, "-m", "tests.storm", *words, *own]))
    return max(part.wait() for part in parts)


def _trials(arguments: argparse.Namespace, seed: int) -> int:
    nursery = Nursery()  # before there are threads
    from tests.storm.trial import Trial, run
    from tests.support.robot_pool import RobotPool

    luck = random.Random(seed)
    failed = moving = slow = done = 0
    longest, began = 0.0, time.monotonic()
    with RobotPool(full_graph=False) as pool:
        part, parts = arguments.part
        programs = every_verb()[part::parts] if arguments.all else None
        for number in range(arguments.trials if programs is None else len(programs)):
            if time.monotonic() - began > arguments.seconds:
                break
            program = _draw(luck, arguments.only) if programs is None else programs[number]
            trial = Trial.draw(luck, program)
            robot = pool.take(1.0)
            outcome = run(trial, robot, nursery)
            pool.give_back(robot)
            done += 1
            moving += outcome.moved
            slow += trial.slow
            longest = max(longest, outcome.seconds)
            if outcome.problem:
                failed += 1
                print(
                    f"--- seed {seed}, trial {number}: {trial}\n{outcome.problem}\n{outcome.said}", flush=True
                )
    nursery.close()
    print(
        f"seed {seed}: {done} trials, {moving} of them interrupted while the robot moved, {slow} on a slow "
        f"network; in {failed} the robot went on; the slowest program ended {longest:.1f} s after the first "
        "interrupt",
        flush=True,
    )
    return 1 if failed else 0


def _draw(luck: random.Random, only: str) -> Program:
    while True:
        program = draw(luck)
        if only in program.name:
            return program


if __name__ == "__main__":
    try:
        status = main()
    except Born as born:
        code = born.code
    else:
        sys.stdout.flush()
        sys.exit(status)
    exec(compile(code, "program", "exec"), {"__name__": "__main__"})
