"""Print the oldest numpy that this CPython has a wheel of; exit 1 when CPython is not to be tested.

Not tested: older than 3.10, and the version that `python3` is (it has run everything).
"""

import subprocess
import sys

OLDEST = {(3, 10): "1.22", (3, 11): "1.23", (3, 12): "1.26", (3, 13): "2.1", (3, 14): "2.3"}

own = sys.version_info[:2]
main = subprocess.run(["python3", "-c", "import sys; print(*sys.version_info[:2])"], stdout=subprocess.PIPE)
if own not in OLDEST or main.stdout.decode().split() == [str(part) for part in own]:
    sys.exit(1)
print(OLDEST[own])
