"""What the chassis does about obstacles, and how fast it drives."""

from _robot import robot

from woosh_pure.enums import NavigationMode

with robot() as chassis:
    chassis.set_navigation_mode(NavigationMode.WAIT_THEN_AVOID, waiting_timeout=5.0, max_speed=0.4)
    print(chassis.go_to(1.0, 0.0).wait(timeout=60).sentence())
