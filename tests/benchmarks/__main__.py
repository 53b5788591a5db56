"""`python -m tests.benchmarks NAME [options]`: runs tests/benchmarks/NAME.py's `run(args)`.

A benchmark prints tables of ratios, all of one interleaved run, and fails on none of them.
"""

from __future__ import annotations

import importlib
import sys
from pathlib import Path


def main() -> int:
    folder = Path(__file__).parent
    names = sorted(p.stem for p in folder.glob("*.py") if not p.stem.startswith("_"))
    if len(sys.argv) < 2 or sys.argv[1] not in names:
        print(f"usage: python -m tests.benchmarks NAME [options]; NAME is one of: {', '.join(names)}")
        return 2
    result = importlib.import_module(f"tests.benchmarks.{sys.argv[1]}").run(sys.argv[2:])
    return int(result or 0)


if __name__ == "__main__":
    sys.exit(main())
