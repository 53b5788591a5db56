"""Every Python that a test starts runs this first (it is in its PYTHONPATH): it is watched as the tests are."""

import hermetic  # beside this file, which is not in a package there

hermetic.install_from_environment()
