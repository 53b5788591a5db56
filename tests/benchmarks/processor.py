"""Processor time of a start: of both commands' `--help`, and of a simulated chassis; beside a bare Python.

    python -m tests.benchmarks processor [--rounds 15] [--commands FOLDER] [--old TREE]

Part of `start`; needs no ROS. User and system time of the process, not the time that went by, so that it means
something on a busy machine, too. Every cell is the median over the rounds with the middle half of them; in a round
each program takes its turn. Code is compiled once, as pip does. With `--commands` the two commands are those of that
folder (of an environment with an installed wheel), run by its Python; else those of this one. With `--old` a simulated
chassis of another source tree takes its turn as well.
"""

from __future__ import annotations

import argparse
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[2]
SIMULATOR = """
import os, resource
def spent():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime
from woosh_pure.sim import SimulatedChassis
imported = spent()
sim = SimulatedChassis().start()
first = spent()
sim.close()
again = spent()
second = SimulatedChassis().start()
print(first, first - imported, spent() - again, flush=True)
os._exit(0)
"""
CHASSIS = ("process start to ready", "of that, start()", "a second start() in the process")


def run(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="tests.benchmarks processor")
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--commands", type=Path, default=Path(sys.executable).parent)
    parser.add_argument("--old", type=Path, help="another source tree")
    args = parser.parse_args(arguments)
    measure(args.rounds, args.commands, args.old)


def measure(rounds: int, commands: Path | None = None, old: Path | None = None) -> None:
    """Print both tables."""
    commands = commands or Path(sys.executable).parent
    python = str(commands / "python")
    programs: dict[str, list[str]] = {
        "python -c pass": [python, "-c", "pass"],
        "python -c 'import argparse'": [python, "-c", "import argparse"],
    }
    for line in ("woosh --help", "rosproto --help", "woosh ready --help", "rosproto topic list --help"):
        name, *words = line.split()
        if shutil.which(name, path=str(commands)):
            programs[line] = [str(commands / name), *words]
        module = {"woosh": "woosh_pure", "rosproto": "rosproto"}[name]
        if words == ["--help"]:
            programs[f"python -m {module} --help"] = [python, "-m", module, "--help"]
    trees = {"simulated chassis": None, **({"simulated chassis, old": old} if old else {})}
    with tempfile.TemporaryDirectory() as folder:
        spent: dict[str, list[float]] = {label: [] for label in programs}
        chassis: dict[tuple[str, str], list[float]] = {(t, part): [] for t in trees for part in CHASSIS}
        for number in range(rounds + 1):  # the first one compiles
            for label, words in programs.items():
                seconds = _processor_time(words, folder)
                if number:
                    spent[label].append(seconds)
            for label, tree in trees.items():
                found = _simulated(python, tree, folder)
                if number:
                    for part, seconds in zip(CHASSIS, found, strict=True):
                        chassis[label, part].append(seconds)
    bare = spent["python -c pass"]
    print(
        f"\nprocessor time, {python}, load {os.getloadavg()[0]:.1f}, {rounds} rounds: ms; ratio to a bare Python"
    )
    for label, values in spent.items():
        print(f"  {label:34} {_spread(values, 1e3)}   {_ratios(values, bare)}")
    for (label, part), values in chassis.items():
        print(f"  {label + ': ' + part:56} {_spread(values, 1e3)}")
    if old:
        for part in CHASSIS:
            ratio = _ratios(chassis["simulated chassis", part], chassis["simulated chassis, old", part])
            print(f"  {'new / old: ' + part:56} {ratio}")


def _processor_time(words: list[str], folder: str) -> float:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(
        words, stdout=subprocess.DEVNULL, timeout=60, check=True, cwd=folder, env=_environment(None)
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def _simulated(python: str, tree: Path | None, folder: str) -> list[float]:
    done = subprocess.run(
        [python, "-c", SIMULATOR],
        stdout=subprocess.PIPE,
        text=True,
        timeout=120,
        check=True,
        cwd=folder,
        env=_environment(tree),
    )
    return [float(word) for word in done.stdout.split()]


def _environment(tree: Path | None) -> dict[str, str]:
    """Of a user's shell: what this project's tests set is not in it, and compiled code is kept."""
    left_out = ("PYTHONDONTWRITEBYTECODE", "PYTHONPATH", "PYTHONUNBUFFERED", "COLUMNS")
    env = {name: value for name, value in os.environ.items() if name not in left_out}
    return env if tree is None else {**env, "PYTHONPATH": str(tree.resolve())}


def _spread(values: list[float], unit: float) -> str:
    low, middle, high = statistics.quantiles([value * unit for value in values], n=4, method="inclusive")
    return f"{middle:6.1f} ({low:.1f} to {high:.1f})"


def _ratios(values: list[float], to: list[float]) -> str:
    """Of each round's own, as all that the machine does beside falls on both."""
    return _spread([value / other for value, other in zip(values, to, strict=True)], 1.0).replace("  ", "")
