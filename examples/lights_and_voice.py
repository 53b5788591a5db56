"""Light strips by named state and by colour, and the voice."""

from _robot import robot

from woosh_pure.enums import LedState

with robot() as chassis:
    chassis.light(LedState.TASK_RUNNING)
    chassis.light(color=(255, 128, 0), strip="shelf")
    chassis.say("你好")
    print("lights set, text spoken")
