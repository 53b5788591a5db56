"""Programs written for rospy, unchanged: `import rospy`, `from woosh_msgs.msg import ...` and so on.

Three ways in: `rosproto run program.py`, `python -m rosproto.rospy program.py`, and the line
`import rosproto.rospy.install` at the top of a program. Each makes the packages in `modules/` importable
under their ROS names, in front of installed ones, and message packages from definitions. No other part of
rosproto imports this: like rospy, the layer controls its process (signals, one node, the environment,
`logging`).

The files in `modules/` have ROS names and are loaded under them, so that tracebacks, pickles and `except
rospy.exceptions.ROSException` are as programs expect. Source of their behaviour: rospy 1.15, actionlib
1.14, genpy 0.6, tf2_ros 0.7, as measured.
"""

from __future__ import annotations

from rosproto.rospy.finder import serve
from rosproto.rospy.launch import run_at, run_program

__all__ = ["run_at", "run_program", "serve"]
