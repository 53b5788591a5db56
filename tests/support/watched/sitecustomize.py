"""Watches every Python that a test starts: Python imports this first, by PYTHONPATH."""

import hermetic  # in this folder, which is not a package here

hermetic.install_from_environment()
