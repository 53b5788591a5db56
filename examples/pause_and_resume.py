"""Hold a task or a precise move, and go on with what remains."""

from _robot import robot

with robot(speed=1.0) as chassis:
    task = chassis.go_to_mark("A1")
    task.pause()
    chassis.measured_velocity.wait_for(lambda v: v.is_standing(), timeout=10)
    task.resume()
    print(task.wait(timeout=60).sentence())

    move = chassis.move(0.8)
    for report in move.reports():
        if report.percent > 30:
            break
    move.pause()
    print("left:", *move.remaining())
    move.resume()
    print(move.wait(timeout=60).sentence())
