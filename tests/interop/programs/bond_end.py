"""One end of a bond: bond_end.py NAME break|shutdown|die|stay|alone SECONDS: a sister that is silent for so long is dead."""

import os
import sys

import rospy
from bondpy.bondpy import Bond

name, what, silence = sys.argv[1:]
rospy.init_node("end_" + name)
told = []
bond = Bond("/bond", "the id", lambda: told.append("broken"), lambda: told.append("formed"))
bond.heartbeat_timeout = float(silence)
bond.disconnect_timeout = 20.0
bond.heartbeat_period = 0.3
bond.connect_timeout = 1.0 if what == "alone" else 20.0
bond.start()
told.append(bond.wait_until_formed(rospy.Duration(30)))
if what in ("stay", "alone"):
    told.append(bond.wait_until_broken(rospy.Duration(30)))
else:
    rospy.sleep(1.5)
if what == "break":
    bond.break_bond()
    told.append(bond.wait_until_broken(rospy.Duration(30)))
if what == "shutdown":
    bond.shutdown()
if what != "die":
    rospy.sleep(0.5)
    told.append(bond.is_broken())
    told.append(repr(bond).partition(" (")[2])
print(sorted(map(str, told)))
sys.stdout.flush()
if what == "die":
    os._exit(0)
bond.shutdown()
