"""`python -m tests.benchmarks NAME [--busy N] [options]`: runs tests/benchmarks/NAME.py's `run(args)`.

A benchmark prints tables of ratios, all of one interleaved run, and fails on none of them. With `--busy N` as many
other processes compute all the while: users' machines are busy ones.
"""

from __future__ import annotations

import importlib
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


def main() -> int:
    folder = Path(__file__).parent
    names = sorted(p.stem for p in folder.glob("*.py") if not p.stem.startswith("_"))
    if len(sys.argv) < 2 or sys.argv[1] not in names:
        print(f"usage: python -m tests.benchmarks NAME [options]; NAME is one of: {', '.join(names)}")
        return 2
    name, *options = sys.argv[1:]
    spinning = 0
    if "--busy" in options:
        at = options.index("--busy")
        spinning = int(options[at + 1])
        del options[at : at + 2]
    with busy(spinning):
        result = importlib.import_module(f"tests.benchmarks.{name}").run(options)
    return int(result or 0)


@contextmanager
def busy(processes: int) -> Iterator[None]:
    """So many processes that compute, beside whatever is measured."""
    running = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(processes)]
    try:
        yield
    finally:
        for process in running:
            process.kill()
            process.wait(10)


if __name__ == "__main__":
    sys.exit(main())
