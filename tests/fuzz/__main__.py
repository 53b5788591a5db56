"""`python -m tests.fuzz --seconds N [--target NAME]`: see tests/fuzz/harness.py."""

from __future__ import annotations

import argparse
import importlib.util
import random
import sys

from tests.fuzz import harness


def main() -> int:
    targets, tokens = harness.load()
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=harness.__doc__)
    parser.add_argument("--seconds", type=float, default=10.0, help="for each target (default 10)")
    parser.add_argument(
        "--target", action="append", choices=sorted(targets), help="only this one; repeatable"
    )
    parser.add_argument("--seed", type=int, help="of the random mutations; printed when not given")
    parser.add_argument("--plain", action="store_true", help="the plain loop even where atheris is installed")
    parser.add_argument("--list", action="store_true", help="name the targets")
    arguments = parser.parse_args()
    if arguments.list:
        print("\n".join(sorted(targets)))
        return 0
    chosen = arguments.target or sorted(targets)
    if not arguments.plain and len(chosen) == 1 and importlib.util.find_spec("atheris"):
        harness.fuzz_with_atheris(targets[chosen[0]], chosen[0], arguments.seconds)
    seed = random.randrange(2**32) if arguments.seed is None else arguments.seed
    print(f"seed {seed}")
    failed = False
    for name in chosen:
        try:
            runs = harness.fuzz(
                name, targets[name], tokens.get(name, []), seed=seed, seconds=arguments.seconds
            )
        except harness.Finding as finding:
            harness.report(finding)
            failed = True
        else:
            print(f"{name}: {runs} inputs, nothing found")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
