"""`--help` is quick because nothing heavy is imported for it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from woosh_pure.cli.registry import COMMANDS

ROOT = Path(__file__).resolve().parents[3]
HEAVY = (
    "numpy",
    "lz4",
    "asyncio",
    "xml",
    "http",
    "ssl",
    "woosh_pure.sim",
    "woosh_pure.core",
)


def loaded_by(module: str, *words: str) -> set[str]:
    """Modules that are loaded once the command has printed its help."""
    code = (
        "import runpy, sys\n"
        "try: runpy.run_module(sys.argv.pop(1), run_name='__main__', alter_sys=True)\n"
        "except SystemExit: print('\\n' + ' '.join(sys.modules))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, module, *words],
        capture_output=True,
        text=True,
        encoding="utf-8",
        cwd=ROOT,
        timeout=60,
        check=True,
    )
    assert "usage:" in done.stdout
    return set(done.stdout.splitlines()[-1].split())


@pytest.mark.parametrize(
    "words", [(), *((name,) for name in COMMANDS)], ids=lambda words: " ".join(words) or "-"
)
def test_help_of_woosh_imports_nothing_heavy(words) -> None:
    loaded = loaded_by("woosh_pure", *words, "--help")
    assert sorted(loaded.intersection(HEAVY)) == []


def test_help_of_rosproto_imports_nothing_heavy() -> None:
    assert sorted(loaded_by("rosproto", "--help").intersection(HEAVY)) == []


@pytest.mark.slow
@pytest.mark.parametrize("module", ["woosh_pure", "rosproto"])
def test_help_takes_less_than_150_ms_of_the_processor_beyond_the_interpreter(module) -> None:
    """Processor time, because other tests run beside this one; the best of some tries."""
    resource = pytest.importorskip("resource", reason="Windows tells no processor time of children")

    def seconds(*words: str) -> float:
        tries = []
        for _ in range(5):
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run(
                [sys.executable, *words], stdout=subprocess.DEVNULL, cwd=ROOT, timeout=60, check=True
            )
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            tries.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
        return min(tries)

    assert seconds("-m", module, "--help") - seconds("-c", "pass") < 0.15
