"""Runs the same random inputs through Debian's tools and through ours, and compares the answers.

A `Kind` draws cases from a seeded generator and asks ours: a command or function of this process, or our layer for
existing programs (`asked.py` under `rosproto run`). Debian's answer comes from `asked.py` under Debian's Python.
Each is one process for all cases, since it is slow to start. Where the answers differ, `differences.py` must have
the reason.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import random
import subprocess
import sys
import threading
import time
from abc import ABC, abstractmethod
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tests.support import ros

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]
Case = Any
Answer = Any
ERROR = "error"
ANSWER_SECONDS = 60.0  # for one case


class Peer:
    """A process that answers cases; to be used in a `with`. It is ended when a case takes more than `seconds`."""

    def __init__(self, command: list[str], env: Mapping[str, str], seconds: float | None = None) -> None:
        self._seconds = seconds
        self._command, self._env = [*command, str(HERE / "asked.py")], dict(env)
        self._process = self._start()

    def _start(self) -> subprocess.Popen[str]:
        return subprocess.Popen(
            self._command,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=self._env,
            start_new_session=True,
        )  # fmt: skip

    def ask(self, kind: str, case: Case) -> Answer:
        """Return the answer to a case; an error when the process does not answer in time, or has ended."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        seconds = self._seconds or ANSWER_SECONDS
        limit = threading.Timer(seconds, self._process.kill)
        limit.start()
        try:
            self._process.stdin.write(json.dumps([kind, case]) + "\n")
            self._process.stdin.flush()
            line = self._process.stdout.readline()
        except BrokenPipeError:
            line = ""
        finally:
            limit.cancel()
        if line:
            return json.loads(line)
        self._close()
        self._process = self._start()
        return {ERROR: "ended", "says": f"no answer within {seconds:g} s, or the process has ended"}

    def _close(self) -> None:
        with contextlib.suppress(OSError):
            if self._process.stdin is not None:
                self._process.stdin.close()
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait(10)
        if self._process.stdout is not None:
            self._process.stdout.close()

    def __enter__(self) -> Peer:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self._close()


def debian(master_uri: str, packages: Path | str | None = None, seconds: float | None = None) -> Peer:
    """Debian's packages, under Debian's Python."""
    return Peer([ros.PYTHON], ros.environment(master_uri, packages=packages), seconds)


def layer(master_uri: str) -> Peer:
    """Our packages of the same names."""
    return Peer([sys.executable, "-m", "rosproto", "run"], ros.environment(master_uri, packages=ROOT))


class Kind(ABC):
    """One kind of inputs.

    Attributes:
        asked: The function of asked.py that answers for Debian.
        peer: A process of Debian's for this kind alone; None takes the one of all kinds.
    """

    asked: str
    peer: Peer | None = None

    @property
    def name(self) -> str:
        """The name on the command line."""
        return type(self).__name__

    @abstractmethod
    def draw(self, chance: random.Random) -> Case:
        """Return a case that JSON can carry."""

    @abstractmethod
    def ours(self, case: Case) -> Answer:
        """Return our answer."""

    def theirs(self, case: Case, peer: Peer) -> Answer:
        """Return Debian's answer."""
        return peer.ask(self.asked, case)

    def same(self, theirs: Answer, ours: Answer) -> bool:
        """Whether two answers are alike."""
        return bool(without_texts(theirs) == without_texts(ours))


def without_texts(answer: Answer) -> Answer:
    """Replace errors by one word: their texts are our own."""
    if isinstance(answer, dict):
        return ERROR if ERROR in answer else {key: without_texts(item) for key, item in answer.items()}
    return [without_texts(item) for item in answer] if isinstance(answer, list) else answer


@dataclass
class Difference:
    """A difference on purpose.

    Attributes:
        kind: Name of the kind.
        reason: Why it is there.
        covers: Whether it explains the answers to a case: case, theirs, ours.
    """

    kind: str
    reason: str
    covers: Callable[[Case, Answer, Answer], bool]


@dataclass
class Report:
    """The outcome.

    Attributes:
        rounds: How often all kinds had their turn.
        inputs: Number of cases of each kind.
        seconds: What they took together.
        documented: How often each documented difference was met.
        found: Differences without a reason, as text.
    """

    rounds: int = 0
    inputs: Counter[str] = field(default_factory=Counter)
    seconds: defaultdict[str, float] = field(default_factory=lambda: defaultdict(float))
    documented: Counter[str] = field(default_factory=Counter)
    found: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        lines = [
            f"{name}: {count} inputs, {self.seconds[name]:.1f} s"
            for name, count in sorted(self.inputs.items())
        ]
        lines += [f"{count} times, on purpose: {reason}" for reason, count in self.documented.most_common()]
        lines.append(f"{sum(self.inputs.values())} inputs, {len(self.found)} differences without a reason")
        return "\n".join([*lines, *self.found])


def compare(
    kinds: list[Kind],
    differences: list[Difference],
    peer: Peer,
    *,
    seed: int,
    seconds: float,
    enough: int = 10,
    first: int = 0,
    rounds: int = 10**9,
) -> Report:
    """Draw cases of all kinds in turn, from number `first`, until these rounds or the time are over, or `enough`
    differences are found.
    """
    report = Report()
    end = time.monotonic() + seconds
    for number in range(first, first + rounds):
        for kind in kinds:
            if time.monotonic() > end or len(report.found) >= enough:
                return report
            began = time.monotonic()
            case = kind.draw(random.Random(f"{seed} {kind.name} {number}"))
            report.inputs[kind.name] += 1
            theirs, ours = kind.theirs(case, kind.peer or peer), kind.ours(case)
            report.seconds[kind.name] += time.monotonic() - began
            if kind.same(theirs, ours):
                continue
            known = [d.reason for d in differences if d.kind == kind.name and d.covers(case, theirs, ours)]
            if known:
                report.documented[known[0]] += 1
            else:
                report.found.append(
                    f"{kind.name}, seed {seed}, number {number}:\n  case   {_short(case)}\n"
                    f"  Debian {_short(theirs)}\n  ours   {_short(ours)}"
                )
        report.rounds += 1
    return report


def _short(value: object) -> str:
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) < 3000 else text[:3000] + "..."


@contextlib.contextmanager
def environment(**values: str) -> Iterator[None]:
    """Set variables of the environment for a while."""
    before = dict(os.environ)
    os.environ.update(values)
    try:
        yield
    finally:
        os.environ.clear()
        os.environ.update(before)


def run_command(*words: str, stdin: str = "") -> Answer:
    """The outcome of our command, run in this process: as `run_main` of asked.py."""
    from rosproto.cli import main

    out, err = io.StringIO(), io.StringIO()
    before = sys.stdin
    sys.stdin = io.StringIO(stdin)
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = main(list(words))
    except SystemExit as end:
        code = int(end.code or 0)
    finally:
        sys.stdin = before
    if code:
        return {"error": "exit", "code": code, "says": err.getvalue()[:300]}
    return {"out": out.getvalue(), "err": err.getvalue()[:300]}
