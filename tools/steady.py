"""Repeats tests to find those that fail now and then.

`python -m tools.steady --rounds 30 -o steady.jsonl [PYTEST'S ARGUMENTS]`

A first round runs everything and notes the files whose tests start a thread or a process, or make a socket.
Only those can depend on the order of events, and only those are repeated: first on the computer as it is,
then beside processes that keep its processors busy. Each round has another order. At the end, each test that
failed is printed with the number of its failures and the last line of one of them; `-o` keeps every failure
whole, one JSON object a line.

Exits with 1 if a test has failed.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
TOUCHING, FAILURES, ROUND = "STEADY_TOUCHING", "STEADY_FAILURES", "STEADY_ROUND"
_EVENTS = ("_thread.start_new_thread", "socket.__new__", "subprocess.Popen", "os.fork", "os.posix_spawn")
_SPIN = "while True: pass"
_begun: set[str] = set()


# -- As a plugin of pytest, in each of its processes ---------------------------------------------------------


def pytest_configure(config: pytest.Config) -> None:
    """Begin to note which tests start something."""
    if TOUCHING in os.environ:
        sys.addaudithook(lambda event, arguments: _begun.add(event) if event in _EVENTS else None)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Note the file of a test in which something was started, fixtures included."""
    _begun.clear()
    result = yield
    if TOUCHING in os.environ and (_begun or threading.active_count() > 2):  # xdist has a thread of its own
        _append(os.environ[TOUCHING], {"file": item.nodeid.partition("::")[0]})
    return result


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Keep a failure; in the process that collects the reports, not in its workers."""
    if report.failed and FAILURES in os.environ and "PYTEST_XDIST_WORKER" not in os.environ:
        text = report.longreprtext
        _append(
            os.environ[FAILURES],
            {"round": os.environ[ROUND], "test": report.nodeid, "when": report.when, "text": text},
        )


def _append(path: str, row: dict[str, object]) -> None:
    with open(path, "a", encoding="utf-8") as file:
        file.write(json.dumps(row) + "\n")


# -- As a command --------------------------------------------------------------------------------------------


def main() -> int:
    """Run the rounds; print what failed."""
    parser = argparse.ArgumentParser(prog="python -m tools.steady", description=__doc__)
    parser.add_argument("--rounds", type=int, default=30, help="rounds alone, and as many beside (30)")
    parser.add_argument("--beside", type=int, default=2, help="processes that spin in the second half (2)")
    parser.add_argument("--phases", default="alone,beside", help="alone, beside, or both (alone,beside)")
    parser.add_argument("-o", "--output", type=Path, help="keeps the failures whole, as JSON lines")
    given, words = parser.parse_known_args()
    with tempfile.TemporaryDirectory() as folder:
        failures = given.output or Path(folder, "failures")
        failures.touch()
        touching = Path(folder, "touching")
        _run("all", words, failures, {TOUCHING: str(touching)})
        files = sorted({row["file"] for row in _rows(touching)}) if touching.exists() else []
        print(f"{len(files)} files start threads or processes, or make sockets", flush=True)
        options = [word for word in words if not Path(word.partition("::")[0]).exists()]
        for phase in given.phases.split(","):
            with _spinning(given.beside if phase == "beside" else 0):
                for number in range(1, given.rounds + 1):
                    print(
                        f"{phase} {number}: {_run(f'{phase} {number}', [*options, *files], failures)}",
                        flush=True,
                    )
        return _summary(_rows(failures))


def _run(name: str, words: list[str], failures: Path, more: dict[str, str] | None = None) -> str:
    """One round; its last line."""
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "tools.steady", "-p", "no:cacheprovider", *words],
        cwd=ROOT,
        env={**os.environ, FAILURES: str(failures), ROUND: name, **(more or {})},
        stdout=subprocess.PIPE,
        text=True,
    )
    return done.stdout.strip().splitlines()[-1] if done.stdout.strip() else f"exit code {done.returncode}"


def _rows(path: Path) -> list[dict[str, str]]:
    return [json.loads(line) for line in path.read_text("utf-8").splitlines()]


@contextmanager
def _spinning(count: int) -> Iterator[None]:
    spinning = [subprocess.Popen([sys.executable, "-c", _SPIN]) for _ in range(count)]
    try:
        yield
    finally:
        for process in spinning:
            process.kill()
            process.wait()


def _summary(rows: list[dict[str, str]]) -> int:
    for test in sorted({row["test"] for row in rows}):
        failed = [row for row in rows if row["test"] == test]
        phases = [row["round"].partition(" ")[0] for row in failed]
        counts = ", ".join(f"{phase} {phases.count(phase)}" for phase in sorted(set(phases)))
        print(f"{test}: {counts}; {(failed[0]['text'].strip().splitlines() or [''])[-1]}")
    print(f"{len({row['test'] for row in rows})} tests failed at least once")
    return 1 if rows else 0


if __name__ == "__main__":
    raise SystemExit(main())
