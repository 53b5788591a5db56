"""`python -m rosproto` is the `rosproto` command."""

from __future__ import annotations

import sys

from rosproto.cli import main

if __name__ == "__main__":
    sys.exit(main())
