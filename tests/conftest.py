"""No test is slow without saying so: over five seconds it needs `@pytest.mark.slow`; CI fails it.

Interop tests start other programs and are excused. What a busy machine adds is forgiven threefold.
"""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest

SLOW_SECONDS = 5.0
PATIENCE = 3.0  # machines are noisy, and two workers share them with what the tests start


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> Iterator[None]:
    """Fail a passing test that took longer than it may."""
    outcome = yield
    report = outcome.get_result()  # type: ignore[attr-defined]
    if os.environ.get("CI", "").lower() not in ("1", "true") or call.when != "call" or not report.passed:
        return
    if any(item.get_closest_marker(name) for name in ("slow", "interop")):
        return
    if call.duration > SLOW_SECONDS * PATIENCE:
        report.outcome = "failed"
        report.longrepr = (
            f"{item.nodeid} took {call.duration:.1f} s without a mark; tests without one end in {SLOW_SECONDS:g} s"
            f" (times {PATIENCE:g}, because machines are noisy): make it faster, or mark it @pytest.mark.slow"
        )
