"""`python -m woosh_pure` is the `woosh` command."""

import sys

from woosh_pure.cli import main

if __name__ == "__main__":
    sys.exit(main())
