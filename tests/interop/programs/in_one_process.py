"""Runs the programs it is given one after the other: those that need no node of their own."""

import os
import runpy
import sys

for name in sys.argv[1:]:
    print("--", name, flush=True)
    runpy.run_path(os.path.join(os.path.dirname(os.path.abspath(__file__)), name), run_name="__main__")
