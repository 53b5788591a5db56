"""`python -m rosproto.rospy [options] program.py [arguments]`: the same as `rosproto run`."""

from __future__ import annotations

import sys

from rosproto.rospy.launch import main

sys.exit(main(sys.argv[1:]))
