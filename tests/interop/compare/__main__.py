"""`python -m tests.interop.compare --seconds N [--seed S] [--only KIND]`: see comparison.py."""

from __future__ import annotations

import argparse
import random
import sys

from tests.interop.compare.everything import NAMES, run


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.interop.compare")
    parser.add_argument("--seconds", type=float, default=60.0, help="for all kinds together (60)")
    parser.add_argument("--seed", type=int, help="of the random inputs; printed when not given")
    parser.add_argument("--only", action="append", choices=NAMES, help="only this kind; repeatable")
    parser.add_argument("--enough", type=int, default=10, help="end after this many differences (10)")
    parser.add_argument("--first", type=int, default=0, help="begin with this number of the seed")
    arguments = parser.parse_args()
    seed = random.randrange(2**32) if arguments.seed is None else arguments.seed
    print(f"seed {seed}", flush=True)
    report = run(
        seed=seed,
        seconds=arguments.seconds,
        only=arguments.only,
        enough=arguments.enough,
        first=arguments.first,
    )
    print(report)
    return 1 if report.found else 0


if __name__ == "__main__":
    sys.exit(main())
