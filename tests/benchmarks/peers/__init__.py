"""The processes that tests/benchmarks/transport.py measures; each role exists for ours, rospy and roscpp."""
