"""Any other action of the chassis: a lift, a roller, the towing hook ... with the generic client."""

from _robot import robot

from msgdefs.woosh_msgs.msg import LiftControlGoal

with robot() as chassis:
    goal = LiftControlGoal(mode=LiftControlGoal.EXCUTE, executeMode=LiftControlGoal.UP)
    handle = chassis.action("/lift_control", goal, timeout=30)
    print(handle.wait().sentence(), "result", handle.result.result)
