"""Drive to a mark of the chassis's own map and wait for the arrival."""

from _robot import robot

from woosh_pure import GoalFailed, MotionRefused

with robot() as chassis:
    handle = chassis.go_to_mark("A1")
    handle.on_progress(lambda progress: print(f"  {progress.seconds:.1f} s, at {progress.pose}"))
    print(handle.wait(timeout=60).sentence())

    # Whatever is not an arrival is an exception; nothing can be mistaken for success.
    try:
        chassis.go_to_mark("no such mark").wait(timeout=60)
    except MotionRefused as refused:
        print("refused:", refused)
    except GoalFailed as failed:
        print("failed:", failed.outcome.kind)
