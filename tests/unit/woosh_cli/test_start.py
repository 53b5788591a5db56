"""`--help` is quick because nothing heavy is imported for it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from woosh_pure.cli.commands import COMMANDS

ROOT = Path(__file__).resolve().parents[3]
HEAVY = (
    "numpy",
    "lz4",
    "asyncio",
    "xml",
    "http.client",
    "ssl",
    "woosh_pure.sim",
    "woosh_pure.components",
)


SEVERAL = """
import runpy, sys
module, heavy, *commands = sys.argv[1:]
for words in commands:
    sys.argv[1:] = [*words.split(), "--help"]
    try: runpy.run_module(module, run_name="__main__", alter_sys=True)
    except SystemExit: pass
    found = sorted(set(heavy.split()) & set(sys.modules))
    if found: sys.exit(f"{module} {words} --help imports {found}")
"""


@pytest.mark.parametrize(("module", "commands"), [("woosh_pure", ["", *COMMANDS]), ("rosproto", [""])])
def test_help_imports_nothing_heavy(module, commands) -> None:
    """In one process: what no command imports, the sum of them does not either."""
    done = subprocess.run(
        [sys.executable, "-c", SEVERAL, module, " ".join(HEAVY), *commands],
        capture_output=True,
        text=True,
        encoding="utf-8",
        cwd=ROOT,
        timeout=60,
        check=False,
    )
    assert done.stderr == ""
    assert done.stdout.count("usage:") == len(commands)


@pytest.mark.parametrize(("module", "command"), [("woosh_pure", "ready"), ("rosproto", "topic list")])
def test_help_of_a_command_loads_no_sockets(module, command) -> None:
    """They come with the chassis, or the master, that it is asked for."""
    words = [sys.executable, "-c", SEVERAL, module, "socket rosproto.transport", command]
    done = subprocess.run(
        words, capture_output=True, text=True, encoding="utf-8", cwd=ROOT, timeout=60, check=False
    )
    assert done.stderr == ""


@pytest.mark.slow
@pytest.mark.parametrize("module", ["woosh_pure", "rosproto"])
def test_help_takes_less_than_300_ms_of_the_processor_beyond_the_interpreter(module) -> None:
    """Processor time, because other tests run beside this one; one try of some is enough: they make it dearer."""
    resource = pytest.importorskip("resource", reason="Windows tells no processor time of children")

    def seconds(*words: str) -> float:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, *words], stdout=subprocess.DEVNULL, cwd=ROOT, timeout=60, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return float(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)

    tries: list[float] = []
    while len(tries) < 20 and min(tries, default=1.0) >= 0.3:
        tries.append(seconds("-m", module, "--help") - seconds("-c", "pass"))
    assert min(tries) < 0.3
