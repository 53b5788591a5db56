"""Status codes in words, the set of active faults, and why the robot would not move."""

from _robot import robot

from woosh_pure.faults import decode_status_code

with robot() as chassis:
    readiness = chassis.readiness()
    print("ready:", readiness.answer, "-", readiness.sentence())  # yes, no, or not known
    print("active faults:", chassis.faults.sentence())

for number in (110201000013, 130103000012, 120301000202):
    code = decode_status_code(number)
    print(f"{number}: {code.level.name.lower()}: {code.english} / {code.chinese}")
