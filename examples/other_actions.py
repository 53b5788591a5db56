"""Roller, towing hook, charging contacts, fine positioning, docking: each by its own goal message."""

from _robot import robot

from msgdefs.woosh_msgs.msg import (
    AutoDock2Goal,
    ChargeControlGoal,
    LiftControl2Goal,
    LiftControl3Goal,
    RollerControlGoal,
    SecondPositionGoal,
    TractorControlGoal,
)

GOALS = {
    "/lift_control2": LiftControl2Goal(mode=LiftControl2Goal.EXCUTE, height=0.1),
    "/lift_control3": LiftControl3Goal(
        mode=LiftControl3Goal.EXCUTE, execmode=LiftControl3Goal.EXEC_ABSOLUTE, height=0.1
    ),
    "/roller1_control": RollerControlGoal(
        mode=RollerControlGoal.EXCUTE, executeMode=RollerControlGoal.FRONT_LOAD
    ),
    "/tractor_control": TractorControlGoal(
        mode=TractorControlGoal.EXCUTE, executeMode=TractorControlGoal.LOCK
    ),
    "/charge_control": ChargeControlGoal(mode=ChargeControlGoal.EXCUTE, executeMode=ChargeControlGoal.BACK),
    "/driver_base/second_position": SecondPositionGoal(
        mode=SecondPositionGoal.EXCUTE, executeMode=SecondPositionGoal.MAG_FRONT
    ),
    "/woosh_auto_dock": AutoDock2Goal(type=AutoDock2Goal.ENTER, dock_direction=AutoDock2Goal.BACKWARD),
}

with robot() as chassis:
    for name, goal in GOALS.items():
        handle = chassis.action(name, goal, timeout=60)
        print(handle.wait().sentence(), "- result", handle.result.result)
