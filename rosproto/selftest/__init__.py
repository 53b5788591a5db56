"""Checks of the installation, without a test tool and without a robot.

    for outcome in run(CHECKS):
        print(outcome.name, outcome.state.value, outcome.seconds, outcome.text)

`woosh selftest` runs these and drives a simulated chassis as well.
"""

from __future__ import annotations

from rosproto.selftest.checking import Check, CheckFailed, NotApplicable, Outcome, State, run
from rosproto.selftest.computing import check_bags, check_codec, check_definitions
from rosproto.selftest.nodes import check_master, check_nodes, check_ros

__all__ = ["CHECKS", "Check", "CheckFailed", "NotApplicable", "Outcome", "State", "run"]

CHECKS = (
    Check("definitions", check_definitions),
    Check("codec", check_codec),
    Check("master", check_master),
    Check("nodes", check_nodes),
    Check("bag", check_bags),
    Check("ros", check_ros),
)
"""In this order: each relies on those before it."""
